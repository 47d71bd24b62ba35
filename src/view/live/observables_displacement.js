const MOST_TRACERS = 1000;
const MOST_ORIGINS = 16;

/** Number of origins for short lag times, and number of samples between two origins. */
const YOUNG_ORIGINS = 8;
const YOUNG_STRIDE = 4;

const LAGS_PER_DECADE = 48;
const DECADES = [-12, 12];
const LAG_BINS = LAGS_PER_DECADE * (DECADES[1] - DECADES[0]);

/**
 * Mean squared displacement and velocity autocorrelation of each species, averaged over several time origins.
 * If the velocity of the centre of mass along an axis is conserved, displacements and velocities are relative to the
 * centre of mass.
 */
class Displacement {
  constructor(system) {
    this.system = system;
    const { head, moving, freeAxes, masses, totalMass, conserved, count } = system;
    const present = [...new Set(Array.from(moving, (id) => head.particles[id]))].sort((a, b) => a - b);
    this.names = present.length <= 3 ? present.map((index) => head.species[index].name) : ["all"];
    const stride = Math.ceil(count / MOST_TRACERS);
    // The tracers of a group are contiguous in the arrays.
    const groups = present.length <= 3 ? present.map((index) => [index]) : [present];
    const members = groups.map((group) => moving.filter((id) => group.includes(head.particles[id])));
    const followed = members.map((ids) => ids.filter((_, n) => ids.length < 200 || n % stride === 0));
    this.tracers = Uint32Array.from(followed.flatMap((ids) => [...ids]));
    this.numbers = followed.map((ids) => ids.length);
    this.axes = freeAxes;
    this.isRelative = freeAxes.map((k) => conserved[k] && count > 1);
    // Relative to the centre of mass of mass M, a particle of mass m moves less. The factor is 1 / (1 - m / M).
    this.factors = followed.map((ids) => {
      const part = ids.reduce((sum, id) => sum + masses[id], 0) / ids.length / totalMass;
      return this.isRelative.map((is) => (is ? 1 / (1 - part) : 1));
    });
    // Columns of a bin: number of samples, sum of lag times, and two sums for each group.
    this.columns = 2 + 2 * this.names.length;
    this.sums = new LateSums(LAG_BINS * this.columns);
    this.origins = [];
    this.young = [];
    this.spacing = 0;
    this.samples = 0;
    this.shortest = Infinity;
  }

  frame(numbers, images) {
    const { system, tracers, axes } = this;
    const { totalMass, size } = system;
    const out = new Float64Array(tracers.length * axes.length);
    for (let column = 0; column < axes.length; column += 1) {
      const k = axes[column];
      const common = this.isRelative[column] ? this.moment(k, numbers, images) / totalMass : 0;
      for (let n = 0; n < tracers.length; n += 1) {
        const at = 3 * tracers[n] + k;
        out[column * tracers.length + n] = (images ? numbers[at] + images[at] * size[k] : numbers[at]) - common;
      }
    }
    return out;
  }

  /** Returns the mass-weighted sum of a component over the moving particles. */
  moment(k, numbers, images) {
    const { moving, masses, size } = this.system;
    const edge = images ? size[k] : 0;
    let sum = 0;
    for (let n = 0; n < moving.length; n += 1) {
      const at = 3 * moving[n] + k;
      sum += masses[moving[n]] * (edge > 0 ? numbers[at] + images[at] * edge : numbers[at]);
    }
    return sum;
  }

  sample(time, { positions, velocities, images }) {
    const now = { time, positions: this.frame(positions, images), velocities: this.frame(velocities) };
    if (this.sums.turn(time)) {
      const { from } = this.sums;
      this.origins = this.origins.filter((origin) => origin.time >= from);
      this.young = this.young.filter((origin) => origin.time >= from);
    }
    for (const origin of new Set([...this.origins, ...this.young])) {
      this.compare(origin, now);
    }
    this.begin(now);
  }

  begin(now) {
    const last = this.origins[this.origins.length - 1];
    if (!last || now.time - last.time >= this.spacing * (1 - 1e-9)) {
      this.origins.push(now);
    }
    if (this.origins.length > MOST_ORIGINS) {
      this.origins = this.origins.filter((_, k) => k % 2 === 0);
      this.spacing = this.origins[1].time - this.origins[0].time;
    }
    if (this.samples % YOUNG_STRIDE === 0) {
      this.young.push(now);
      this.young.splice(0, this.young.length - YOUNG_ORIGINS);
    }
    this.samples += 1;
  }

  compare(origin, now) {
    const lag = now.time - origin.time;
    const bin = Math.round(LAGS_PER_DECADE * (Math.log10(lag) - DECADES[0]));
    if (!(bin >= 0 && bin < LAG_BINS)) {
      return;
    }
    const { newer } = this.sums;
    const first = bin * this.columns;
    newer[first] += 1;
    newer[first + 1] += lag;
    let begin = 0;
    this.numbers.forEach((number, group) => {
      this.axes.forEach((_, column) => {
        const from = column * this.tracers.length + begin;
        const factor = this.factors[group][column] / number;
        newer[first + 2 + 2 * group] += factor * squares(now.positions, origin.positions, from, from + number);
        newer[first + 3 + 2 * group] += factor * products(now.velocities, origin.velocities, from, from + number);
      });
      begin += number;
    });
  }

  results() {
    const { sums, columns, names } = this;
    const bins = Array.from({ length: LAG_BINS }, (_, bin) => bin * columns).filter((first) => sums.total(first) > 0);
    const mean = (k) => Float64Array.from(bins, (first) => sums.total(first + k) / sums.total(first));
    const t = mean(1);
    const msd = names.map((_, group) => mean(2 + 2 * group));
    const vacf = names.map((_, group) => mean(3 + 2 * group));
    const diffusion = msd.map((values) => this.slope(t, values));
    return { t, msd, vacf, names, dimensions: this.axes.length, diffusion, since: sums.from };
  }

  /**
   * Returns the diffusion coefficient: the slope divided by 2 d. It is NaN if the slope still changes with the lag
   * time.
   * Lag times longer than a third of the longest one have few origins and are excluded.
   */
  slope(t, values) {
    const last = t[t.length - 1];
    const used = Array.from(t.keys()).filter((k) => t[k] > last / 16 && t[k] < last / 3);
    if (used.length < 8) {
      return NaN;
    }
    const rate = (indices) =>
      fittedSlope(
        indices.map((k) => t[k]),
        indices.map((k) => values[k]),
      );
    const middle = 0.5 * (t[used[0]] + t[used[used.length - 1]]);
    const [short, long] = [rate(used.filter((k) => t[k] <= middle)), rate(used.filter((k) => t[k] > middle))];
    return Math.abs(short - long) < 0.1 * Math.abs(long) ? rate(used) / (2 * this.axes.length) : NaN;
  }
}

function fittedSlope(x, y) {
  const [a, b] = [x, y].map((list) => list.reduce((sum, value) => sum + value, 0) / list.length);
  const square = x.reduce((sum, value) => sum + (value - a) ** 2, 0);
  return x.reduce((sum, value, k) => sum + (value - a) * (y[k] - b), 0) / square;
}

function squares(a, b, from, to) {
  let sum = 0;
  for (let k = from; k < to; k += 1) {
    const difference = a[k] - b[k];
    sum += difference * difference;
  }
  return sum;
}

function products(a, b, from, to) {
  let sum = 0;
  for (let k = from; k < to; k += 1) {
    sum += a[k] * b[k];
  }
  return sum;
}

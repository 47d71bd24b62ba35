const MOST_INTERVALS = 120;

/**
 * Pressure of a periodic box, P V = N T + W / (D t), where W is the sum of r_ij . J over the pair events in a time t.
 * T is the kinetic temperature, 2 (K - P^2 / 2M) / (D N - c). T is interpolated linearly between samples.
 */
class Pressure {
  constructor(system) {
    this.system = system;
    // Virial, and time integral of the temperature.
    this.series = new TimeSeries(2);
    this.before = undefined;
    this.integral = 0;
    this.range = [Infinity, -Infinity];
  }

  sample(time, virial, temperature) {
    if (this.before) {
      this.integral += 0.5 * (time - this.before.time) * (temperature + this.before.temperature);
    }
    this.range = [Math.min(this.range[0], temperature), Math.max(this.range[1], temperature)];
    this.before = { time, temperature };
    this.series.add(time, [virial, this.integral]);
  }

  between([times, virials, integrals], from, to) {
    const { dimensions, count, volume } = this.system;
    const collisional = (virials[to] - virials[from]) / dimensions;
    return (count * (integrals[to] - integrals[from]) + collisional) / (volume * (times[to] - times[from]));
  }

  results(expected) {
    const series = this.series.read();
    const times = series[0];
    const last = times.length - 1;
    if (last < 1) {
      return { t: new Float64Array(), p: new Float64Array(), mean: NaN, error: NaN, from: times[0], expected };
    }
    const ends = intervalsOf(times);
    const p = Float64Array.from(ends.slice(1), (end, k) => this.between(series, ends[k], end));
    const t = Float64Array.from(ends.slice(1), (end, k) => 0.5 * (times[ends[k]] + times[end]));
    const half = Math.max(0, ends.findIndex((end) => times[end] >= 0.5 * (times[0] + times[last])) - 1);
    const mean = this.between(series, ends[half], last);
    return { t, p, mean, error: Pressure.scatter(p.subarray(half)), since: times[ends[half]], from: times[0], expected };
  }

  /** Returns the standard error of the mean from up to eight blocks, or NaN for fewer than four blocks. */
  static scatter(values) {
    const number = Math.min(8, values.length);
    const blocks = Array.from({ length: number }, (_, k) => {
      const block = values.subarray(Math.floor((k * values.length) / number), Math.floor(((k + 1) * values.length) / number));
      return block.reduce((sum, value) => sum + value, 0) / block.length;
    });
    const mean = blocks.reduce((sum, value) => sum + value, 0) / number;
    const square = blocks.reduce((sum, value) => sum + (value - mean) ** 2, 0);
    return number < 4 ? NaN : Math.sqrt(square / (number * (number - 1)));
  }

  /** Returns the compressibility factor of a fluid of hard rods, disks or spheres, or NaN for dense systems. */
  static compressibility(fraction, dimensions) {
    if (dimensions === 1) {
      // L. Tonks, Phys. Rev. 50, 955 (1936).
      return 1 / (1 - fraction);
    }
    if (dimensions === 2) {
      // D. Henderson, Mol. Phys. 30, 971 (1975).
      return fraction < 0.7 ? (1 + fraction ** 2 / 8) / (1 - fraction) ** 2 : NaN;
    }
    // N. F. Carnahan and K. E. Starling, J. Chem. Phys. 51, 635 (1969).
    return fraction < 0.494 ? (1 + fraction + fraction ** 2 - fraction ** 3) / (1 - fraction) ** 3 : NaN;
  }

  /** Returns the theoretical pressure of hard spheres, or NaN for any other system. */
  expected(counts, radial) {
    const { head, moving, count, dimensions, volume } = this.system;
    const species = new Set(Array.from(moving, (id) => head.particles[id]));
    const [coldest, hottest] = this.range;
    const isElastic = hottest - coldest < 1e-9 * hottest;
    const isHard = head.hardSpheres ?? (counts?.core > 0 && !counts.capture && !counts.release && !counts.bounce && !counts.bond);
    if (species.size !== 1 || !isElastic || !isHard) {
      return NaN;
    }
    const diameter = head.species[[...species][0]].diameter * (radial?.scale ?? 1);
    if (!head.hardSpheres && !hasContactAt(radial, diameter)) {
      return NaN;
    }
    const size = [0, diameter, (Math.PI / 4) * diameter ** 2, (Math.PI / 6) * diameter ** 3][dimensions];
    const fraction = (count * size) / volume;
    return ((count * hottest) / volume) * Pressure.compressibility(fraction, dimensions);
  }
}

/** Returns the indices of the samples between the averaging intervals, which have about equal durations. */
function intervalsOf(times) {
  const last = times.length - 1;
  const shortest = (0.999 * (times[last] - times[0])) / MOST_INTERVALS;
  const ends = [last];
  for (let k = last - 1; k >= 0; k -= 1) {
    if (times[ends[ends.length - 1]] - times[k] >= shortest) {
      ends.push(k);
    }
  }
  return ends.reverse();
}

function hasContactAt(radial, diameter) {
  if (!radial) {
    return false;
  }
  const { r, g } = radial.results();
  const first = g[0].findIndex((value) => value > 0);
  return first >= 0 && Math.abs(r[first] - 0.5 * radial.width - diameter) < 1.5 * radial.width;
}

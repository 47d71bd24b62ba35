/** Number of speed bins, and largest speed in units of sqrt(T / m). */
const SPEED_BINS = 50;
const FASTEST = 5;

/** Returns the Maxwell density of speeds, for velocity components of variance 1. */
function maxwellDensity(x, dimensions) {
  const power = [0, Math.sqrt(2 / Math.PI), x, Math.sqrt(2 / Math.PI) * x * x][dimensions];
  return power * Math.exp(-0.5 * x * x);
}

/**
 * Present distribution of speeds, average distribution over the later part of the run, and kinetic temperature.
 * Along axes with a conserved momentum, speeds are relative to the centre of mass. They are divided by the standard
 * deviation of a velocity component at equilibrium, sqrt((1 - m / M) T / m). This scaling gives one curve for different
 * masses, and for a gas that cools.
 */
class Speeds {
  constructor(system) {
    this.system = system;
    this.now = new Float64Array(SPEED_BINS);
    // The counts of the speed bins, followed by the number of all speeds.
    this.sums = new LateSums(SPEED_BINS + 1);
    this.scale = 1;
    this.speeds = new Float64Array(system.count);
    this.temperature = 0;
  }

  /** Returns the variance of a velocity component as a fraction of T / m, averaged over the axes. */
  free(mass) {
    const { conserved, dimensions, totalMass, count } = this.system;
    return count < 2 ? 1 : 1 - (conserved.filter(Boolean).length / dimensions) * (mass / totalMass);
  }

  /** Returns the velocity of the centre of mass along the axes on which it is conserved. */
  drift(velocities) {
    const { conserved, moving, masses, totalMass, count } = this.system;
    let x = 0;
    let y = 0;
    let z = 0;
    for (let n = 0; n < count; n += 1) {
      const id = moving[n];
      const mass = masses[id];
      x += mass * velocities[3 * id];
      y += mass * velocities[3 * id + 1];
      z += mass * velocities[3 * id + 2];
    }
    return [x, y, z].map((momentum, k) => (conserved[k] && count > 1 ? momentum / totalMass : 0));
  }

  sample(time, velocities) {
    const { system, now } = this;
    const { moving, masses, totalMass, count } = system;
    const [x, y, z] = this.drift(velocities);
    const { speeds } = this;
    let doubled = 0;
    for (let n = 0; n < count; n += 1) {
      const at = 3 * moving[n];
      const u = velocities[at] - x;
      const v = velocities[at + 1] - y;
      const w = velocities[at + 2] - z;
      const square = u * u + v * v + w * w;
      doubled += masses[moving[n]] * square;
      speeds[n] = Math.sqrt(square);
    }
    this.temperature = doubled / system.freedom;
    now.fill(0);
    if (!(this.temperature > 0) || totalMass === 0) {
      return;
    }
    this.sums.turn(time);
    const { newer } = this.sums;
    let mass = -1;
    let factor = 0;
    for (let n = 0; n < count; n += 1) {
      if (masses[moving[n]] !== mass) {
        mass = masses[moving[n]];
        this.scale = Math.sqrt((this.free(mass) * this.temperature) / mass);
        factor = SPEED_BINS / FASTEST / this.scale;
      }
      const bin = Math.floor(speeds[n] * factor);
      if (bin < SPEED_BINS) {
        now[bin] += 1;
        newer[bin] += 1;
      }
    }
    newer[SPEED_BINS] += count;
  }

  /** Returns densities by speed at the present temperature, or by reduced speed if the masses differ. */
  results() {
    const { system, sums } = this;
    const scale = system.hasOneMass ? this.scale : 1;
    const width = (FASTEST / SPEED_BINS) * scale;
    const all = sums.total(SPEED_BINS);
    const even = (length, value) => Float64Array.from({ length }, (_, k) => value(k));
    // In gravity, speeds do not follow Maxwell's distribution.
    const finely = system.isHeavy ? 0 : 4 * SPEED_BINS + 1;
    const speed = (k) => (k / 4) * (width / scale);
    return {
      isReduced: !system.hasOneMass,
      temperature: this.temperature,
      centres: even(SPEED_BINS, (k) => (k + 0.5) * width),
      now: even(SPEED_BINS, (k) => this.now[k] / (system.count * width)),
      density: even(SPEED_BINS, (k) => sums.total(k) / (all * width)),
      speed: even(finely, (k) => speed(k) * scale),
      maxwell: even(finely, (k) => maxwellDensity(speed(k), system.dimensions) / scale),
      since: sums.from,
    };
  }
}

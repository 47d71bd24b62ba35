/** Longest time that the engine runs before other messages are heard `[ms]`. */
const SLICE = 8;

/** Aim for a single call of the engine `[ms]`. */
const PORTION = 3;

/** How far the simulated time may lag behind the wanted one before that is given up `[ms]`. */
const LAG = 60;

/** The time that a simulation should have reached: a wanted speed from an anchor on, which moves when the engine cannot keep it. */
class Pace {
  constructor() {
    this.speed = 1;
    this.events = 64;
    this.isLate = false;
    this.rates = [];
  }

  /** Counts from here on. */
  anchor(now, time) {
    this.at = now;
    this.time = time;
  }

  goal(now) {
    return this.speed === Infinity ? Infinity : this.time + (this.speed * (now - this.at)) / 1000;
  }

  /** Adapts how many events a call of the engine is given to what the last one took. */
  adapt(isUsedUp, spent) {
    if (spent > 2 * PORTION) {
      this.events = Math.max(1, Math.floor(this.events / 2));
    } else if (isUsedUp && spent < PORTION / 2) {
      this.events = Math.min(this.events * 2, 1e6);
    }
  }

  /** Notes where the simulation is; gives up what cannot be made up for. */
  note(now, time) {
    this.isLate = this.speed !== Infinity && this.goal(now) - time > (this.speed * LAG) / 1000;
    if (this.isLate) {
      this.lateAt = now;
      this.anchor(now, time);
    }
  }

  /** Events and simulated time per second over the last half second. */
  rate(now, { events, time }) {
    const { rates } = this;
    rates.push([now, events, time]);
    while (rates.length > 2 && now - rates[1][0] > 500) {
      rates.shift();
    }
    const [since, first, start] = rates[0];
    const seconds = (now - since) / 1000;
    return seconds > 0.05 ? { rate: (events - first) / seconds, pace: (time - start) / seconds } : { rate: 0, pace: 0 };
  }
}

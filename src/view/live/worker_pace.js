/** Longest time for which the engine runs between messages `[ms]`. */
const SLICE = 8;

/** Target duration of a call of the engine `[ms]`. */
const PORTION = 3;

/** Largest lag behind the requested speed; a larger lag is dropped `[ms]`. */
const LAG = 60;

/**
 * Target time of a simulation. It advances from an anchor at the requested speed. If the engine cannot keep up, the
 * anchor moves.
 */
class Pace {
  constructor() {
    this.speed = 1;
    this.events = 64;
    this.isLate = false;
    this.rates = [];
  }

  /** Sets the anchor to a wall time and a simulated time. */
  anchor(now, time) {
    this.at = now;
    this.time = time;
  }

  goal(now) {
    return this.speed === Infinity ? Infinity : this.time + (this.speed * (now - this.at)) / 1000;
  }

  /** Adapts the number of events per call of the engine to the duration of the last call. */
  adapt(isUsedUp, spent) {
    if (spent > 2 * PORTION) {
      this.events = Math.max(1, Math.floor(this.events / 2));
    } else if (isUsedUp && spent < PORTION / 2) {
      this.events = Math.min(this.events * 2, 1e6);
    }
  }

  /** Records the simulated time, and drops a lag that is too large. */
  note(now, time) {
    this.isLate = this.speed !== Infinity && this.goal(now) - time > (this.speed * LAG) / 1000;
    if (this.isLate) {
      this.lateAt = now;
      this.anchor(now, time);
    }
  }

  /** Returns events and simulated time per second over the last half second. */
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

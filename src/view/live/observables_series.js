/** Most points of a series over time. */
const MOST_POINTS = 2000;

/** A series over time of bounded length: when it is full, every other point goes, and from then on as many less come. */
class TimeSeries {
  constructor(columns, most = MOST_POINTS) {
    this.most = most;
    this.columns = Array.from({ length: columns + 1 }, () => new Float64Array(most));
    this.length = 0;
    this.stride = 1;
    this.passed = 0;
    this.last = undefined;
  }

  /** Takes note of values at a time; the last ones are always there. */
  add(time, values) {
    this.last = [time, ...values];
    if (this.passed % this.stride === 0) {
      if (this.length === this.most) {
        this.thin();
      }
      this.columns.forEach((column, k) => (column[this.length] = this.last[k]));
      this.length += 1;
    }
    this.passed += 1;
  }

  thin() {
    this.length = Math.ceil(this.length / 2);
    this.columns.forEach((column) => {
      for (let k = 1; k < this.length; k += 1) {
        column[k] = column[2 * k];
      }
    });
    this.stride *= 2;
    this.passed = this.length * this.stride;
  }

  /** Times and values so far, each an array of its own. */
  read() {
    const hasMore = this.length > 0 && this.last[0] > this.columns[0][this.length - 1];
    return this.columns.map((column, k) => {
      const values = new Float64Array(this.length + (hasMore ? 1 : 0));
      values.set(column.subarray(0, this.length));
      if (hasMore) {
        values[this.length] = this.last[k];
      }
      return values;
    });
  }
}

/** The last points of a series over time, at full resolution. */
class RecentSeries {
  constructor(columns, most = MOST_POINTS) {
    this.most = most;
    this.columns = Array.from({ length: columns + 1 }, () => new Float64Array(most));
    this.count = 0;
  }

  add(time, values) {
    const place = this.count % this.most;
    this.columns.forEach((column, k) => (column[place] = k === 0 ? time : values[k - 1]));
    this.count += 1;
  }

  read() {
    const place = this.count % this.most;
    return this.columns.map((column) => {
      if (this.count <= this.most) {
        return column.slice(0, this.count);
      }
      const values = new Float64Array(this.most);
      values.set(column.subarray(place));
      values.set(column.subarray(0, place), this.most - place);
      return values;
    });
  }
}

/**
 * Sums over the later part of the time so far, so that what was before equilibrium is forgotten.
 *
 * There are two windows, one after the other. When the newer one is twice as long as the older one, the older one goes: between a half and two thirds
 * of the time is left, and the sums over it go on growing.
 */
class LateSums {
  constructor(length) {
    this.older = new Float64Array(length);
    this.newer = new Float64Array(length);
    this.from = undefined;
    this.middle = undefined;
  }

  /** Time of the next sample; true if older sums went. */
  turn(time) {
    if (this.from === undefined) {
      this.from = time;
      this.middle = time;
      return false;
    }
    if (this.middle === this.from) {
      // The initial value is dropped at the second sample.
      this.middle = time;
      [this.older, this.newer] = [this.newer, this.older.fill(0)];
      return false;
    }
    if (time - this.middle < 2 * (this.middle - this.from)) {
      return false;
    }
    [this.older, this.newer] = [this.newer, this.older.fill(0)];
    [this.from, this.middle] = [this.middle, time];
    return true;
  }

  total(k) {
    return this.older[k] + this.newer[k];
  }
}

const MOST_POINTS = 2000;

/** A time series of bounded length. Once it is full, every other point is removed and the sampling stride doubles. */
class TimeSeries {
  constructor(columns, most = MOST_POINTS) {
    this.most = most;
    this.columns = Array.from({ length: columns + 1 }, () => new Float64Array(most));
    this.length = 0;
    this.stride = 1;
    this.passed = 0;
    this.last = undefined;
  }

  /** The last values are always kept. */
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
 * Sums over the later part of a run.
 * There are two consecutive windows. Once the newer window is twice as long as the older one, the older one is dropped.
 * The sums always cover at least half of the time so far.
 */
class LateSums {
  constructor(length) {
    this.older = new Float64Array(length);
    this.newer = new Float64Array(length);
    this.from = undefined;
    this.middle = undefined;
  }

  /** Records the time of the next sample. Returns true if the older window was dropped. */
  turn(time) {
    if (this.from === undefined) {
      this.from = time;
      this.middle = time;
      return false;
    }
    if (this.middle === this.from) {
      // The second sample starts the newer window. The older window then contains only the initial sample.
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

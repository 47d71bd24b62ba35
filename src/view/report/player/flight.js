// Positions of particles between two frames.

/**
 * Returns the displacement along a cubic curve at fraction `s` of an interval. `way` is the total displacement, and
 * `first` and `last` are the slopes at the ends.
 */
const cubic = (way, first, last, s) => s * (first + s * (3 * way - 2 * first - last + s * (first + last - 2 * way)));

/** Limits a slope so that a cubic curve stays between its ends. */
const bounded = (slope, way) => (way > 0 ? Math.min(Math.max(slope, 0), 3 * way) : Math.max(Math.min(slope, 0), 3 * way));

/**
 * Computes states between frames. Particles in free flight are on their exact line or parabola. The positions of other
 * particles are known only in the frames. These particles move on a smooth curve that does not overshoot.
 */
class Between {
  constructor(recording) {
    this.recording = recording;
    this.intervals = new Map();
    this.curves = { index: -1 };
  }

  /** Returns the displacements of all particles from a frame to the next; undefined for the last frame. */
  interval(index) {
    const { recording, intervals } = this;
    if (index < 0 || index + 1 >= recording.length) {
      return undefined;
    }
    let found = intervals.get(index);
    if (!found) {
      const [frame, next] = [recording.frame(index), recording.frame(index + 1)];
      const from = recording.positions(frame);
      const ways = this.ways(from, recording.positions(next), next.head);
      found = { from, ways, flights: frame.flights, fall: recording.head.falls[frame.head.fall], time: next.head.time - frame.head.time };
      intervals.set(index, found);
      // Interpolation uses three intervals.
      if (intervals.size > 4) {
        intervals.delete(intervals.keys().next().value);
      }
    }
    return found;
  }

  ways(from, to, { size, displacement }) {
    const { periodic } = this.recording;
    const ways = new Float32Array(from.length);
    for (let k = 0; k < from.length; k += 3) {
      const up = periodic[1] ? -Math.round((to[k + 1] - from[k + 1]) / size[1]) : 0;
      for (let axis = 0; axis < 3; axis += 1) {
        const way = to[k + axis] - from[k + axis] + (axis === 0 ? up * displacement : 0);
        ways[k + axis] = periodic[axis] ? way - size[axis] * Math.round(way / size[axis]) : way;
      }
    }
    return ways;
  }

  /** Returns the number of particles in free flight from a frame to the next. */
  count(index) {
    const interval = this.interval(index);
    return interval ? interval.flights.reduce((sum, isFlight) => sum + isFlight, 0) : 0;
  }

  /**
   * Returns the speed at the boundary with a neighbouring interval, as a displacement per interval. `side` is -1 for
   * the earlier neighbour, and 1 for the later one.
   */
  speed(interval, neighbour, k, side) {
    if (!neighbour || neighbour.time <= 0 || neighbour.ways[k] !== neighbour.ways[k]) {
      return interval.ways[k];
    }
    if (neighbour.flights[Math.floor(k / 3)]) {
      const half = (neighbour.fall[this.recording.species[Math.floor(k / 3)]]?.[k % 3] ?? 0) * neighbour.time * 0.5;
      return (neighbour.ways[k] / neighbour.time - side * half) * interval.time;
    }
    return ((interval.ways[k] + neighbour.ways[k]) / (interval.time + neighbour.time)) * interval.time;
  }

  /** Returns the slopes of all paths at both ends of an interval, in displacements per interval. */
  slopes(index) {
    if (this.curves.index !== index) {
      const [before, interval, after] = [this.interval(index - 1), this.interval(index), this.interval(index + 1)];
      const { ways, flights, fall, time } = interval;
      const [first, last] = [new Float32Array(ways.length), new Float32Array(ways.length)];
      for (let k = 0; k < ways.length; k += 1) {
        if (flights[Math.floor(k / 3)]) {
          const half = 0.5 * (fall[this.recording.species[Math.floor(k / 3)]]?.[k % 3] ?? 0) * time * time;
          first[k] = ways[k] - half;
          last[k] = ways[k] + half;
        } else {
          first[k] = bounded(this.speed(interval, before, k, -1), ways[k]);
          last[k] = bounded(this.speed(interval, after, k, 1), ways[k]);
        }
      }
      this.curves = { index, first, last };
    }
    return this.curves;
  }

  /** Returns the state at fraction `s` of an interval, with the colours of its first frame. */
  state(index, s, channel) {
    const { recording } = this;
    const [frame, next] = [recording.head.frames[index], recording.head.frames[index + 1]];
    const { first, last } = this.slopes(index);
    const { from, ways, time } = this.interval(index);
    const displacement = frame.displacement + recording.head.slide * s * time;
    const positions = new Float32Array(from.length);
    for (let k = 0; k < from.length; k += 1) {
      // A particle that is missing in the next frame does not move.
      const way = cubic(ways[k], first[k], last[k], s);
      positions[k] = from[k] + (way === way ? way : 0);
    }
    wrap(positions, frame, recording.periodic, displacement);
    const poses = posesBetween(frame.poses ?? [], next.poses ?? [], s);
    const turns = turnsBetween(recording.frame(index).turns, recording.frame(index + 1).turns, s);
    return { ...recording.state(recording.frame(index), channel), positions, turns, displacement, poses };
  }
}

/** Returns orientations at fraction `s` between two frames, along the shorter of the two rotations. */
function turnsBetween(from, to, s) {
  if (!from || !to) {
    return from;
  }
  const turns = new Int8Array(from.length);
  for (let k = 0; k < from.length; k += 4) {
    const product = from[k] * to[k] + from[k + 1] * to[k + 1] + from[k + 2] * to[k + 2] + from[k + 3] * to[k + 3];
    // The angle between two quaternions of length 127.
    const angle = Math.acos(Math.min(Math.abs(product) / (127 * 127), 1));
    const sine = Math.sin(angle);
    const [first, last] = sine > 1e-3 ? [Math.sin((1 - s) * angle) / sine, Math.sin(s * angle) / sine] : [1 - s, s];
    for (let part = k; part < k + 4; part += 1) {
      turns[part] = Math.round(first * from[part] + (product < 0 ? -last : last) * to[part]);
    }
  }
  return turns;
}

function wrap(positions, { lower, size }, periodic, displacement) {
  for (let k = 0; k < positions.length; k += 3) {
    for (const axis of [1, 0, 2]) {
      if (periodic[axis]) {
        const periods = Math.floor((positions[k + axis] - lower[axis]) / size[axis]);
        positions[k + axis] -= periods * size[axis];
        positions[k] -= axis === 1 ? periods * displacement : 0;
      }
    }
  }
}

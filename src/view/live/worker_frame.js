/** Relative round-off of a velocity. */
const ROUNDING = 1e-9;

/** Picture data: positions of the moving particles, contacts since the last picture, and colours. */
class Frames {
  constructor(head, state) {
    this.head = head;
    this.moving = Uint32Array.from(head.particles.keys()).filter((id) => !head.species[head.particles[id]].isStatic);
    this.neighbours = new Neighbours(head);
    this.counts = new Uint8Array(head.particles.length);
    this.before = Float64Array.from(state.velocities);
    this.beforeTime = state.time;
    this.beforeEvents = state.events;
    this.fastest = 0;
    this.startTones = this.startingPlaces(state.positions);
    this.pool = [];
  }

  /** Axis that colours the starting positions: the axis of gravity, or else the longest axis. */
  get axis() {
    const { gravity, size } = this.head;
    const lengths = gravity.some((part) => part !== 0) ? gravity.map(Math.abs) : size;
    return lengths.indexOf(Math.max(...lengths));
  }

  startingPlaces(positions) {
    const places = Array.from(this.moving, (id) => positions[3 * id + this.axis]);
    const low = places.reduce((least, place) => Math.min(least, place), Infinity);
    const high = places.reduce((most, place) => Math.max(most, place), -Infinity);
    this.starts = [low, high];
    return Uint8Array.from(places, (place) => (high > low ? Math.round((255 * (place - low)) / (high - low)) : 128));
  }

  reuse(buffers) {
    this.pool.push(...buffers.filter((buffer) => buffer.byteLength > 0));
    this.pool.splice(0, Math.max(0, this.pool.length - 16));
  }

  room(Type, length) {
    const bytes = Type.BYTES_PER_ELEMENT * length;
    const index = this.pool.findIndex((buffer) => buffer.byteLength === bytes);
    return new Type(index < 0 ? new ArrayBuffer(bytes) : this.pool.splice(index, 1)[0]);
  }

  /** Returns the picture data of a state. The colours show a channel: species, speed, neighbours or history. */
  frame(state, channel) {
    const { moving } = this;
    const positions = this.room(Float32Array, 3 * moving.length);
    const velocities = this.room(Float32Array, 3 * moving.length);
    for (let k = 0; k < moving.length; k += 1) {
      const at = 3 * moving[k];
      for (let axis = 0; axis < 3; axis += 1) {
        positions[3 * k + axis] = state.positions[at + axis];
        velocities[3 * k + axis] = state.velocities[at + axis];
      }
    }
    const { time, events, kinetic, potential, stage, isOver, counts, displacement, scale: growth } = state;
    const numbers = { time, events, kinetic, potential, stage, isOver, counts, displacement, growth };
    const frame = { kind: "frame", ...numbers, positions, velocities, hits: this.hits(state) };
    return Object.assign(frame, this.tones(state, channel));
  }

  /** Marks the particles whose velocity a contact has changed since the last picture. */
  hits(state) {
    const { moving, before } = this;
    const { velocities, time, events, acceleration } = state;
    const hits = this.room(Uint8Array, moving.length);
    const [x, y, z] = acceleration.map((part) => part * (time - this.beforeTime));
    let count = 0;
    const isChanged = (at) => {
      const [now, then] = [velocities, before];
      const change = Math.abs(now[at] - then[at] - x) + Math.abs(now[at + 1] - then[at + 1] - y) + Math.abs(now[at + 2] - then[at + 2] - z);
      return change > ROUNDING * (Math.abs(now[at]) + Math.abs(now[at + 1]) + Math.abs(now[at + 2]) + gained);
    };
    const gained = Math.abs(x) + Math.abs(y) + Math.abs(z);
    for (let k = 0; k < moving.length; k += 1) {
      hits[k] = isChanged(3 * moving[k]) ? 1 : 0;
      count += hits[k];
    }
    // An event usually changes at most two velocities. If more have changed, the contacts are unknown, and no particle
    // is marked.
    if (count > 2 * (events - this.beforeEvents)) {
      hits.fill(0);
    }
    before.set(velocities);
    this.beforeTime = time;
    this.beforeEvents = events;
    return hits;
  }

  /** Ignores earlier changes of velocity, for example after a kick by the user. */
  skip(state) {
    this.before.set(state.velocities);
    this.beforeTime = state.time;
    this.beforeEvents = state.events;
  }

  tones(state, channel) {
    const { moving } = this;
    if (channel === "species") {
      return {};
    }
    const tones = this.room(Uint8Array, moving.length);
    if (channel === "history") {
      tones.set(this.startTones);
      return { tones, scale: { channel, low: this.starts[0], high: this.starts[1], axis: this.axis } };
    }
    if (channel === "neighbours") {
      this.neighbours.count(state.positions, this.counts);
      const high = this.head.flat.some(Boolean) ? 6 : 12;
      for (let k = 0; k < moving.length; k += 1) {
        tones[k] = Math.min(255, Math.round((255 * this.counts[moving[k]]) / high));
      }
      return { tones, scale: { channel, low: 0, high } };
    }
    return { tones, scale: { channel, low: 0, high: this.speedTones(state.velocities, tones) } };
  }

  /**
   * Computes the colours of speeds. The upper end of the scale slowly follows the root mean square, and is returned.
   */
  speedTones(velocities, tones) {
    const { moving } = this;
    const speed = (at) => Math.hypot(velocities[at], velocities[at + 1], velocities[at + 2]);
    let squares = 0;
    for (const id of moving) {
      squares += speed(3 * id) ** 2;
    }
    const wanted = 2.2 * Math.sqrt(squares / Math.max(moving.length, 1));
    this.fastest = this.fastest > 0 ? this.fastest + 0.03 * (wanted - this.fastest) : wanted;
    const scale = this.fastest > 0 ? 255 / this.fastest : 0;
    for (let k = 0; k < moving.length; k += 1) {
      tones[k] = Math.min(255, Math.round(speed(3 * moving[k]) * scale));
    }
    return this.fastest;
  }
}

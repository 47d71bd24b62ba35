/** Largest size of the cache of decoded frames, in bytes. */
const CACHE = 1 << 26;

/** Colour choices that are not the index of a channel. */
const SPECIES = -1;
const FLIGHT = -2;

/** Colour indices of particles that fly freely until the next frame, and of other particles. */
const FREE = 235;
const HINDERED = 80;

const element = (id) => document.getElementById(`player-${id}`);

/** A trajectory in the format of `src/view/report/recording.rs`. */
class Recording {
  constructor() {
    this.head = JSON.parse(element("head").textContent);
    const { moving, fixed, bonds, channels, flat, periodic, surfaces } = this.head;
    Object.assign(this, { moving, fixed, bonds, flat, periodic, count: moving + fixed });
    const bytes = decoded(element("constants").textContent).buffer;
    let offset = 0;
    const take = (Type, length) => {
      const taken = new Type(bytes, offset, length);
      offset += taken.byteLength;
      return taken;
    };
    this.radii = take(Float32Array, this.count);
    this.fixedPositions = take(Float32Array, 3 * fixed);
    this.bondEnds = take(Uint32Array, 2 * bonds);
    this.bondRadii = take(Float32Array, bonds);
    this.species = take(Uint8Array, this.count);
    this.surfaces = surfaces && { ...surfaces, bytes: decoded(element("surface-data").textContent) };
    this.coordinateBytes = Math.ceil((6 * moving) / 4) * 4;
    this.turnBytes = this.head.hasTurns ? 4 * moving : 0;
    this.flightBytes = Math.ceil(moving / 8);
    this.frameBytes = this.coordinateBytes + this.turnBytes + channels.length * moving + this.flightBytes;
    // Number of frames per text element, as in src/view/report/motion.rs.
    this.framesPerChunk = Math.max(1, Math.ceil((1 << 18) / Math.max(this.frameBytes, 1)));
    this.chunks = new Map();
  }

  get length() {
    return this.head.frames.length;
  }

  /**
   * Returns a frame: coordinates in steps of the field, orientations as quaternions in 1/127 (undefined without
   * spins), bytes of each channel, and free flights until the next frame.
   */
  frame(index) {
    const number = Math.floor(index / this.framesPerChunk);
    const bytes = this.chunk(number);
    const start = (index - number * this.framesPerChunk) * this.frameBytes;
    const steps = new Uint16Array(bytes.buffer.slice(start, start + this.coordinateBytes), 0, 3 * this.head.moving);
    const channels = this.head.channels.map((_, k) => {
      const first = start + this.coordinateBytes + this.turnBytes + k * this.head.moving;
      return bytes.subarray(first, first + this.head.moving);
    });
    const turnStart = bytes.byteOffset + start + this.coordinateBytes;
    const turns = this.head.hasTurns ? new Int8Array(bytes.buffer, turnStart, this.turnBytes) : undefined;
    const bits = start + this.frameBytes - this.flightBytes;
    const flights = Uint8Array.from({ length: this.head.moving }, (_, k) => (bytes[bits + (k >> 3)] >> (k & 7)) & 1);
    return { steps, turns, channels, flights, head: this.head.frames[index] };
  }

  chunk(number) {
    let bytes = this.chunks.get(number);
    if (!bytes) {
      bytes = decoded(element(`frames-${number}`).textContent);
      this.chunks.set(number, bytes);
      const most = Math.max(2, Math.floor(CACHE / Math.max(bytes.length, 1)));
      if (this.chunks.size > most) {
        this.chunks.delete(this.chunks.keys().next().value);
      }
    }
    return bytes;
  }

  /** Returns the positions of the particles of a frame. A missing particle is at NaN. */
  positions({ steps, head }) {
    const [lower, size] = head.field;
    const positions = new Float32Array(steps.length);
    for (let k = 0; k < steps.length; k += 1) {
      positions[k] = steps[k] === 65535 ? NaN : lower[k % 3] + (steps[k] / 65534) * size[k % 3];
    }
    return positions;
  }

  /** Returns a frame for the renderer, coloured by a channel, by free flights (FLIGHT) or by species (SPECIES). */
  state(frame, channel) {
    const { turns, channels, flights, head } = frame;
    const { low, high } = this.head.channels[channel] ?? { low: 0, high: 1 };
    return {
      positions: this.positions(frame),
      turns,
      tones: channel === FLIGHT ? flights.map((isFlight) => (isFlight ? FREE : HINDERED)) : channels[channel],
      range: head.ranges[channel],
      scale: [low, high],
      box: head,
      displacement: head.displacement,
      poses: head.poses,
    };
  }
}

// The data of the page.

/** The most bytes of frames that are kept after they were decoded. */
const CACHE = 1 << 26;

const element = (id) => document.getElementById(`player-${id}`);

function decoded(text) {
  if (Uint8Array.fromBase64) {
    return Uint8Array.fromBase64(text);
  }
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k += 1) {
    bytes[k] = letters.charCodeAt(k);
  }
  return bytes;
}

/** A trajectory as `src/report/recording.rs` describes it. */
class Recording {
  constructor() {
    this.head = JSON.parse(element("head").textContent);
    const { moving, fixed, bonds, channels } = this.head;
    this.count = moving + fixed;
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
    this.coordinateBytes = Math.ceil((6 * moving) / 4) * 4;
    this.frameBytes = this.coordinateBytes + channels.length * moving;
    // As many frames share an element as src/report/motion.rs puts into one.
    this.framesPerChunk = Math.max(1, Math.ceil((1 << 18) / Math.max(this.frameBytes, 1)));
    this.chunks = new Map();
  }

  get length() {
    return this.head.frames.length;
  }

  /** Coordinates in steps of the field, and the bytes of each channel. */
  frame(index) {
    const number = Math.floor(index / this.framesPerChunk);
    const bytes = this.chunk(number);
    const start = (index - number * this.framesPerChunk) * this.frameBytes;
    const steps = new Uint16Array(bytes.buffer.slice(start, start + this.coordinateBytes), 0, 3 * this.head.moving);
    const channels = this.head.channels.map((_, k) => {
      const first = start + this.coordinateBytes + k * this.head.moving;
      return bytes.subarray(first, first + this.head.moving);
    });
    return { steps, channels, head: this.head.frames[index] };
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

  /** Where a particle is in a frame. */
  position(frame, index) {
    const { moving } = this.head;
    if (index >= moving) {
      return this.fixedPositions.subarray(3 * (index - moving), 3 * (index - moving) + 3);
    }
    const [lower, size] = frame.head.field;
    return [0, 1, 2].map((k) => lower[k] + (frame.steps[3 * index + k] / 65534) * size[k]);
  }

  /** Both halves of each bond: the shortest way, which may lead through a side of the box. */
  rods(frame) {
    const count = this.head.bonds;
    const rods = new Float32Array(14 * count);
    for (let bond = 0; bond < count; bond += 1) {
      const a = this.position(frame, this.bondEnds[2 * bond]);
      const b = this.position(frame, this.bondEnds[2 * bond + 1]);
      // In a sheared box the image beyond a side along y is displaced along x.
      const rise = b[1] - a[1];
      const slid = this.head.periodic[1] && Math.abs(rise) > frame.head.size[1] / 2;
      const displacement = slid ? Math.sign(rise) * frame.head.displacement : 0;
      for (let k = 0; k < 3; k += 1) {
        let way = b[k] - a[k] - (k === 0 ? displacement : 0);
        if (this.head.periodic[k] && Math.abs(way) > frame.head.size[k] / 2) {
          way -= Math.sign(way) * frame.head.size[k];
        }
        rods[14 * bond + k] = a[k];
        rods[14 * bond + 3 + k] = a[k] + way / 2;
        rods[14 * bond + 7 + k] = b[k] - way / 2;
        rods[14 * bond + 10 + k] = b[k];
      }
      rods[14 * bond + 6] = this.bondRadii[bond];
      rods[14 * bond + 13] = this.bondRadii[bond];
    }
    return rods;
  }
}

// The engine in JavaScript: an instance of the module, with the calls of web/engine/src/lib.rs under the same
// names.

/** Numbers before the positions, and where each is. */
const HEADER = 24;

const ENDS = ["events", "time", "idle", "failed", "end"];

/** A simulation. A trap of the module, such as the end of memory, is an error of JavaScript: the instance cannot be used any more. */
class Engine {
  /** Of a module that is compiled, or of its bytes. */
  static async of(module) {
    const made = await WebAssembly.instantiate(module, {});
    return new Engine((made.instance ?? made).exports);
  }

  constructor(calls) {
    this.calls = calls;
  }

  get message() {
    const bytes = new Uint8Array(this.calls.memory.buffer, this.calls.message(), this.calls.message_length());
    return JSON.parse(new TextDecoder().decode(bytes));
  }

  ask(call, request) {
    // Unpaired surrogates do not exist in UTF-8. They become the replacement character, as in a file.
    const whole = (_, value) => (typeof value === "string" ? value.replace(/\p{Surrogate}/gu, "\ufffd") : value);
    const bytes = new TextEncoder().encode(JSON.stringify(request, whole));
    const at = this.calls.room(bytes.length);
    new Uint8Array(this.calls.memory.buffer, at, bytes.length).set(bytes);
    call();
    return this.message;
  }

  /** Gives scenes a file that they may name. */
  bring(name, content) {
    const letters = new TextEncoder().encode(name);
    const at = this.calls.room(letters.length + content.length);
    const room = new Uint8Array(this.calls.memory.buffer, at);
    room.set(letters);
    room.set(content, letters.length);
    this.calls.bring(letters.length);
  }

  /**
   * Starts a scene from its text, with other values `{"fill.0.temperature": "2"}`: what there is in it, or an error with its line, its cure, and its
   * offset and length in bytes.
   */
  start(text, changes = {}) {
    return this.ask(this.calls.start, { text, changes });
  }

  /** An error as that of `start`, or nothing; the simulation stays. */
  check(text, changes = {}) {
    return this.ask(this.calls.check, { text, changes });
  }

  /** Goes on from the present positions and velocities with another scene: what there is in it, or an error, and the simulation goes on as it was. */
  change(text, changes = {}) {
    return this.ask(this.calls.change, { text, changes });
  }

  /** Runs on for events, or until a time; one of ENDS. */
  advance(events, time = Infinity) {
    return ENDS[this.calls.advance(events, time)];
  }

  /** The state now; positions, velocities and images are views that hold until the next call. */
  look() {
    const count = this.calls.look();
    const { buffer } = this.calls.memory;
    const numbers = new Float64Array(buffer, this.calls.numbers(), count);
    const [time, events, kinetic, potential, virial, stage, isOver, displacement, scale, ax, ay, az, ...rest] = numbers.subarray(0, HEADER);
    const [core, capture, release, bounce, wall, thermostat, dissipated, supplied] = rest;
    const coordinates = (count - HEADER) / 2;
    return {
      time, events, kinetic, potential, virial, stage, isOver: isOver === 1, displacement, scale, dissipated, supplied,
      acceleration: [ax, ay, az],
      counts: { core, capture, release, bounce, wall, thermostat },
      positions: numbers.subarray(HEADER, HEADER + coordinates),
      velocities: numbers.subarray(HEADER + coordinates),
      images: new Int32Array(buffer, this.calls.images(), coordinates),
    };
  }

  /** Puts a particle elsewhere, or gives it another velocity; null leaves it. An error, or an empty text. */
  set(id, position, velocity) {
    return this.ask(this.calls.set, { id, position, velocity }).error ?? "";
  }

  /** The next events: time, kind, particles a and b (null for a wall), place of a. */
  upcoming(count) {
    this.calls.upcoming(count);
    return this.message;
  }

  /** Where the surfaces are: as the poses of a recording's frame. */
  poses() {
    this.calls.poses();
    return this.message;
  }

  /** The text with the present positions and velocities in place of those it begins with, or an error. */
  scene(text) {
    return this.ask(this.calls.scene, { text });
  }
}

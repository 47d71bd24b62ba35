// An instance of the WebAssembly module. The calls have the names in web/engine/src/lib.rs.

const HEADER = 24;

const ENDS = ["events", "time", "idle", "failed", "end"];

/** A simulation. A trap of the module, such as the end of memory, throws an error. The instance is then unusable. */
class Engine {
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
    // UTF-8 cannot represent unpaired surrogates.
    const whole = (_, value) => (typeof value === "string" ? value.replace(/\p{Surrogate}/gu, "\ufffd") : value);
    const bytes = new TextEncoder().encode(JSON.stringify(request, whole));
    const at = this.calls.room(bytes.length);
    new Uint8Array(this.calls.memory.buffer, at, bytes.length).set(bytes);
    call();
    return this.message;
  }

  /** Adds an input file of scenes. */
  bring(name, content) {
    const letters = new TextEncoder().encode(name);
    const at = this.calls.room(letters.length + content.length);
    const room = new Uint8Array(this.calls.memory.buffer, at);
    room.set(letters);
    room.set(content, letters.length);
    this.calls.bring(letters.length);
  }

  /**
   * Starts a scene, with changed values such as `{"fill.0.temperature": "2"}`. Returns the content of the scene, or an
   * error with its line, its remedy, and its offset and length in bytes.
   */
  start(text, changes = {}) {
    return this.ask(this.calls.start, { text, changes });
  }

  /** Returns the error that `start` would return. The simulation is unchanged. */
  check(text, changes = {}) {
    return this.ask(this.calls.check, { text, changes });
  }

  /**
   * Continues with another scene from the present positions and velocities. Returns the content of the scene, or an
   * error. After an error, the simulation is unchanged.
   */
  change(text, changes = {}) {
    return this.ask(this.calls.change, { text, changes });
  }

  advance(events, time = Infinity) {
    return ENDS[this.calls.advance(events, time)];
  }

  /** Returns the state. The arrays are valid until the next call. */
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

  /** Sets a particle. A null leaves the value unchanged. Returns an error, or an empty text. */
  set(id, position, velocity) {
    return this.ask(this.calls.set, { id, position, velocity }).error ?? "";
  }

  /** Returns the next events: time, kind, particles a and b (null for a wall), and the position of a. */
  upcoming(count) {
    this.calls.upcoming(count);
    return this.message;
  }

  poses() {
    this.calls.poses();
    return this.message;
  }

  /** Returns the text with the present positions and velocities as initial values, or an error. */
  scene(text) {
    return this.ask(this.calls.scene, { text });
  }
}

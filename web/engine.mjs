// The engine in JavaScript: an instance of the module, and the calls of web/engine/src/lib.rs in its words.

export const ENDS = ["events", "time", "idle", "failed"];

export class Engine {
  /** Of the bytes of the module, or of one that is compiled. */
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

  /** Starts a scene from its text: what there is in it, or an error with its line and cure. */
  start(text) {
    const bytes = new TextEncoder().encode(text);
    const at = this.calls.room(bytes.length);
    new Uint8Array(this.calls.memory.buffer, at, bytes.length).set(bytes);
    this.calls.start();
    return this.message;
  }

  /** Runs on; one of ENDS. */
  advance(events, time = Infinity) {
    return ENDS[this.calls.advance(events, time)];
  }

  /** The state now; positions and velocities are views that hold until the next call. */
  look() {
    const count = this.calls.look();
    const numbers = new Float64Array(this.calls.memory.buffer, this.calls.numbers(), count);
    const [time, events, kinetic, potential] = numbers;
    const half = 4 + (count - 4) / 2;
    return { time, events, kinetic, potential, positions: numbers.subarray(4, half), velocities: numbers.subarray(half) };
  }
}

/** A page that requests no picture for this time is hidden, and the simulation pauses `[ms]`. */
const UNSEEN = 400;

/** Rest after the simulation has reached its target time `[ms]`. */
const REST = 8;

/** Wall time between samples of the observables, and between results `[ms]`. */
const SAMPLE = 50;
const RESULTS = 200;

function ofBase64(text) {
  return Uint8Array.fromBase64 ? Uint8Array.fromBase64(text) : Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

async function gunzipped(text) {
  const stream = new Blob([ofBase64(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The simulation in its own thread. It runs in short slices between messages from the page. */
class Laboratory {
  constructor() {
    this.pace = new Pace();
    this.isRunning = false;
    this.askedAt = 0;
    this.channel = new MessageChannel();
    this.channel.port1.onmessage = () => this.slice();
    this.observed = [];
  }

  async hear(message) {
    if (message.kind === "module") {
      this.load(message);
      return;
    }
    await this.ready;
    try {
      this[`on_${message.kind}`]?.(message);
    } catch (error) {
      this.fail(error, message.number);
    }
  }

  /** After a trap, the engine is unreliable. The next start uses a new instance. */
  fail(error, number) {
    this.state = this.frames = this.head = undefined;
    this.isRunning = false;
    this.ready = this.loading.then((module) => this.instantiate(module));
    this.post({ kind: "error", error: `the engine has stopped: ${error.message}`, isTrap: true, number });
  }

  async instantiate(module) {
    this.engine = await Engine.of(module);
    for (const { name, content } of await this.files) {
      this.engine.bring(name, content);
    }
  }

  post(message, buffers = []) {
    self.postMessage(message, buffers);
  }

  load({ text, files }) {
    this.files = Promise.all(files.map(async ({ name, content }) => ({ name, content: await gunzipped(content) })));
    this.loading = WebAssembly.compile(new Unpacker(ofBase64(text)).unpack());
    this.ready = this.loading.then((module) => this.instantiate(module));
    this.ready.catch((error) => this.post({ kind: "error", error: `the engine cannot be loaded: ${error.message}`, isTrap: true }));
  }

  on_start({ text, changes = {} }) {
    // If the new scene has an error, the running scene continues.
    const checked = this.head ? this.engine.check(text, changes) : {};
    if (checked.error) {
      this.post({ ...checked, kind: "error" });
      return;
    }
    this.begin(this.engine.start(text, changes), text, changes, false);
  }

  on_change({ changes }) {
    if (!this.head) {
      return;
    }
    const merged = { ...this.changes, ...changes };
    this.begin(this.engine.change(this.text, merged), this.text, merged, true);
  }

  begin(head, text, changes, isChange) {
    if (head.error) {
      this.post({ ...head, kind: "error" });
      return;
    }
    Object.assign(this, { head, text, changes, end: undefined, announced: undefined });
    this.state = this.engine.look();
    head.gravity = this.state.acceleration;
    this.frames = new Frames(head, this.state);
    const { moving } = this.frames;
    const isMoving = new Set(moving);
    const fixed = [...head.particles.keys()].filter((id) => !isMoving.has(id));
    head.moving = moving;
    head.fixed = Uint32Array.from(fixed);
    head.fixedPositions = Float32Array.from(fixed.flatMap((id) => [...this.state.positions.subarray(3 * id, 3 * id + 3)]));
    this.observables = new Observables(head);
    this.observables.want(this.observed);
    this.pace.rates = [];
    this.sampledAt = this.resultsAt = 0;
    this.sample(performance.now());
    this.pace.anchor(performance.now(), this.state.time);
    this.post({ kind: "head", head, text, changes, isChange });
  }

  on_check({ text, changes = {}, number }) {
    this.post({ ...this.engine.check(text, changes), kind: "checked", number });
  }

  on_scene({ number }) {
    this.post({ ...(this.head ? this.engine.scene(this.text) : { error: "there is no simulation" }), kind: "scene", number });
  }

  on_run({ speed }) {
    const now = performance.now();
    this.isRunning = true;
    this.pace.speed = speed;
    this.pace.rates = [];
    this.askedAt = now;
    if (this.state) {
      this.pace.anchor(now, this.state.time);
      this.wake();
    }
  }

  on_pause() {
    this.isRunning = false;
    this.results(performance.now());
  }

  on_step({ events = 1 }) {
    this.isRunning = false;
    if (this.state) {
      this.reach(this.engine.advance(events, Infinity));
      this.sample(performance.now());
      this.results(performance.now());
    }
  }

  on_set({ id, position, velocity, number }) {
    const error = this.state ? this.engine.set(id, position ?? null, velocity ?? null) : "there is no simulation";
    if (!error) {
      this.end = this.announced = undefined;
      this.state = this.engine.look();
      this.frames.skip(this.state);
    }
    this.post({ kind: "set", id, error, number });
  }

  on_observe({ names }) {
    this.observed = names;
    this.observables?.want(names);
    this.results(performance.now());
  }

  on_frame({ channel = "species", upcoming = 0, buffers = [] }) {
    if (!this.frames) {
      this.post({ kind: "frame" });
      return;
    }
    const now = performance.now();
    if (this.isRunning && now - this.askedAt > UNSEEN) {
      this.pace.anchor(now, this.state.time);
    }
    this.askedAt = now;
    this.frames.reuse(buffers);
    this.run(now);
    this.state = this.engine.look();
    const after = performance.now();
    this.pace.note(after, this.state.time);
    const frame = this.frames.frame(this.state, channel);
    frame.poses = this.head.surfaces ? this.engine.poses() : undefined;
    Object.assign(frame, this.pace.rate(after, this.state), { isLate: after - this.pace.lateAt < 700, announced: this.announce(upcoming) });
    const owned = [frame.positions, frame.velocities, frame.hits, frame.tones].filter(Boolean);
    this.post(frame, owned.map((array) => array.buffer));
    this.results(after);
    this.wake();
  }

  /** Returns the next events. A copy of the simulation predicts more when two thirds of these events have passed. */
  announce(count) {
    if (count === 0) {
      return undefined;
    }
    const { time } = this.state;
    let list = (this.announced ?? []).filter((event) => event.time >= time);
    if (list.length < count / 3) {
      const asked = this.engine.upcoming(count);
      list = Array.isArray(asked) ? asked : [];
    }
    this.announced = list;
    return list;
  }

  /** Runs for at most one slice. Returns whether the simulation is still behind its target time. */
  run(began) {
    let now = began;
    while (this.isRunning && now - began < SLICE) {
      const goal = this.pace.goal(now);
      const stop = Math.min(goal, this.nextSample(now));
      if (!(stop > this.state.time)) {
        return false;
      }
      const end = this.engine.advance(this.pace.events, stop);
      const after = performance.now();
      this.pace.adapt(end === "events", after - now);
      now = after;
      this.state = this.engine.look();
      this.reach(end);
      if (end === "time") {
        this.sample(now);
      }
      if (end === "time" && stop === goal) {
        return false;
      }
    }
    return this.isRunning;
  }

  reach(end) {
    this.state = this.engine.look();
    if (end === "failed" || end === "idle" || end === "end") {
      this.isRunning = false;
      if (this.end !== end || end === "failed") {
        this.post({ kind: "ended", why: end, error: end === "failed" ? this.engine.message?.error : undefined });
      }
      this.end = end;
    }
  }

  /** Returns the simulated time of the next sample. There are about twenty samples per second of wall time. */
  nextSample(now) {
    if (!this.observables || this.observed.length === 0) {
      return Infinity;
    }
    const speed = this.pace.speed === Infinity ? this.pace.rate(now, this.state).pace : this.pace.speed;
    if (!(speed > 0)) {
      return Infinity;
    }
    const step = 10 ** Math.round(Math.log10((speed * SAMPLE) / 1000));
    return step * (Math.floor(this.state.time / step + 1e-9) + 1);
  }

  sample(now) {
    if (this.observables && this.state && (this.sampledAt === 0 || (this.observed.length > 0 && now - this.sampledAt > SAMPLE / 3))) {
      this.sampledAt = now;
      this.observables.sample(this.state, this.head);
      this.isSampled = true;
    }
  }

  results(now) {
    if (this.observables && this.isSampled && this.observed.length > 0 && (now - this.resultsAt > RESULTS || !this.isRunning)) {
      this.resultsAt = now;
      this.isSampled = false;
      const results = this.observables.results();
      this.post({ kind: "observables", time: this.state.time, results }, [...new Set(buffersOf(results))]);
    }
  }

  wake() {
    if (this.isRunning && !this.isAwake) {
      this.isAwake = true;
      this.channel.port2.postMessage(undefined);
    }
  }

  /** Runs a slice. Without requests for pictures, the simulation stops. */
  slice() {
    this.isAwake = false;
    const now = performance.now();
    if (!this.isRunning || !this.state || now - this.askedAt > UNSEEN) {
      return;
    }
    try {
      const isAhead = this.run(now);
      this.pace.note(performance.now(), this.state.time);
      if (isAhead) {
        this.wake();
      } else if (this.isRunning) {
        this.isAwake = true;
        setTimeout(() => this.slice(), REST);
      }
    } catch (error) {
      this.fail(error);
    }
  }
}

function buffersOf(value) {
  if (ArrayBuffer.isView(value)) {
    return [value.buffer];
  }
  return value && typeof value === "object" ? Object.values(value).flatMap(buffersOf) : [];
}

const laboratory = new Laboratory();
self.onmessage = (event) => laboratory.hear(event.data);

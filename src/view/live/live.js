/** Interval between updates of the numbers beside the picture `[ms]`. */
const READING = 250;

/** Interval between updates of other displays while the simulation runs `[ms]`. */
const BESIDE = 100;

/** Drawing time of a slow picture `[ms]`. */
const SLOW = 60;

const AHEAD = 400;

/** Starts the graphics while the worker unpacks the engine. */
function wakeGraphics() {
  document.createElement("canvas").getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
}

class Live {
  constructor() {
    this.scene = JSON.parse(document.getElementById("scene").textContent);
    this.text = this.scene.text;
    this.changes = this.scene.changes;
    this.handlers = new Map();
    this.picture = new Picture(liveElement("view"));
    this.hand = new Hand(this);
    this.announcer = new Announcer(this);
    this.isPlaying = false;
        this.isKicked = false;
    this.speed = 1;
    this.channel = "species";
    this.spent = [];
    this.describe();
    this.controls = new LiveControls(this);
    this.worker = new LiveWorker(this.scene.files, (message) => this.hear(message));
    this.worker.send({ kind: "start", text: this.text, changes: this.changes });
    wakeGraphics();
    new ResizeObserver(() => this.resized()).observe(this.picture.canvas);
    requestAnimationFrame((now) => this.tick(now));
  }

  describe() {
    const { name, description } = this.scene;
    liveElement("name").textContent = name;
    const place = liveElement("description");
    place.innerHTML = description ?? "";
    place.hidden = !description;
  }

  listen(kind, handler) {
    this.handlers.set(kind, [...(this.handlers.get(kind) ?? []), handler]);
  }

  tell(kind, value) {
    for (const handler of this.handlers.get(kind) ?? []) {
      try {
        handler(value);
      } catch (error) {
        // An error in one handler, such as a plot, does not stop other handlers.
        console.error(error);
      }
    }
  }

  send(message, buffers) {
    this.worker.send(message, buffers);
  }

  ask(message) {
    return this.worker.ask(message);
  }

  start(text, changes = {}) {
    this.isAsked = false;
    this.send({ kind: "start", text, changes });
  }

  change(changes) {
    this.send({ kind: "change", changes });
  }

  restart() {
    this.start(this.text, this.changes);
  }

  reseed(seed = String(1 + Math.floor(Math.random() * 99999))) {
    if (/^\d+$/.test(seed)) {
      this.start(this.text, { ...this.changes, seed });
    }
  }

  hear(message) {
    const act = { head: this.begin, frame: this.receive, error: this.fail, ended: this.end, set: this.put }[message.kind];
    act?.call(this, message);
    if (message.kind !== "frame") {
      this.tell(message.kind, message.kind === "head" ? message.head : message);
    }
  }

  /** Handles a new scene, or new values of the present scene. */
  begin({ head, text, changes, isChange }) {
    const isLike = (keys) => this.head !== undefined && JSON.stringify(keys.map((key) => head[key])) === JSON.stringify(keys.map((key) => this.head[key]));
    const isSameView = isChange || isLike(["lower", "size", "flat", "view", "up", "isUpsideDown"]);
    this.isNew ||= !isLike(["flat", "up", "gravity", "species"]) && !isChange;
    Object.assign(this, { head, text, changes });
    this.isKicked &&= isChange;
    this.order = new Map([...head.moving, ...head.fixed].map((id, index) => [id, index]));
    this.picture.begin(head, isSameView);
    this.announcer.clear();
    this.isAsked = false;
    liveElement("seed").value = changes.seed ?? head.seed;
    this.controls.offer(head, this.picture.renderer.mesh.count > 0);
    liveElement("facts").textContent = this.facts();
    this.say("");
    this.redraw(true);
    this.play(this.isPlaying);
  }

  facts() {
    const { moving, fixed, stages } = this.head;
    const parts = [`${liveNumber(moving.length)} ${moving.length === 1 ? "particle" : "particles"}`];
    if (fixed.length > 0) {
      parts.push(`${liveNumber(fixed.length)} static`);
    }
    if (stages.length > 1) {
      parts.push(`${stages.length} stages`);
    }
    return parts.join(" · ");
  }

  receive(frame) {
    this.isAsked = false;
    if (!frame.positions || frame.positions.length !== 3 * (this.head?.moving.length ?? -1)) {
      return;
    }
    const now = performance.now();
    const last = this.picture.take(frame, now);
    this.spent.push(...(last ? [last.positions, last.velocities, last.hits, last.tones].filter(Boolean).map((array) => array.buffer) : []));
    if (this.isNew) {
      this.first(frame);
    }
    if (this.isPlaying) {
      this.hand.hold();
    }
    if (this.announcer.isOn) {
      this.announcer.note(frame, now);
    }
    if (!this.isPlaying || !(now - this.toldAt < BESIDE)) {
      this.toldAt = now;
      this.tell("frame", frame);
    }
    this.isDue = true;
  }

  /** Starts a scene at its natural speed. */
  first(frame) {
    this.isNew = false;
    liveElement("message").hidden = true;
    document.getElementById("live").dataset.state = "ready";
    if (!this.isSteered) {
      this.isSteered = true;
      steer(this.picture.canvas, this.picture.camera, () => this.redraw());
    }
    const { speed, colour } = this.head.live ?? {};
    this.natural = speed > 0 ? speed : liveNaturalSpeed(this.head, frame);
    if (colour) {
      liveElement("colour").value = colour;
      this.controls.choose();
    }
    this.setSpeed(this.natural);
    const isSmall = this.head.moving.length <= 40 || this.head.flat.some(Boolean);
    this.controls.hand(isSmall && !window.matchMedia("(pointer: coarse)").matches);
    liveScale(this);
    if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.play(true);
    }
  }

  fail({ error, line, help, isTrap }) {
    this.isAsked = false;
    if (!this.head || isTrap) {
      this.message(`${error}${line ? ` (line ${line})` : ""}${help ? `\n${help}` : ""}`);
    } else {
      this.say(`${error}${line ? ` (line ${line})` : ""}`);
    }
    if (isTrap) {
      this.play(false);
    }
  }

  end({ why, error }) {
    this.play(false);
    const words = { idle: "Nothing happens any more.", end: "The end of the scene; it goes on if you play.", failed: `It cannot go on: ${error}.` };
    this.say(words[why] ?? "");
  }

  put(answer) {
    this.hand.answer(answer);
  }

  message(words) {
    liveElement("message").textContent = words;
    liveElement("message").hidden = false;
  }

  say(words) {
    liveElement("words").textContent = words;
  }

  play(isPlaying) {
    this.isPlaying = isPlaying;
    const button = liveElement("play");
    button.textContent = isPlaying ? "❚❚" : "▶";
    button.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    if (isPlaying) {
      this.say("");
    }
    this.send(isPlaying ? { kind: "run", speed: this.speed } : { kind: "pause" });
    this.redraw(true);
    this.tell("play", isPlaying);
  }

  step() {
    if (this.isPlaying) {
      this.play(false);
    }
    this.send({ kind: "step", events: 1 });
    this.redraw(true);
  }

  setSpeed(speed) {
    this.speed = speed;
    const output = liveElement("speed");
    output.textContent = `${speed < 0.001 || speed >= 1e5 ? speed.toExponential(0) : liveShort(speed)} / s`;
    output.title = "Simulated time per second";
    if (this.isPlaying) {
      this.send({ kind: "run", speed });
    }
  }

  faster(steps) {
    const index = liveSpeeds.indexOf(liveNearestSpeed(this.speed)) + steps;
    const speed = liveSpeeds[Math.min(Math.max(index, 0), liveSpeeds.length - 1)];
    if (this.announcer.isOn) {
      this.announcer.factor *= speed / this.speed;
    } else {
      this.natural = speed;
    }
    this.setSpeed(speed);
  }

  resized() {
    const { camera, renderer } = this.picture;
    if (camera && !camera.isMoved) {
      camera.fit(renderer.resize());
    }
    this.redraw();
  }

  /** Draws before the next repaint. If `isFresh`, also requests a new picture from the worker. */
  redraw(isFresh = false) {
    this.isDue = true;
    this.isWanted ||= isFresh;
  }

  tick(now) {
    requestAnimationFrame((later) => this.tick(later));
    const isReady = this.head !== undefined && !this.isAsked;
    if (isReady && (this.isPlaying || this.isWanted)) {
      this.isWanted = false;
      this.isAsked = true;
      const upcoming = this.announcer.isOn ? AHEAD : 0;
      const buffers = this.spent.splice(0);
      this.send({ kind: "frame", channel: this.channel, upcoming, buffers }, buffers);
    }
    const isBusy = this.isDue && this.picture.frame && this.picture.renderer.isBusy();
    if (isBusy && now - this.drawnAt > SLOW) {
      this.controls.slow();
    } else if (this.isDue && this.picture.frame && !isBusy) {
      this.isDue = false;
      this.drawnAt = now;
      this.draw(now);
    }
    // Tests read this attribute. It is absent if the picture is up to date.
    const isDue = this.isDue || this.isWanted || this.isAsked || this.worker.askedAt !== undefined;
    document.getElementById("live").toggleAttribute("data-due", Boolean(isDue));
    this.watch();
  }

  draw(now) {
    const { picture } = this;
    const { frame } = picture;
    picture.draw();
    liveElement("time").textContent = `t = ${liveTime(frame.time, this.speed)}`;
    if (this.announcer.isOn) {
      this.announcer.write(frame.time);
    }
    if (!(now - this.readAt < READING) || !this.isPlaying) {
      this.readAt = now;
      this.read(frame);
    }
  }

  read(frame) {
    const { events, rate, stage, isLate, pace } = frame;
    const parts = [`${liveNumber(events)} ${events === 1 ? "event" : "events"}`];
    if (this.isPlaying && rate > 0) {
      parts.push(`${liveRate(rate)} per second`);
    }
    if (this.head.stages.length > 1) {
      const name = this.head.stages[stage];
      parts.unshift(/^\d+$/.test(name) ? `stage ${stage + 1}` : name);
    }
    liveElement("rate").textContent = parts.join(" · ");
    if (this.isPlaying) {
      this.say(isLate && pace > 0 ? `As fast as it can: ${liveShort(pace)} / s` : "");
    }
    liveScale(this);
    if (liveElement("more").open) {
      liveCounts(frame);
    }
  }

  /** Shows a message if the engine has been silent for long. */
  watch() {
    const seconds = Math.floor(this.worker.silence() / 1000);
    if (seconds > 0 && seconds !== this.silence) {
      const button = liveTag("button", "Start again");
      button.type = "button";
      button.addEventListener("click", () => this.renew());
      this.say(`The engine has been at work for ${seconds} seconds. `);
      liveElement("words").append(button);
    } else if (seconds === 0 && this.silence > 0) {
      this.say("");
    }
    this.silence = seconds;
  }

  /** Replaces a silent worker by a new one. */
  renew() {
    this.isAsked = false;
    this.hand.forget();
    this.worker.begin();
    this.restart();
    this.tell("renewed", undefined);
  }
}

try {
  const live = new Live();
  new LivePlots(live);
  new LiveEditor(live);
} catch (error) {
  liveElement("message").textContent = error.message;
  liveElement("message").hidden = false;
}

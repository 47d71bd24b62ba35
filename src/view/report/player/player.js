/** If there are more particles, states between frames are not drawn by default. */
const MOST_BETWEEN = 100000;

/** Drawing time of a slow picture `[ms]`. */
const SLOW = 100;

class Player {
  constructor(recording) {
    this.recording = recording;
    this.player = document.getElementById("player");
    this.canvas = element("view");
    this.renderer = new Renderer(this.canvas, recording);
    this.camera = new Camera(recording.head);
    this.dark = window.matchMedia("(prefers-color-scheme: dark)");
    this.between = new Between(recording);
    this.place = 0;
    this.isPlaying = false;
    this.isDue = false;
    this.camera.margin = this.renderer.largest;
    this.camera.reach = this.reach();
    this.offerChoices();
    this.listen();
    this.paint();
    this.camera.reset(this.renderer.resize());
    this.show(0);
  }

  reach() {
    let reach = this.camera.extent;
    for (const { field: [lower, size] } of this.recording.head.frames) {
      for (const corner of [lower, add(lower, size)]) {
        reach = Math.max(reach, norm(subtract(corner, this.camera.centre)) * 1.8);
      }
    }
    const { surfaces } = this.recording.head;
    for (const corner of surfaces ? [surfaces.lower, add(surfaces.lower, surfaces.size)] : []) {
      reach = Math.max(reach, norm(subtract(corner, this.camera.centre)) * 1.8);
    }
    return 1.1 * reach + 2 * this.camera.margin;
  }

  offerChoices() {
    const { head } = this.recording;
    const colour = element("colour");
    colour.add(new Option("species", String(SPECIES)));
    head.channels.forEach(({ name }, index) => colour.add(new Option(name, String(index))));
    colour.add(new Option("free flight", String(FLIGHT)));
    colour.value = String(head.colour ?? SPECIES);
    element("between").checked = head.moving <= MOST_BETWEEN;
    element("images-choice").hidden = !head.periodic.some((isPeriodic) => isPeriodic);
    element("shadows-choice").hidden = this.recording.count > MOST_SHADED;
    element("shadows").checked = this.recording.count <= MOST_SHADED;
    element("full").hidden = !document.fullscreenEnabled;
    element("static-choice").hidden = this.renderer.mesh.count === 0;
    element("surfaces-choice").hidden = !head.surfaces;
    element("marks-choice").hidden = !head.hasTurns;
    element("frame").max = String(this.recording.length - 1);
    element("message").hidden = true;
  }

  listen() {
    const { canvas, camera } = this;
    const draw = () => this.redraw();
    steer(canvas, camera, draw);
    element("play").addEventListener("click", () => this.play(!this.isPlaying));
    element("first").addEventListener("click", () => this.step(-Infinity));
    element("back").addEventListener("click", () => this.step(-1));
    element("next").addEventListener("click", () => this.step(1));
    element("last").addEventListener("click", () => this.step(Infinity));
    element("frame").addEventListener("input", (event) => {
      this.play(false);
      this.show(Number(event.target.value));
    });
    element("colour").addEventListener("change", () => {
      this.paint();
      this.show(this.place);
    });
    element("between").addEventListener("change", () => this.show(this.index));
    for (const choice of ["static", "surfaces", "marks", "images", "shadows", "box"]) {
      element(choice).addEventListener("change", draw);
    }
    element("shadows").addEventListener("change", () => {
      this.hasChosenShadows = true;
    });
    element("full").addEventListener("click", () => this.fill());
    document.addEventListener("fullscreenchange", () => this.noteFull());
    element("reset").addEventListener("click", () => this.resetView());
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("webglcontextlost", () => this.say("The graphics of this browser gave up; load the page again."));
    this.dark.addEventListener("change", () => this.paint());
    new ResizeObserver(() => {
      if (!camera.isMoved) {
        camera.fit(this.renderer.resize());
      }
      this.redraw();
    }).observe(canvas);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const jump = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity }[event.key];
    if (event.key === " ") {
      this.play(!this.isPlaying);
    } else if (jump && !event.shiftKey) {
      this.step(jump);
    } else if (event.key === "r" || event.key === "R") {
      this.resetView();
    } else if (event.key === "f" || event.key === "F") {
      this.fill();
    } else if (steerByKey(event, this.camera)) {
      this.redraw();
    } else {
      return;
    }
    event.preventDefault();
  }

  fill() {
    const done = document.fullscreenElement ? document.exitFullscreen() : this.player.requestFullscreen();
    done.catch(() => this.noteFull());
  }

  noteFull() {
    const isFull = document.fullscreenElement === this.player;
    element("full").setAttribute("aria-pressed", String(isFull));
  }

  resetView() {
    this.camera.reset(this.renderer.resize());
    this.redraw();
  }

  say(words) {
    const message = element("message");
    message.textContent = words;
    message.hidden = false;
  }

  get scheme() {
    return this.dark.matches ? SCHEMES.dark : SCHEMES.light;
  }

  paint() {
    const { species, channels } = this.recording.head;
    const palette = speciesColours(species, this.scheme.fixed);
    this.renderer.setColours(palette, scaleColours());
    const channel = this.colour === FLIGHT ? undefined : channels[this.colour];
    const key = document.createDocumentFragment();
    const write = (words, className) => {
      const span = document.createElement("span");
      span.textContent = words;
      span.className = className;
      key.append(span);
      return span;
    };
    if (channel) {
      const unit = channel.unit === "1" ? "" : ` [${raised(channel.unit)}]`;
      write(`${channel.name}${unit}`, "what");
      write(short(channel.low), "end");
      write("", "bar").style.background = `linear-gradient(to right, ${VIRIDIS.map(css).join(", ")})`;
      write(`${short(channel.high)}${channel.isExceeded ? " and more" : ""}`, "end");
    } else if (this.colour === FLIGHT) {
      for (const [words, tone] of [["flies freely until the next frame", FREE], ["meets something before", HINDERED]]) {
        write("", "dot").style.background = css(scaleColours()[tone]);
        write(words, "what");
      }
    } else {
      species.forEach(({ name, isStatic }, index) => {
        write("", "dot").style.background = css(palette[index]);
        write(isStatic ? `${name} (static)` : name, "what");
      });
    }
    element("scale").replaceChildren(key);
    this.redraw();
  }

  get colour() {
    return Number(element("colour").value);
  }

  /** Index of the visible frame, or of the frame before. */
  get index() {
    return Math.floor(this.place);
  }

  /** Shows a frame, or a state between two frames. */
  show(place) {
    const { recording } = this;
    this.place = Math.min(Math.max(place, 0), recording.length - 1);
    const { index } = this;
    const part = element("between").checked ? this.place - index : 0;
    const [frame, next] = recording.head.frames.slice(index, index + 2);
    this.renderer.load(part > 0 ? this.between.state(index, part, this.colour) : recording.state(recording.frame(index), this.colour));
    const words = `t = ${short(part > 0 ? frame.time + part * (next.time - frame.time) : frame.time)}`;
    const number = `${index + 1} of ${recording.length}`;
    element("time").textContent = `${words} · ${number}`;
    element("frame").value = String(index);
    element("frame").setAttribute("aria-valuetext", `frame ${number}, ${words}`);
    this.noteFlights();
    this.redraw();
  }

  noteFlights() {
    const { index, recording: { length, head: { moving } } } = this;
    const isShown = element("between").checked && length > 1;
    const key = isShown ? index : -1;
    if (this.noted === key) {
      return;
    }
    this.noted = key;
    const note = element("note");
    note.hidden = !isShown;
    if (!isShown || index + 1 === length) {
      note.textContent = isShown ? "The last frame." : "";
      return;
    }
    const free = this.between.count(index);
    const number = (count) => String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f");
    const known = `Until the next frame ${number(free)} of ${number(moving)} particles meet nothing: they are drawn on their way.`;
    const rest = "What the others meet, and where, is not in the file: they are drawn on smooth curves.";
    const none = "All particles meet something until the next frame. What, and where, is not in the file: they are drawn on smooth curves.";
    note.textContent = free === 0 ? none : free === moving ? known : `${known} ${rest}`;
  }

  step(number) {
    this.play(false);
    this.show(number < 0 ? Math.ceil(this.place) + number : this.index + number);
  }

  play(isPlaying) {
    this.isPlaying = isPlaying && this.recording.length > 1;
    const button = element("play");
    button.textContent = this.isPlaying ? "❚❚" : "▶";
    button.setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
    // A screen reader must not announce the time during playback.
    element("time").setAttribute("aria-live", this.isPlaying ? "off" : "polite");
    if (this.isPlaying) {
      if (this.place === this.recording.length - 1) {
        this.show(0);
      }
      this.shownAt = performance.now();
      this.redraw();
    }
  }

  advance(now) {
    const rate = Number(element("speed").value);
    const last = this.recording.length - 1;
    // Slow drawing slows playback down. Frames are skipped only at rates above 30 per second.
    const due = Math.min(((now - this.shownAt) * rate) / 1000, Math.max(1, rate / 30));
    const isSmooth = element("between").checked;
    const number = isSmooth ? due : Math.floor(due + 1e-6);
    if (number <= 0) {
      return;
    }
    this.shownAt = isSmooth ? now : Math.max(this.shownAt + (1000 * number) / rate, now - 1000 / rate);
    if (this.place < last) {
      this.show(Math.min((isSmooth ? this.place : this.index) + number, last));
    } else if (element("repeat").checked) {
      this.show(0);
    } else {
      this.play(false);
    }
  }

  redraw() {
    if (!this.isDue) {
      this.isDue = true;
      this.player.dataset.due = "";
      requestAnimationFrame((now) => this.tick(now));
    }
  }

  /** Draws the next picture once the last one is complete. */
  tick(now) {
    if (this.renderer.isBusy()) {
      this.hasWaited = true;
      requestAnimationFrame((later) => this.tick(later));
      return;
    }
    if (this.hasWaited && now - this.drawnAt > SLOW) {
      this.dropShadows();
    }
    this.hasWaited = false;
    this.drawnAt = now;
    this.isDue = false;
    delete this.player.dataset.due;
    this.draw(now);
  }

  dropShadows() {
    this.slowPictures = (this.slowPictures ?? 0) + 1;
    if (this.slowPictures > 2 && !this.hasChosenShadows) {
      element("shadows").checked = false;
    }
  }

  draw(now) {
    if (this.isPlaying) {
      this.advance(now);
    }
    if (this.renderer.state) {
      const aspect = this.renderer.resize();
      const choices = {
        hasBox: element("box").checked,
        hasImages: element("images").checked,
        hasShadows: element("shadows").checked,
        hasSurfaces: element("surfaces").checked,
        hasMarks: element("marks").checked,
        fixed: element("static").value,
      };
      this.renderer.draw(this.camera.look(aspect), this.scheme, choices);
      this.player.dataset.frame = String(this.index);
    }
    if (this.isPlaying) {
      this.redraw();
    }
  }
}

try {
  new Player(new Recording());
} catch (error) {
  const message = element("message");
  message.textContent = error.message;
  message.hidden = false;
}

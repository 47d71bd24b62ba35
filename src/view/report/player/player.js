/** The controls and what they do. */
class Player {
  constructor(recording) {
    this.recording = recording;
    this.player = document.getElementById("player");
    this.canvas = element("view");
    this.renderer = new Renderer(this.canvas, recording);
    this.camera = new Camera(recording.head);
    this.dark = window.matchMedia("(prefers-color-scheme: dark)");
    this.index = -1;
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

  /** How far from the centre anything ever is. */
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
    colour.add(new Option("species", "-1"));
    head.channels.forEach(({ name }, index) => colour.add(new Option(name, String(index))));
    element("static-choice").hidden = this.renderer.mesh.count === 0;
    element("surfaces-choice").hidden = !head.surfaces;
    element("frame").max = String(this.recording.length - 1);
    element("message").hidden = true;
  }

  listen() {
    const { canvas, camera } = this;
    const draw = () => this.redraw();
    steer(canvas, camera, draw);
    element("play").addEventListener("click", () => this.play(!this.isPlaying));
    element("back").addEventListener("click", () => this.step(-1));
    element("next").addEventListener("click", () => this.step(1));
    element("frame").addEventListener("input", (event) => {
      this.play(false);
      this.show(Number(event.target.value));
    });
    element("colour").addEventListener("change", () => {
      this.paint();
      this.show(this.index);
    });
    element("static").addEventListener("change", draw);
    element("surfaces").addEventListener("change", draw);
    element("box").addEventListener("change", draw);
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
    const jump = { ArrowLeft: -1, ArrowRight: 1, Home: -this.recording.length, End: this.recording.length }[event.key];
    if (event.key === " ") {
      this.play(!this.isPlaying);
    } else if (jump && !event.shiftKey) {
      this.step(jump);
    } else if (event.key === "r" || event.key === "R") {
      this.resetView();
    } else if (steerByKey(event, this.camera)) {
      this.redraw();
    } else {
      return;
    }
    event.preventDefault();
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

  /** Colours and their key. */
  paint() {
    const { species, channels } = this.recording.head;
    const palette = speciesColours(species, this.scheme.fixed);
    this.renderer.setColours(palette, scaleColours());
    const channel = channels[Number(element("colour").value)];
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
    } else {
      species.forEach(({ name, isStatic }, index) => {
        write("", "dot").style.background = css(palette[index]);
        write(isStatic ? `${name} (static)` : name, "what");
      });
    }
    element("scale").replaceChildren(key);
    this.redraw();
  }

  /** Shows a frame. */
  show(index) {
    const { recording } = this;
    this.index = Math.min(Math.max(index, 0), recording.length - 1);
    const frame = recording.frame(this.index);
    this.renderer.load(recording.state(frame, Number(element("colour").value)));
    const words = `t = ${short(frame.head.time)}`;
    const place = `${this.index + 1} of ${recording.length}`;
    element("time").textContent = `${words} · ${place}`;
    element("frame").value = String(this.index);
    element("frame").setAttribute("aria-valuetext", `frame ${place}, ${words}`);
    this.redraw();
  }

  step(number) {
    this.play(false);
    this.show(this.index + number);
  }

  play(isPlaying) {
    this.isPlaying = isPlaying && this.recording.length > 1;
    const button = element("play");
    button.textContent = this.isPlaying ? "❚❚" : "▶";
    button.setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
    // While it plays, the time would be spoken without an end.
    element("time").setAttribute("aria-live", this.isPlaying ? "off" : "polite");
    if (this.isPlaying) {
      if (this.index === this.recording.length - 1) {
        this.show(0);
      }
      this.shownAt = performance.now();
      this.redraw();
    }
  }

  advance(now) {
    const interval = 1000 / Number(element("speed").value);
    if (now - this.shownAt < interval) {
      return;
    }
    // A picture that takes longer than the interval delays the next ones: no frame is left out.
    this.shownAt = Math.max(this.shownAt + interval, now - interval);
    if (this.index < this.recording.length - 1) {
      this.show(this.index + 1);
    } else if (element("repeat").checked) {
      this.show(0);
    } else {
      this.play(false);
    }
  }

  /** Draws before the browser shows the page the next time. */
  redraw() {
    if (!this.isDue) {
      this.isDue = true;
      this.player.dataset.due = "";
      requestAnimationFrame((now) => this.tick(now));
    }
  }

  /** Pictures that are asked for while the last one is being made wait for it: otherwise slow graphics fall behind. */
  tick(now) {
    if (this.renderer.isBusy()) {
      requestAnimationFrame((later) => this.tick(later));
      return;
    }
    this.isDue = false;
    delete this.player.dataset.due;
    this.draw(now);
  }

  draw(now) {
    if (this.isPlaying) {
      this.advance(now);
    }
    if (this.renderer.state) {
      const aspect = this.renderer.resize();
      const choices = {
        hasBox: element("box").checked,
        hasSurfaces: element("surfaces").checked,
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

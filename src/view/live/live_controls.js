/** Buttons, choices and keys of the page. */
class LiveControls {
  constructor(live) {
    this.live = live;
    const click = (id, act) => liveElement(id).addEventListener("click", act);
    click("play", () => live.play(!live.isPlaying));
    click("step", () => live.step());
    click("slower", () => live.faster(-1));
    click("faster", () => live.faster(1));
    click("slow", () => live.announcer.turn(!live.announcer.isOn));
    click("hand", () => this.hand(!live.hand.isOn));
    click("reset", () => live.restart());
    click("again", () => live.reseed());
    click("full", () => this.fullscreen());
    click("view-reset", () => this.resetView());
    liveElement("seed").addEventListener("change", (event) => live.reseed(event.target.value));
    for (const id of ["colour", "trails", "arrows", "flashes", "shadows", "box", "static", "surfaces"]) {
      liveElement(id).addEventListener("change", () => this.choose());
    }
    liveElement("shadows").addEventListener("change", () => {
      this.hasChosenShadows = true;
    });
    document.addEventListener("keydown", (event) => this.key(event));
    document.addEventListener("fullscreenchange", () => live.redraw());
    live.picture.dark.addEventListener("change", () => {
      live.picture.paint();
      live.redraw();
    });
  }

  choose() {
    const { picture } = this.live;
    picture.choices = {
      hasBox: liveElement("box").checked,
      hasSurfaces: liveElement("surfaces").checked,
      fixed: liveElement("static").value,
      hasArrows: liveElement("arrows").checked,
      hasFlashes: liveElement("flashes").checked,
      hasShadows: liveElement("shadows").checked,
    };
    const count = Number(liveElement("trails").value);
    if (count !== picture.trailCount) {
      picture.follow(count);
    }
    this.live.channel = liveElement("colour").value;
    this.live.redraw(true);
  }

  /** Shows the choices that apply to a scene. */
  offer(head, hasMesh) {
    const isFew = head.moving.length + head.fixed.length <= MOST_SHADED;
    liveElement("static-choice").hidden = !hasMesh;
    liveElement("surfaces-choice").hidden = !head.surfaces;
    liveElement("shadows-choice").hidden = !isFew;
    if (!this.hasChosenShadows) {
      liveElement("shadows").checked = isFew && !head.flat.some(Boolean);
    }
    this.slowPictures = 0;
    this.choose();
  }

  /** Counts a slow picture. The third one turns shadows off, unless the user has set the choice. */
  slow() {
    this.slowPictures += 1;
    if (this.slowPictures > 2 && !this.hasChosenShadows && liveElement("shadows").checked) {
      liveElement("shadows").checked = false;
      this.choose();
    }
  }

  hand(isOn) {
    this.live.hand.isOn = isOn;
    liveElement("hand").setAttribute("aria-pressed", String(isOn));
    liveElement("view").classList.toggle("is-hand", isOn);
  }

  fullscreen() {
    if (document.fullscreenElement) {
      document.exitFullscreen();
    } else {
      liveElement("player").requestFullscreen?.().catch(() => {});
    }
  }

  resetView() {
    const { picture } = this.live;
    picture.camera?.reset(picture.renderer.resize());
    this.live.redraw();
  }

  /** Handles keys of the page, unless the user is typing. */
  key(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented || isTypedInto(target)) {
      return;
    }
    const isButton = target instanceof HTMLElement && /^(BUTTON|SUMMARY|INPUT|A)$/.test(target.tagName);
    if (event.key === " " && isButton) {
      return;
    }
    const act = this.acts()[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    const isOnPicture = target === this.live.picture.canvas;
    if (isOnPicture && (event.shiftKey || !act) && steerByKey(event, this.live.picture.camera)) {
      this.live.redraw();
    } else if (act && !(event.shiftKey && event.key.startsWith("Arrow"))) {
      act();
    } else {
      return;
    }
    event.preventDefault();
  }

  acts() {
    const { live } = this;
    const flip = (id) => {
      liveElement(id).checked = !liveElement(id).checked;
      this.choose();
    };
    const next = (id) => {
      const choice = liveElement(id);
      choice.selectedIndex = (choice.selectedIndex + 1) % choice.options.length;
      this.choose();
    };
    return {
      " ": () => live.play(!live.isPlaying),
      ArrowRight: () => live.step(),
      ",": () => live.faster(-1),
      ".": () => live.faster(1),
      m: () => live.announcer.turn(!live.announcer.isOn),
      h: () => this.hand(!live.hand.isOn),
      0: () => live.restart(),
      n: () => live.reseed(),
      t: () => next("trails"),
      v: () => flip("arrows"),
      c: () => next("colour"),
      f: () => this.fullscreen(),
      r: () => this.resetView(),
      b: () => flip("box"),
    };
  }
}

/** Returns whether an element handles keys itself. */
function isTypedInto(target) {
  const isElement = target instanceof HTMLElement;
  return isElement && (target.isContentEditable || /^(TEXTAREA|SELECT)$/.test(target.tagName) || (target.tagName === "INPUT" && target.type !== "checkbox"));
}

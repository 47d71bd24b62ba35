/** At the end of a drag, the motion of the pointer in this time sets the velocity of the particle `[ms]`. */
const FLICK = 80;

class Hand {
  constructor(live) {
    this.live = live;
    this.isOn = false;
    this.index = -1;
    this.listen(live.picture.canvas);
  }

  /** Handles pointer events before the camera does, so that a drag of a particle does not move the camera. */
  listen(canvas) {
    canvas.addEventListener("pointerdown", (event) => {
      if (this.grab(event)) {
        canvas.setPointerCapture(event.pointerId);
        canvas.focus({ preventScroll: true });
        this.pointer = event.pointerId;
        event.stopImmediatePropagation();
      }
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.index >= 0 && event.pointerId === this.pointer) {
        this.drag(event);
        event.stopImmediatePropagation();
      } else if (event.buttons === 0) {
        this.hover(this.isOn ? this.live.picture.pick(...this.place(event)) : -1);
      }
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => {
        if (this.index >= 0 && event.pointerId === this.pointer) {
          this.release(event);
          event.stopImmediatePropagation();
        }
      });
    }
    // Prevents scrolling while a finger drags a particle.
    canvas.addEventListener("touchmove", (event) => {
      if (this.index >= 0 && event.cancelable) {
        event.preventDefault();
      }
    }, { passive: false });
  }

  hover(index) {
    if (this.over !== index) {
      this.over = index;
      this.live.picture.canvas.classList.toggle("is-over", index >= 0);
      this.live.tell("hover", index < 0 ? -1 : this.live.head.moving[index]);
    }
  }

  /** Handles a pressed pointer, and returns whether it grabs a particle. */
  grab(event) {
    const { picture } = this.live;
    if (!this.isOn || event.button !== 0 || event.shiftKey || !picture.frame) {
      return false;
    }
    const index = picture.pick(...this.place(event));
    if (index < 0) {
      return false;
    }
    this.index = index;
    this.isMoved = false;
    this.held = picture.position(index);
    const grasped = picture.unproject(...this.place(event), this.held);
    this.offset = subtract(this.held, grasped);
    this.path = [];
    picture.choose(index);
    return true;
  }

  place(event) {
    const box = this.live.picture.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  drag(event) {
    const { live, index } = this;
    const { flat } = live.head;
    const wanted = add(live.picture.unproject(...this.place(event), this.held), this.offset);
    this.held = wanted.map((x, axis) => (flat[axis] ? this.held[axis] : x));
    this.isMoved = true;
    this.path.push([event.timeStamp, ...this.held]);
    this.path = this.path.filter(([time]) => event.timeStamp - time < 4 * FLICK);
    this.put(index, this.held, [0, 0, 0]);
  }

  hold() {
    if (this.index >= 0 && this.isMoved) {
      this.put(this.index, this.held, [0, 0, 0]);
    }
  }

  /** Releases the particle with the velocity of the pointer in simulated time. */
  release(event) {
    const { live, index } = this;
    this.index = -1;
    if (!this.isMoved) {
      return;
    }
    const recent = this.path.filter(([time]) => event.timeStamp - time < FLICK);
    if (recent.length > 1) {
      const [[start, ...from], [end, ...to]] = [recent[0], recent[recent.length - 1]];
      const seconds = Math.max(end - start, 8) / 1000;
      this.put(index, null, scaled(subtract(to, from), 1 / (seconds * live.speed)));
    }
  }

  /** Moves a particle, given by its index among the moving particles. Requests are sent one at a time. */
  put(index, position, velocity) {
    const { live } = this;
    const id = live.head.moving[index];
    const last = this.wanted?.id === id ? this.wanted.position : null;
    this.wanted = { kind: "set", id, position: position ?? last, velocity };
    live.isKicked = true;
    if (!this.isAsking) {
      this.ask();
    }
  }

  ask() {
    const { live, wanted } = this;
    this.wanted = undefined;
    this.isAsking = wanted !== undefined;
    if (wanted) {
      live.send(wanted);
      live.redraw(true);
    }
  }

  answer({ error }) {
    if (!this.live.isPlaying) {
      this.live.say(error ? `There is no room for it: ${error}.` : "");
    }
    this.ask();
  }

  forget() {
    this.wanted = undefined;
    this.isAsking = false;
  }
}

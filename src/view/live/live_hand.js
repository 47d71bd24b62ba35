/** The last part of a drag that decides how fast the particle is let go `[ms]`. */
const FLICK = 80;

/** Drags particles in the plane of the screen, and flicks them. */
class Hand {
  constructor(live) {
    this.live = live;
    this.isOn = false;
    this.index = -1;
    this.listen(live.picture.canvas);
  }

  /** Pointers that hold a particle are not for the camera, which hears of them later. */
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
        canvas.classList.toggle("is-over", this.isOn && this.live.picture.pick(...this.place(event)) >= 0);
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
    // A finger that holds a particle does not scroll the page.
    canvas.addEventListener("touchmove", (event) => {
      if (this.index >= 0 && event.cancelable) {
        event.preventDefault();
      }
    }, { passive: false });
  }

  /** A pointer that goes down: whether it takes hold of a particle. */
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
    live.put(index, this.held, [0, 0, 0]);
  }

  /** Keeps a particle where it is held, while all others move. */
  hold() {
    if (this.index >= 0 && this.isMoved) {
      this.live.put(this.index, this.held, [0, 0, 0]);
    }
  }

  /** Lets go: with the velocity of the pointer, in the simulated time that goes by while it runs. */
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
      live.put(index, null, scaled(subtract(to, from), 1 / (seconds * live.speed)));
    }
  }
}

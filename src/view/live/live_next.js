/**
 * Shortest and longest wall time between an announcement and its event `[s]`, and time until an announcement of a past
 * event is removed `[ms]`.
 */
const NOTICE = [0.5, 2.2];
const AFTERWARDS = 700;

/** Smallest wall time between announced events if there are many `[s]`. */
const APART = 0.35;

/** If fewer events than this are due, all of them are announced. */
const SPARSE = 8;

const ANNOUNCED = 3;

/** Speed of particles in slow motion, in radii per second, and longest wait for the next event `[s]`. */
const SLOW_WAY = 0.5;
const SLOW_WAIT = 1.4;

const EVENT_WORDS = {
  core: "contact", capture: "capture", release: "escape", bounce: "bounce", wall: "wall", thermostat: "kick",
};

/** Announces the next events in slow motion. */
class Announcer {
  constructor(live) {
    this.live = live;
    this.shown = [];
    this.isOn = false;
    this.factor = 1;
    this.colours = ["var(--c1)", "var(--c0)", "var(--c2)"];
  }

  turn(isOn) {
    const { live } = this;
    this.isOn = isOn;
    this.factor = 1;
    this.adaptedAt = undefined;
    liveElement("slow").setAttribute("aria-pressed", String(isOn));
    if (!isOn) {
      this.clear();
      live.setSpeed(live.natural);
    } else if (live.picture.frame) {
      this.adapt(live.picture.frame);
    }
    live.redraw(true);
  }

  adapt(frame) {
    const { live } = this;
    if (this.adaptedAt !== frame.events) {
      const speed = this.speed(frame, live.natural) * this.factor;
      this.adaptedAt = frame.announced ? frame.events : undefined;
      if (!(speed > live.speed / 1.5 && speed < live.speed * 1.5)) {
        live.setSpeed(speed);
      }
    }
  }

  clear() {
    this.shown = [];
    liveElement("marks").replaceChildren();
    liveElement("next").hidden = true;
  }

  /** Returns a speed at which particles move slowly, but the next event comes soon. */
  speed({ velocities, time, announced }, natural) {
    let squares = 0;
    for (let k = 0; k < velocities.length; k += 1) {
      squares += velocities[k] * velocities[k];
    }
    const typical = Math.sqrt((3 * squares) / Math.max(velocities.length, 1));
    const moving = (SLOW_WAY * this.live.picture.meanRadius()) / typical;
    const waiting = announced?.length > 0 ? (announced[0].time - time) / SLOW_WAIT : 0;
    const wanted = Math.max(moving < Infinity ? moving : 0, waiting);
    return wanted > 0 ? Math.min(wanted, natural) : natural;
  }

  note(frame, now) {
    const { announced = [], time } = frame;
    this.adapt(frame);
    this.shown = this.shown.filter((event) => event.time > time || now - (event.doneAt ??= now) < AFTERWARDS);
    const { speed } = this.live;
    const taken = new Set(this.shown.flatMap(({ a, b }) => [a, b]));
    const free = this.colours.filter((colour) => this.shown.every((event) => event.colour !== colour));
    const isSparse = !(announced[SPARSE]?.time - time < NOTICE[1] * speed);
    for (const event of announced) {
      const wait = (event.time - time) / speed;
      const isApart = this.shown.every((other) => Math.abs(other.time - event.time) > APART * speed);
      const isDue = wait < NOTICE[1] && ((wait > NOTICE[0] && isApart) || isSparse);
      if (this.shown.length < ANNOUNCED && isDue && !taken.has(event.a) && !taken.has(event.b) && this.isSeen(event)) {
        this.shown.push({ ...event, colour: free.shift() });
        taken.add(event.a).add(event.b);
      }
    }
    // If no event meets these conditions, the next event is announced.
    if (this.shown.length === 0 && announced.length > 0) {
      this.shown.push({ ...announced[0], colour: free[0] });
    }
    this.write(time);
  }

  isSeen({ a, b }) {
    const { picture } = this.live;
    return [a, b].every((id) => {
      const place = this.place(id);
      const seen = place && picture.project(place);
      return !place || (seen.x > 0 && seen.y > 0 && seen.x < picture.canvas.clientWidth && seen.y < picture.canvas.clientHeight);
    });
  }

  place(id) {
    const { picture, order } = this.live;
    const index = order?.get(id);
    const { moving, fixedPositions } = picture.head;
    if (index === undefined || index < moving.length) {
      return index === undefined ? undefined : picture.position(index);
    }
    const at = 3 * (index - moving.length);
    return [...fixedPositions.subarray(at, at + 3)];
  }

  names({ a, b }) {
    const { head } = this.live;
    const ids = [...new Set([a, b])].filter((id) => id >= 0 && id < head.particles.length);
    return ids.map((id) => `${head.species[head.particles[id]].name} ${id}`).join(" and ");
  }

  write(time) {
    const { picture, speed } = this.live;
    const digits = Math.max(0, Math.min(9, Math.ceil(1.3 - Math.log10(speed))));
    const list = document.createDocumentFragment();
    const marks = document.createDocumentFragment();
    for (const event of this.shown) {
      const { a, b, kind, time: at, colour } = event;
      const item = document.createElement("li");
      const wait = at > time ? `in ${(at - time).toFixed(digits)}` : "now";
      item.style.setProperty("--mark", colour);
      item.append(liveTag("strong", this.names(event)), liveTag("span", `${EVENT_WORDS[kind] ?? kind} ${wait}`));
      list.append(item);
      for (const id of [a, b]) {
        const place = this.place(id);
        const index = this.live.order?.get(id);
        if (place) {
          const { x, y, unit } = picture.project(place);
          const closing = Math.max(0, Math.min((at - time) / speed, 2)) * 9;
          marks.append(liveRing(x, y, Math.max(picture.particles.radii[index] * unit, 4) + 3 + closing, colour));
        }
      }
    }
    liveElement("upcoming").replaceChildren(list);
    liveElement("marks").replaceChildren(marks);
    liveElement("next").hidden = this.shown.length === 0;
  }
}

function liveTag(name, words) {
  const made = document.createElement(name);
  made.textContent = words;
  return made;
}

function liveRing(x, y, radius, colour) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", "circle");
  for (const [name, value] of Object.entries({ cx: x.toFixed(1), cy: y.toFixed(1), r: radius.toFixed(1), stroke: colour })) {
    made.setAttribute(name, value);
  }
  return made;
}

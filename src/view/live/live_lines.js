/** Numbers per line: two ends, the width at each end in pixels, and the colour. */
const LINE = 9;

/** Lines drawn over the opaque objects of a picture. */
class Lines {
  constructor(renderer) {
    const { gl } = renderer;
    this.renderer = renderer;
    this.used = program(gl, "line");
    this.ends = renderer.buffer(new Float32Array(0));
    this.shape = renderer.shape(this.used, [
      ["corner", renderer.quad, 2, gl.FLOAT, 8, 0, 0],
      ["start", this.ends, 3, gl.FLOAT, 4 * LINE, 0, 1],
      ["end", this.ends, 3, gl.FLOAT, 4 * LINE, 12, 1],
      ["widths", this.ends, 2, gl.FLOAT, 4 * LINE, 24, 1],
      ["ink", this.ends, 4, gl.UNSIGNED_BYTE, 4 * LINE, 32, 1, true],
    ]);
    this.room(256);
    this.count = 0;
  }

  room(count) {
    const numbers = new Float32Array(LINE * count);
    numbers.set(this.numbers ?? []);
    this.numbers = numbers;
    this.inks = new Uint8Array(numbers.buffer);
  }

  clear() {
    this.count = 0;
  }

  /** Adds a line between two points, each given by a table of coordinates and an index. */
  add([from, a], [to, b], [first, last], [red, green, blue], opacity) {
    if (this.numbers.length < LINE * (this.count + 1)) {
      this.room(2 * this.count + 1);
    }
    const { numbers, inks } = this;
    const at = LINE * this.count;
    for (let k = 0; k < 3; k += 1) {
      numbers[at + k] = from[a + k];
      numbers[at + 3 + k] = to[b + k];
    }
    numbers[at + 6] = first;
    numbers[at + 7] = last;
    inks[4 * at + 32] = red;
    inks[4 * at + 33] = green;
    inks[4 * at + 34] = blue;
    inks[4 * at + 35] = 255 * opacity;
    this.count += 1;
  }

  draw(camera, scheme, lift) {
    const { renderer, used, count } = this;
    const { gl, canvas } = renderer;
    if (count === 0) {
      return;
    }
    renderer.fill(this.ends, this.numbers.subarray(0, LINE * count));
    const uniforms = renderer.use(used, camera, scheme);
    gl.uniform2f(uniforms.viewport, canvas.width, canvas.height);
    gl.uniform1f(uniforms.nearest, camera.near);
    gl.uniform1f(uniforms.lift, lift);
    gl.bindVertexArray(this.shape);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    gl.bindVertexArray(null);
  }
}

/** Number of positions in a trail. */
const TRAIL = 150;

/** Trails: the last positions of some particles. */
class Trails {
  constructor(head) {
    this.head = head;
    this.indices = [];
    this.clear();
  }

  clear() {
    this.length = 0;
    this.next = 0;
    this.time = undefined;
  }

  /** Follows `count` evenly chosen particles. A particle chosen by hand replaces the first one. */
  follow(count, chosen) {
    const { length } = this.head.moving;
    const number = Math.min(count, length);
    this.indices = [...Array(number).keys()].map((k) => Math.floor(((k + 0.5) * length) / number));
    if (chosen >= 0 && number > 0 && !this.indices.includes(chosen)) {
      this.indices[0] = chosen;
    }
    this.places = new Float32Array(3 * TRAIL * number);
    this.clear();
  }

  note({ time, positions }) {
    if (this.indices.length === 0 || time === this.time) {
      return;
    }
    this.time = time;
    this.indices.forEach((index, k) => {
      this.places.set(positions.subarray(3 * index, 3 * index + 3), 3 * (TRAIL * k + this.next));
    });
    this.next = (this.next + 1) % TRAIL;
    this.length = Math.min(this.length + 1, TRAIL);
  }

  /** Adds fading lines between successive positions, except across a periodic side. */
  write(lines, colours, width) {
    const { head, places } = this;
    const isJump = (a, b) => [0, 1, 2].some((k) => head.periodic[k] && Math.abs(places[a + k] - places[b + k]) > head.size[k] / 2);
    this.indices.forEach((_, k) => {
      for (let back = 1; back < this.length; back += 1) {
        const place = (steps) => 3 * (TRAIL * k + ((this.next - steps + 2 * TRAIL) % TRAIL));
        const [from, to] = [place(back + 1), place(back)];
        if (!isJump(from, to)) {
          lines.add([places, from], [places, to], [width, width], colours[k % colours.length], 0.9 * (1 - back / TRAIL));
        }
      }
    });
  }
}

/** Largest number of arrows in a picture. */
const ARROWS = 6000;

/** Adds arrows for the velocities. At the root-mean-square speed, an arrow has the length `length`. */
function writeArrows(lines, { positions, velocities }, { length, pixel, ink, limit }) {
  const count = positions.length / 3;
  const stride = Math.ceil(count / ARROWS);
  let squares = 0;
  for (let k = 0; k < velocities.length; k += 1) {
    squares += velocities[k] * velocities[k];
  }
  const typical = Math.sqrt(squares / Math.max(count, 1));
  const factor = typical > 0 ? length / typical : 0;
  const [neck, tip] = [[0, 0, 0], [0, 0, 0]];
  for (let k = 0; k < count; k += stride) {
    const at = 3 * k;
    const reach = factor * Math.hypot(velocities[at], velocities[at + 1], velocities[at + 2]);
    if (reach < 2 * pixel || !(reach < Infinity)) {
      continue;
    }
    const stretch = (factor * Math.min(reach, limit)) / reach;
    const head = Math.max(1 - (9 * pixel) / Math.min(reach, limit), 0.4);
    for (let axis = 0; axis < 3; axis += 1) {
      tip[axis] = positions[at + axis] + stretch * velocities[at + axis];
      neck[axis] = positions[at + axis] + head * stretch * velocities[at + axis];
    }
    lines.add([positions, at], [neck, 0], [2.2, 2.2], ink, 0.85);
    lines.add([neck, 0], [tip, 0], [8, 0], ink, 0.85);
  }
}

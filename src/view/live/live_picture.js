/** Time in which a flash fades to about a third `[ms]`. */
const FADE = 110;

const FEW = 60;

class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.dark = window.matchMedia("(prefers-color-scheme: dark)");
    this.chosen = -1;
    this.trailCount = 0;
    this.choices = { hasBox: true, hasSurfaces: true, fixed: "veil", hasArrows: false, hasFlashes: true, hasShadows: true };
  }

  get scheme() {
    return this.dark.matches ? SCHEMES.dark : SCHEMES.light;
  }

  /** Begins a scene. If only values have changed, the camera stays. */
  begin(head, isSame) {
    this.head = head;
    this.particles = liveParticles(head);
    if (this.renderer) {
      this.renderer.show(this.particles);
    } else {
      this.renderer = new Renderer(this.canvas, this.particles);
      this.lines = new Lines(this.renderer);
    }
    this.glow = new Float32Array(head.moving.length);
    this.flashes = new Uint8Array(head.moving.length);
    this.share = 0;
    this.paint();
    this.frame = undefined;
    this.isSameView = isSame && this.camera !== undefined;
    this.chosen = this.isSameView ? this.chosen : -1;
    this.trails = new Trails(head);
    this.trails.follow(this.trailCount, this.chosen);
  }

  paint() {
    this.renderer.setColours(speciesColours(this.head.species, this.scheme.fixed), scaleColours());
  }

  /** Points the camera at the initial positions of a scene. */
  aim(frame) {
    if (!this.isSameView) {
      // The pointer controls refer to this object. The user's direction is kept if the upward axis is the same.
      const camera = new Camera({ ...this.head, look: this.head.live?.view });
      const { isMoved, azimuth, elevation } = this.camera?.isMoved && String(this.camera.up) === String(camera.up) ? this.camera : {};
      this.camera = Object.assign(this.camera ?? camera, camera);
      this.camera.margin = this.renderer.largest;
      this.camera.reset(this.renderer.resize());
      if (isMoved) {
        Object.assign(this.camera, { isMoved, azimuth, elevation });
        this.camera.fit(this.renderer.resize());
      }
      this.isSameView = true;
    }
    let reach = this.camera.extent;
    for (const places of [frame.positions, this.head.fixedPositions]) {
      for (let at = 0; at + 2 < places.length; at += 3) {
        const [x, y, z] = [places[at] - this.camera.centre[0], places[at + 1] - this.camera.centre[1], places[at + 2] - this.camera.centre[2]];
        reach = Math.max(reach, Math.hypot(x, y, z));
      }
    }
    this.camera.reach = 1.2 * reach + 2 * this.camera.margin;
  }

  take(frame, now) {
    const last = this.frame;
    this.frame = frame;
    if (!last || frame.time < last.time) {
      this.aim(frame);
      this.trails.clear();
    }
    this.trails.note(frame);
    this.fade(frame, now);
    this.load();
    return last;
  }

  /** Fades old flashes, and lights new ones at contacts. If many particles flash, the flashes are weak or absent. */
  fade({ hits, time }, now) {
    const { glow, flashes } = this;
    const spent = time === this.fadedTime ? 0 : Math.min(now - (this.fadedAt ?? now), 100);
    const factor = Math.exp(-spent / FADE);
    this.fadedAt = now;
    this.fadedTime = time;
    let sum = 0;
    for (let k = 0; k < glow.length; k += 1) {
      glow[k] = hits[k] ? 1 : glow[k] * factor;
      sum += glow[k];
    }
    // A single collision lights a large share of a small system, so the share is averaged over time.
    const settling = glow.length < FEW ? 1 - Math.exp(-spent / 1000) : 1;
    this.share += settling * (sum / Math.max(glow.length, 1) - this.share);
    const [most, least] = glow.length < FEW ? [0.5, 0.25] : [0.35, 0.1];
    const scale = this.choices.hasFlashes ? 255 * Math.min(Math.max((most - this.share) / (most - least), 0), 1) : 0;
    for (let k = 0; k < glow.length; k += 1) {
      flashes[k] = scale * glow[k] * glow[k];
    }
  }

  load() {
    const { frame, head, flashes } = this;
    const { positions, tones, poses, displacement, growth } = frame;
    this.renderer.load({ positions, tones, flashes, range: [0, 1], scale: [0, 1], box: head, displacement, growth, poses });
  }

  choose(index) {
    this.chosen = index;
    this.follow(this.trailCount);
  }

  follow(count) {
    this.trailCount = count;
    this.trails?.follow(count, this.chosen);
  }

  draw() {
    const { renderer, camera, scheme, choices, lines, frame } = this;
    const aspect = renderer.resize();
    const look = camera.look(aspect);
    renderer.draw(look, scheme, choices);
    const { gl } = renderer;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    const sharp = Math.max(1, this.canvas.width / Math.max(this.canvas.clientWidth, 1));
    lines.clear();
    this.trails.write(lines, this.trailColours(), 2.4 * sharp);
    lines.draw(look, scheme, 0);
    if (choices.hasArrows) {
      const pixel = ((2 * SLOPE * camera.distance) / this.canvas.height) * sharp;
      const length = Math.max(2.2 * this.meanRadius(), 14 * pixel);
      const ink = scheme.ink.slice(0, 3).map((part) => 255 * part);
      lines.clear();
      writeArrows(lines, frame, { length, pixel, ink, limit: 5 * length });
      lines.draw(look, scheme, 1.1 * renderer.largest);
    }
  }

  meanRadius() {
    const { radii, moving } = this.particles;
    return radii.subarray(0, moving).reduce((sum, radius) => sum + radius, 0) / Math.max(moving, 1);
  }

  trailColours() {
    return this.trails.indices.length === 1 ? [PALETTE[3]] : [PALETTE[3], PALETTE[4], PALETTE[2], PALETTE[5], PALETTE[1], PALETTE[0]];
  }

  /** Returns the axes and position of the camera, and the pixels per unit of length at a distance of 1. */
  sight() {
    const { right, above, back } = this.camera.axes();
    const eye = add(this.camera.target, scaled(back, this.camera.distance));
    return { right, above, back, eye, focus: this.canvas.clientHeight / (2 * SLOPE) };
  }

  /** Returns the position of a point in the picture, and the size of a unit of length there `[pixels]`. */
  project(point, { right, above, back, eye, focus } = this.sight()) {
    const way = subtract(point, eye);
    const depth = -dot(way, back);
    const unit = focus / depth;
    return { x: this.canvas.clientWidth / 2 + dot(way, right) * unit, y: this.canvas.clientHeight / 2 - dot(way, above) * unit, unit, depth };
  }

  position(index) {
    return [...this.frame.positions.subarray(3 * index, 3 * index + 3)];
  }

  /** Returns the index of the nearest moving particle at a position in the picture, or -1. */
  pick(x, y) {
    const sight = this.sight();
    let [found, nearest] = [-1, Infinity];
    for (let index = 0; this.frame && index < this.head.moving.length; index += 1) {
      const seen = this.project(this.frame.positions.subarray(3 * index, 3 * index + 3), sight);
      const radius = Math.max(this.particles.radii[index] * seen.unit, 6);
      if (seen.depth > 0 && seen.depth < nearest && Math.hypot(seen.x - x, seen.y - y) < radius) {
        [found, nearest] = [index, seen.depth];
      }
    }
    return found;
  }

  /** Returns the point at a position in the picture, in the plane through `through` that is parallel to the screen. */
  unproject(x, y, through) {
    const { right, above, back, eye, focus } = this.sight();
    const depth = -dot(subtract(through, eye), back);
    const across = ((x - this.canvas.clientWidth / 2) / focus) * depth;
    const high = ((this.canvas.clientHeight / 2 - y) / focus) * depth;
    return add(eye, add(scaled(back, -depth), add(scaled(right, across), scaled(above, high))));
  }
}

/** Tangent of half the field-of-view angle. */
const SLOPE = Math.tan((30 * Math.PI) / 360);

/** A camera that orbits a target. */
class Camera {
  constructor(head) {
    const flat = [0, 1, 2].filter((k) => head.flat[k]);
    const across = [0, 1, 2].find((k) => k !== head.up && !head.flat[k]) ?? [0, 1, 2].find((k) => k !== head.up);
    this.right = unitVector(across, 1);
    this.up = unitVector(head.up, head.isUpsideDown ? -1 : 1);
    this.front = cross(this.right, this.up);
    this.isFlat = flat.length > 0;
    this.first = this.angles(head.look);
    const [lower, upper] = head.view;
    this.centre = scaled(add(lower, upper), 0.5);
    this.corners = [0, 1, 2, 3, 4, 5, 6, 7].map((index) => [0, 1, 2].map((k) => ((index >> k) & 1 ? upper[k] : lower[k])));
    this.extent = Math.max(norm(subtract(upper, lower)) / 2, 1e-30);
    this.margin = 0;
    this.reach = this.extent;
    this.reset(1);
  }

  /**
   * Returns the azimuth and elevation of the first view in radians. A flat scene is seen from the front, and any other
   * scene from a raised corner. `look` (in degrees) replaces these defaults.
   */
  angles(look) {
    return (look ?? (this.isFlat ? [0, 0] : [28, 18])).map((angle) => (angle * Math.PI) / 180);
  }

  /** Restores the first view, as close as possible with the whole box in sight. */
  reset(aspect) {
    [this.azimuth, this.elevation] = this.first;
    this.target = this.centre;
    this.isMoved = false;
    this.fit(aspect);
  }

  fit(aspect) {
    const { right, above, back } = this.axes();
    let distance = 0;
    for (const corner of this.corners) {
      const place = subtract(corner, this.centre);
      const across = (Math.abs(dot(place, right)) + this.margin) / (SLOPE * aspect);
      const high = (Math.abs(dot(place, above)) + this.margin) / SLOPE;
      distance = Math.max(distance, dot(place, back) + this.margin + Math.max(across, high));
    }
    this.distance = 1.04 * Math.max(distance, this.extent * 0.1);
  }

  axes() {
    const flat = add(scaled(this.right, Math.sin(this.azimuth)), scaled(this.front, Math.cos(this.azimuth)));
    const back = add(scaled(flat, Math.cos(this.elevation)), scaled(this.up, Math.sin(this.elevation)));
    const right = subtract(scaled(this.right, Math.cos(this.azimuth)), scaled(this.front, Math.sin(this.azimuth)));
    return { right, above: cross(back, right), back };
  }

  turn(across, up) {
    const steepest = (89 * Math.PI) / 180;
    this.azimuth = (this.azimuth - across) % (2 * Math.PI);
    this.elevation = Math.min(Math.max(this.elevation + up, -steepest), steepest);
    this.isMoved = true;
  }

  /** Moves the target by fractions of the picture's height. */
  move(across, up) {
    const { right, above } = this.axes();
    const height = 2 * SLOPE * this.distance;
    this.target = add(this.target, add(scaled(right, -across * height), scaled(above, up * height)));
    this.isMoved = true;
  }

  zoom(factor) {
    const nearest = Math.max(this.margin, this.extent * 1e-4);
    this.distance = Math.min(Math.max(this.distance * factor, nearest), 40 * this.extent + 40 * this.margin);
    this.isMoved = true;
  }

  /** Returns the parameters of the camera for the shaders. */
  look(aspect) {
    const { right, above, back } = this.axes();
    const eye = add(this.target, scaled(back, this.distance));
    const reach = this.reach + norm(subtract(this.target, this.centre));
    const near = Math.max(this.distance - reach, this.distance * 0.02);
    const far = this.distance + reach;
    return {
      view: viewMatrix(eye, right, above, back),
      projection: perspective(SLOPE, aspect, near, far),
      up: [dot(right, this.up), dot(above, this.up), dot(back, this.up)],
      near,
      distance: this.distance,
      haze: [Math.max(this.distance - this.extent, 0), this.distance + 1.3 * this.extent],
    };
  }
}

/**
 * Returns the shifts at which a particle is drawn, in periods along an axis. A particle that crosses a side is drawn at
 * both sides.
 */
function sticksOut(place, radius, lower, size) {
  const shifts = [0];
  if (place - lower < radius) {
    shifts.push(1);
  }
  if (lower + size - place < radius) {
    shifts.push(-1);
  }
  return shifts;
}

const NO_SHIFT = [0];

/**
 * Returns the images of particles that cross sides of the box: their owners and positions. There is one image at a
 * side, three at an edge and seven at a corner. The next image along y is displaced along x.
 */
function imagesOf({ positions, count, radii }, { lower, size }, periodic, displacement) {
  const [owners, places] = [[], []];
  const axes = [0, 1, 2].map((k) => periodic[k] && size[k] > 0);
  const shifts = (k, place, radius) => (axes[k] ? sticksOut(place, radius, lower[k], size[k]) : NO_SHIFT);
  for (let index = 0; index < count; index += 1) {
    const [x, y, z] = positions.subarray(3 * index, 3 * index + 3);
    const radius = radii[index];
    const isInside = [x, y, z].every((place, k) => !axes[k] || (place - lower[k] >= radius && lower[k] + size[k] - place >= radius));
    if (isInside || x !== x) {
      continue;
    }
    for (const up of shifts(1, y, radius)) {
      let along = x + up * displacement;
      if (axes[0] && up !== 0) {
        along -= size[0] * Math.floor((along - lower[0]) / size[0]);
      }
      for (const right of shifts(0, along, radius)) {
        for (const front of shifts(2, z, radius)) {
          if (up !== 0 || right !== 0 || front !== 0) {
            owners.push(index);
            places.push(along + right * size[0], y + up * size[1], z + front * size[2]);
          }
        }
      }
    }
  }
  return { owners, places };
}

class Images {
  constructor(renderer) {
    this.renderer = renderer;
    this.table = renderer.spheres(0);
  }

  /** The renderer must have loaded the state. */
  load({ positions, box, displacement = 0 }) {
    const { renderer, renderer: { moving, particles: { radii, periodic } } } = this;
    const { owners, places } = imagesOf({ positions, radii, count: moving.count }, box, periodic, displacement);
    if (owners.length > this.table.rows * ROW) {
      this.free();
      this.table = renderer.spheres(Math.ceil(1.5 * owners.length));
    }
    const { table } = this;
    table.count = owners.length;
    owners.forEach((owner, index) => {
      table.numbers.set(places.slice(3 * index, 3 * index + 3), 4 * index);
      table.numbers[4 * index + 3] = moving.numbers[4 * owner + 3];
      table.letters[2 * index] = moving.letters[2 * owner];
      table.letters[2 * index + 1] = moving.letters[2 * owner + 1];
    });
    table.quaternions = moving.quaternions && (table.quaternions ?? new Int8Array(4 * ROW * table.rows));
    owners.forEach((owner, index) => table.quaternions?.set(moving.quaternions.subarray(4 * owner, 4 * owner + 4), 4 * index));
    renderer.upload(table);
  }

  free() {
    this.renderer.free(this.table);
  }

  draw(uniforms) {
    if (this.table.count > 0) {
      this.renderer.drawGroup(uniforms, this.table, 1);
    }
  }
}

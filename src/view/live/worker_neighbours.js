/** Reach of a neighbour, in distances of contact: before the second shell of a dense fluid. */
const NEIGHBOUR_REACH = 1.4;

/** Counts the neighbours of particles: how many others have their centre within a reach. */
class Neighbours {
  constructor(head) {
    this.head = head;
    this.radii = Float64Array.from(head.particles, (species) => head.species[species].diameter / 2);
    this.reach = 2 * NEIGHBOUR_REACH * this.radii.reduce((most, radius) => Math.max(most, radius), 0);
    this.cells = [1, 1, 1];
    this.lower = [0, 0, 0];
    this.edge = [1, 1, 1];
    this.next = new Int32Array(head.particles.length);
    this.first = new Int32Array(1);
  }

  /** A grid whose cells are no smaller than the reach, and not many more than particles. */
  grid(positions) {
    const { head } = this;
    const most = Math.ceil(Math.cbrt(4 * head.particles.length));
    for (let axis = 0; axis < 3; axis += 1) {
      let [low, high] = [head.lower[axis], head.lower[axis] + head.size[axis]];
      if (!head.periodic[axis]) {
        [low, high] = [Infinity, -Infinity];
        for (let at = axis; at < positions.length; at += 3) {
          low = Math.min(low, positions[at]);
          high = Math.max(high, positions[at]);
        }
      }
      const number = this.reach > 0 ? Math.floor((high - low) / this.reach) : 1;
      this.cells[axis] = Math.max(1, Math.min(number, head.flat.some(Boolean) ? most * most : most));
      this.lower[axis] = low;
      this.edge[axis] = Math.max((high - low) / this.cells[axis], 1e-300);
    }
    const count = this.cells[0] * this.cells[1] * this.cells[2];
    if (this.first.length < count) {
      this.first = new Int32Array(count);
    }
    this.first.fill(-1, 0, count);
  }

  cell(position, axis) {
    return Math.min(Math.max(Math.floor((position - this.lower[axis]) / this.edge[axis]), 0), this.cells[axis] - 1);
  }

  /** Numbers of neighbours of all particles, at most 255. */
  count(positions, counts) {
    this.grid(positions);
    counts.fill(0);
    const { next, first, cells } = this;
    for (let id = 0; id < next.length; id += 1) {
      const own = [0, 1, 2].map((axis) => this.cell(positions[3 * id + axis], axis));
      // Particles that are already in the grid, so that each pair is met once.
      this.around(own, (cell) => {
        for (let other = first[cell]; other >= 0; other = next[other]) {
          if (this.isNear(positions, id, other)) {
            counts[id] = Math.min(counts[id] + 1, 255);
            counts[other] = Math.min(counts[other] + 1, 255);
          }
        }
      });
      const cell = own[0] + cells[0] * (own[1] + cells[1] * own[2]);
      next[id] = first[cell];
      first[cell] = id;
    }
    return counts;
  }

  /** The cells around one, each once. */
  around(own, visit) {
    const { cells, head } = this;
    const along = own.map((at, axis) => {
      const places = [at];
      for (const place of [at - 1, at + 1]) {
        const wrapped = head.periodic[axis] ? (place + cells[axis]) % cells[axis] : place;
        if (wrapped >= 0 && wrapped < cells[axis] && !places.includes(wrapped)) {
          places.push(wrapped);
        }
      }
      return places;
    });
    for (const z of along[2]) {
      for (const y of along[1]) {
        for (const x of along[0]) {
          visit(x + cells[0] * (y + cells[1] * z));
        }
      }
    }
  }

  isNear(positions, id, other) {
    const { head, radii } = this;
    let square = 0;
    for (let axis = 0; axis < 3; axis += 1) {
      let way = positions[3 * id + axis] - positions[3 * other + axis];
      if (head.periodic[axis]) {
        way -= Math.round(way / head.size[axis]) * head.size[axis];
      }
      square += way * way;
    }
    const reach = NEIGHBOUR_REACH * (radii[id] + radii[other]);
    return square < reach * reach;
  }
}

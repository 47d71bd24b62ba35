/**
 * Distance within which two particles are neighbours, in contact distances. The second shell of a dense fluid is
 * outside.
 */
const NEIGHBOUR_REACH = 1.4;

/** Counts neighbours: other particles whose centres are within reach. */
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

  /** Sets up a grid with cells at least as long as the reach, and not many more cells than particles. */
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

  /** Counts the neighbours of all particles, at most 255 each. */
  count(positions, counts) {
    this.grid(positions);
    counts.fill(0);
    const { next, first, cells } = this;
    for (let id = 0; id < next.length; id += 1) {
      const [x, y, z] = [this.cell(positions[3 * id], 0), this.cell(positions[3 * id + 1], 1), this.cell(positions[3 * id + 2], 2)];
      const cell = x + cells[0] * (y + cells[1] * z);
      next[id] = first[cell];
      first[cell] = id;
    }
    const [across, along, up] = [this.around(0), this.around(1), this.around(2)];
    for (let cell = 0; cell < cells[0] * cells[1] * cells[2]; cell += 1) {
      if (first[cell] < 0) {
        continue;
      }
      const row = Math.floor(cell / cells[0]);
      for (const z of up[Math.floor(row / cells[1])]) {
        for (const y of along[row % cells[1]]) {
          for (const x of across[cell % cells[0]]) {
            this.meet(positions, counts, cell, x + cells[0] * (y + cells[1] * z));
          }
        }
      }
    }
    return counts;
  }

  /** Returns each cell along an axis with its adjacent cells, without duplicates. */
  around(axis) {
    const { cells, head } = this;
    const number = cells[axis];
    const beside = (at) => [at, at - 1, at + 1].map((place) => (head.periodic[axis] ? (place + number) % number : place));
    return [...Array(number).keys()].map((at) => [...new Set(beside(at))].filter((place) => place >= 0 && place < number));
  }

  /** Counts pairs within a cell or between two cells. Each pair of cells is evaluated once. */
  meet(positions, counts, cell, other) {
    const { next, first } = this;
    for (let id = first[cell]; id >= 0 && other >= cell; id = next[id]) {
      for (let beside = other === cell ? next[id] : first[other]; beside >= 0; beside = next[beside]) {
        if (this.isNear(positions, id, beside)) {
          counts[id] = Math.min(counts[id] + 1, 255);
          counts[beside] = Math.min(counts[beside] + 1, 255);
        }
      }
    }
  }

  isNear(positions, id, other) {
    const { head, radii } = this;
    let square = 0;
    for (let axis = 0; axis < 3; axis += 1) {
      let way = positions[3 * id + axis] - positions[3 * other + axis];
      if (head.periodic[axis] && Math.abs(way) > head.size[axis] / 2) {
        way -= Math.sign(way) * head.size[axis];
      }
      square += way * way;
    }
    const reach = NEIGHBOUR_REACH * (radii[id] + radii[other]);
    return square < reach * reach;
  }
}

/** Number of pair distances in a sample. They take about a millisecond. */
const MOST_DISTANCES = 80_000;

const RADIAL_BINS = 160;

/**
 * Distances of points with a uniform density in the region of the particle centres. Walls keep the centres half a
 * diameter away.
 * The density of the separation s is a product over the axes: (1 - |s_k| / L_k) / L_k, or 1 / L_k if the axis is
 * periodic. Below the shortest edge, its average over all directions is a polynomial in |s|. The coefficients contain
 * the averages of |u_x|, |u_x u_y| and |u_x u_y u_z| over unit vectors u.
 */
class Room {
  constructor(system, diameter) {
    this.dimensions = system.dimensions;
    this.shortest = Infinity;
    this.volume = 1;
    this.sums = [1, 0, 0, 0];
    for (const k of system.axes) {
      const left = system.size[k] - 0.5 * diameter * system.walls(k);
      const edge = left > 0 ? left : system.size[k];
      this.volume *= edge;
      if (!system.periodic[k]) {
        this.shortest = Math.min(this.shortest, edge);
        for (let order = 3; order > 0; order -= 1) {
          this.sums[order] += this.sums[order - 1] / edge;
        }
      }
    }
  }

  /** Returns the probability that the distance of two points is above `from` and at most `to`. */
  probability(from, to) {
    const { PI } = Math;
    const surface = [0, 2, 2 * PI, 4 * PI][this.dimensions];
    const means = [[], [1, 1, 0, 0], [1, 2 / PI, 1 / PI, 0], [1, 0.5, 2 / (3 * PI), 0.25 / PI]][this.dimensions];
    let total = 0;
    for (let order = 0; order < 4; order += 1) {
      const exponent = this.dimensions + order;
      total += ((order % 2 ? -1 : 1) * means[order] * this.sums[order] * (to ** exponent - from ** exponent)) / exponent;
    }
    return (surface * total) / this.volume;
  }
}

/**
 * g(r) = n(r) / n_ideal(r), where n_ideal is the number of pairs in a bin without correlations.
 * Each sample takes some particles as centres, and the next sample takes the next particles. This limits the cost of a
 * sample. Two species have three curves; more species are treated as one.
 */
class RadialDistribution {
  constructor(system, { cutoff = Infinity, width, most = MOST_DISTANCES, scale = 1 } = {}) {
    this.system = system;
    this.most = most;
    this.scale = scale;
    const { head, moving } = system;
    const present = [...new Set(Array.from(moving, (id) => head.particles[id]))].sort((a, b) => a - b);
    const classes = present.length <= 2 ? present.map((index) => [index]) : [present];
    this.classes = new Int8Array(head.species.length);
    classes.forEach((members, number) => members.forEach((index) => (this.classes[index] = number)));
    this.counts = classes.map((members) => moving.filter((id) => members.includes(head.particles[id])).length);
    const diameters = present.map((index) => scale * head.species[index].diameter);
    const largest = Math.max(...diameters);
    const half = Math.min(...system.axes.map((k) => (system.periodic[k] ? 0.5 * system.size[k] : Infinity)));
    const mean = classes.map(
      (members) => (scale * members.reduce((sum, index) => sum + head.species[index].diameter, 0)) / members.length,
    );
    const rooms = mean.map((diameter) => new Room(system, diameter));
    const reach = Math.min(half, ...rooms.map((room) => room.shortest));
    this.cutoff = Math.min(cutoff, reach, largest > 0 ? 4 * largest : Infinity);
    if (!Number.isFinite(this.cutoff)) {
      this.cutoff = reach;
    }
    // One bin starts exactly at contact.
    const core = Math.min(...diameters);
    const perCore = Math.max(8, Math.round((RADIAL_BINS * core) / this.cutoff));
    this.width = width ?? (core > 0 && core < this.cutoff ? core / perCore : this.cutoff / RADIAL_BINS);
    this.bins = Math.max(1, Math.floor(this.cutoff / this.width + 1e-9));
    this.cutoff = Math.min(this.cutoff, this.bins * this.width);
    this.pairs =
      classes.length === 2
        ? [
            [0, 0],
            [0, 1],
            [1, 1],
          ]
        : [[0, 0]];
    this.names = this.pairs.map((pair) =>
      classes.length === 2 ? pair.map((number) => head.species[present[number]].name).join("–") : "g(r)",
    );
    this.probabilities = this.pairs.map(([a, b]) => this.shells(rooms[a], rooms[b]));
    // Pair counts by curve and bin, then the number of centres of each class.
    this.sums = new LateSums(this.pairs.length * this.bins + 2);
    this.next = 0;
    this.periods = Float64Array.from([0, 1, 2], (k) => (system.periodic[k] ? system.size[k] : Infinity));
    this.makeCells();
  }

  shells(...rooms) {
    const shell = (room, k) => room.probability(k * this.width, (k + 1) * this.width);
    return Float64Array.from({ length: this.bins }, (_, k) => Math.sqrt(shell(rooms[0], k) * shell(rooms[1], k)));
  }

  /** Sets up cells at least half as long as the cutoff. An axis with fewer than five such cells has one cell. */
  makeCells() {
    const { system, cutoff } = this;
    const most = Math.max(1, Math.floor((2 * system.count) ** (1 / system.dimensions)));
    this.cells = [1, 1, 1];
    for (const k of system.axes) {
      const number = Math.min(Math.floor((2 * system.size[k]) / cutoff), most);
      this.cells[k] = number >= 5 ? number : 1;
    }
    this.steps = this.cells.map((number, k) =>
      number === 1
        ? 0
        : Math.min(Math.ceil((cutoff * number) / system.size[k] - 1e-9), (number - 1) >> (system.periodic[k] ? 1 : 0)),
    );
    const total = this.cells[0] * this.cells[1] * this.cells[2];
    this.starts = new Uint32Array(total + 1);
    this.cellOf = new Uint32Array(system.count);
    this.sorted = new Float64Array(3 * system.count);
    this.classOf = new Int8Array(system.count);
    this.placeOf = new Uint32Array(system.count);
  }

  sort(positions) {
    const { system, cells, starts, cellOf, sorted, classOf, placeOf } = this;
    const { moving, lower, size, head } = system;
    starts.fill(0);
    for (let n = 0; n < moving.length; n += 1) {
      let cell = 0;
      for (let k = 2; k >= 0; k -= 1) {
        const number = cells[k];
        const at = number === 1 ? 0 : Math.floor(((positions[3 * moving[n] + k] - lower[k]) / size[k]) * number);
        cell = cell * number + Math.min(Math.max(at, 0), number - 1);
      }
      cellOf[n] = cell;
      starts[cell + 1] += 1;
    }
    for (let cell = 1; cell < starts.length; cell += 1) {
      starts[cell] += starts[cell - 1];
    }
    const free = starts.slice();
    for (let n = 0; n < moving.length; n += 1) {
      const place = free[cellOf[n]];
      free[cellOf[n]] += 1;
      placeOf[n] = place;
      classOf[place] = this.classes[head.particles[moving[n]]];
      for (let k = 0; k < 3; k += 1) {
        sorted[3 * place + k] = system.flat[k] ? 0 : positions[3 * moving[n] + k];
      }
    }
  }

  sample(time, positions) {
    this.sums.turn(time);
    this.sort(positions);
    const { system, sums, classOf, cellOf, placeOf } = this;
    let distances = 0;
    let centres = 0;
    while (centres < system.count && distances < this.most) {
      const place = placeOf[this.next];
      distances += this.around(place, cellOf[this.next]);
      sums.newer[this.pairs.length * this.bins + classOf[place]] += 1;
      centres += 1;
      this.next = (this.next + 1) % system.count;
    }
  }

  /** Counts the neighbours of a particle, and returns the number of distances evaluated. */
  around(place, cell) {
    const { cells, steps, starts } = this;
    const { periodic } = this.system;
    const at = [cell % cells[0], Math.floor(cell / cells[0]) % cells[1], Math.floor(cell / (cells[0] * cells[1]))];
    const [low, high] = [at[0] - steps[0], at[0] + steps[0]];
    const inside = (k, x) => (periodic[k] ? (x + cells[k]) % cells[k] : x);
    const last = cells[0] - 1;
    let distances = 0;
    for (let z = at[2] - steps[2]; z <= at[2] + steps[2]; z += 1) {
      const layer = inside(2, z);
      for (let y = at[1] - steps[1]; layer >= 0 && layer < cells[2] && y <= at[1] + steps[1]; y += 1) {
        const row = inside(1, y);
        if (row < 0 || row >= cells[1]) {
          continue;
        }
        // Cells of a row are adjacent in memory. The search continues at the other end of a periodic axis.
        const first = cells[0] * (row + cells[1] * layer);
        distances += this.count(place, starts[first + Math.max(low, 0)], starts[first + Math.min(high, last) + 1]);
        if (periodic[0] && low < 0) {
          distances += this.count(place, starts[first + cells[0] + low], starts[first + cells[0]]);
        }
        if (periodic[0] && high > last) {
          distances += this.count(place, starts[first], starts[first + high - last]);
        }
      }
    }
    return distances;
  }

  /** Counts the particles in a range that are within the cutoff. Returns the length of the range. */
  count(place, first, end) {
    const { sorted, classOf, bins, periods } = this;
    const counts = this.sums.newer;
    const x = sorted[3 * place];
    const y = sorted[3 * place + 1];
    const z = sorted[3 * place + 2];
    const periodX = periods[0];
    const periodY = periods[1];
    const periodZ = periods[2];
    const own = classOf[place];
    const most = this.cutoff * this.cutoff;
    const scale = 1 / this.width;
    for (let other = first; other < end; other += 1) {
      let dx = Math.abs(sorted[3 * other] - x);
      let dy = Math.abs(sorted[3 * other + 1] - y);
      let dz = Math.abs(sorted[3 * other + 2] - z);
      // Distance to the nearest periodic image. The period is infinite along axes that are not periodic.
      dx = Math.min(dx, Math.abs(periodX - dx));
      dy = Math.min(dy, Math.abs(periodY - dy));
      dz = Math.min(dz, Math.abs(periodZ - dz));
      const square = dx * dx + dy * dy + dz * dz;
      if (square < most && other !== place) {
        const bin = Math.floor(Math.sqrt(square) * scale);
        if (bin < bins) {
          counts[(own + classOf[other]) * bins + bin] += 1;
        }
      }
    }
    return end - first;
  }

  results() {
    const { bins, pairs, sums, counts } = this;
    const centres = [0, 1].map((number) => sums.total(pairs.length * bins + number));
    const g = pairs.map(([a, b], pair) => {
      // Particles of both species are centres.
      const partners = a === b ? centres[a] * (counts[a] - 1) : centres[a] * counts[b] + centres[b] * counts[a];
      return Float64Array.from(
        { length: bins },
        (_, k) => sums.total(pair * bins + k) / (partners * this.probabilities[pair][k]),
      );
    });
    // A class with a single particle has no pairs.
    const isThere = (_, pair) => pairs[pair][0] !== pairs[pair][1] || counts[pairs[pair][0]] > 1;
    const r = Float64Array.from({ length: bins }, (_, k) => (k + 0.5) * this.width);
    return { r, g: g.filter(isThere), names: this.names.filter(isThere), since: sums.from };
  }
}

class Observables {
  constructor(head) {
    this.head = head;
    this.system = new ObservedSystem(head);
    Object.assign(this, this.system.offer());
    this.wanted = undefined;
    this.begin();
  }

  begin() {
    const { system, offered } = this;
    const has = (name) => offered.includes(name);
    this.time = undefined;
    this.stage = undefined;
    this.marks = [];
    this.speeds = new Speeds(system);
    this.radial = has("radial") ? new RadialDistribution(system) : undefined;
    this.pressure = has("pressure") ? new Pressure(system) : undefined;
    this.displacement = has("displacement") ? new Displacement(system) : undefined;
    this.energy = new TimeSeries(2);
    this.planes = has("outflow") ? planesOf(system) : [];
    this.outflow = new TimeSeries(this.planes.length);
    this.kinds = undefined;
    this.counts = undefined;
    this.paths = has("positions") ? new Paths(system) : undefined;
  }

  /** Selects the observables to report. The default is all. */
  want(names) {
    this.wanted = names;
  }

  /** Samples a state: time, positions, velocities and images by id, energies, virial, event counts and stage. */
  sample(state) {
    const { time } = state;
    if (this.time !== undefined && time < this.time) {
      this.begin();
    }
    if (this.time !== undefined && time === this.time) {
      return;
    }
    if (this.stage !== undefined && state.stage !== this.stage) {
      this.marks.push({ time, name: String(this.head.stages?.[state.stage] ?? state.stage ?? "") });
    }
    this.time = time;
    this.stage = state.stage;
    this.learn(state);
    this.speeds.sample(time, state.velocities);
    this.radial?.sample(time, state.positions);
    if (this.pressure && Number.isFinite(state.virial)) {
      this.pressure.sample(time, state.virial, this.speeds.temperature);
    }
    if (state.images || !this.system.periodic.some(Boolean)) {
      this.displacement?.sample(time, state);
      this.paths?.sample(time, state);
    }
    this.energy.add(time, [state.kinetic, state.potential ?? 0]);
    this.countBelow(time, state.positions);
    this.countEvents(time, state);
  }

  /** Detects growing particles, and boxes that are sheared or open. */
  learn({ displacement, scale = 1, positions }) {
    const { system } = this;
    const isSheared = Boolean(displacement) && !system.isSheared;
    const isOpen = system.isUniform && !system.isPeriodic && system.hasEscaped(positions);
    if (isSheared || isOpen) {
      system.limit(isSheared, isOpen);
      const { offered, shown } = system.offer();
      Object.assign(this, { offered, shown });
      for (const name of ["radial", "pressure", "displacement"]) {
        this[name] = offered.includes(name) ? this[name] : undefined;
      }
    }
    if (this.radial && Math.abs(scale / this.radial.scale - 1) > 0.01) {
      this.radial = new RadialDistribution(system, { scale });
    }
  }

  countBelow(time, positions) {
    const { planes, system } = this;
    if (planes.length === 0) {
      return;
    }
    const below = planes.map(() => 0);
    for (let n = 0; n < system.moving.length; n += 1) {
      for (let k = 0; k < planes.length; k += 1) {
        const { axis, at, sign } = planes[k];
        below[k] += sign * (positions[3 * system.moving[n] + axis] - at) > 0 ? 1 : 0;
      }
    }
    this.outflow.add(time, below);
  }

  countEvents(time, { counts, events }) {
    const now = counts ?? { all: events ?? 0 };
    this.latest = now;
    if (!this.kinds) {
      this.kinds = Object.keys(now).filter((kind) => Number.isFinite(now[kind]));
      this.counts = new TimeSeries(this.kinds.length);
    }
    this.counts.add(
      time,
      this.kinds.map((kind) => now[kind]),
    );
  }

  /** Returns the selected results in new arrays. */
  results() {
    const { offered, shown, time, marks, system } = this;
    const results = { offered, shown, time, marks: [...marks], count: system.count };
    if (time === undefined) {
      return results;
    }
    const make = {
      speeds: () => this.speeds.results(),
      radial: () => this.radial.results(),
      energy: () => this.energyResults(),
      pressure: () => this.pressure.results(this.pressure.expected(this.latest, this.radial)),
      displacement: () => this.displacement.results(),
      autocorrelation: () => this.displacement.results(),
      outflow: () => {
        const [t, ...below] = this.outflow.read();
        return { t, below, names: this.planes.map(({ name }) => name) };
      },
      events: () => this.eventResults(),
      positions: () => this.paths.results(),
      portrait: () => this.paths.results(),
    };
    const is = (name) => (this.wanted ?? offered).includes(name);
    offered.filter(is).forEach((name) => (results[name] = make[name]()));
    return results;
  }

  energyResults() {
    const [t, kinetic, potential] = this.energy.read();
    // The initial potential energy in gravity is set to zero.
    const hasPotential = potential.some((value) => value !== 0);
    const zero = this.system.isHeavy ? potential[0] : 0;
    const relative = potential.map((value) => value - zero);
    const total = relative.map((value, k) => value + kinetic[k]);
    return hasPotential ? { t, kinetic, potential: relative, total, isRelative: this.system.isHeavy } : { t, kinetic };
  }

  /** Returns the numbers of events by kind. For many particles, returns the rates. */
  eventResults() {
    const [t, ...counts] = this.counts.read();
    const last = t.length - 1;
    const seen = this.kinds.map((name, k) => ({ name, values: counts[k] })).filter(({ values }) => values[last] > 0);
    const names = seen.map(({ name }) => name);
    if (this.system.count <= FEW || last < 1) {
      return { t, names, values: seen.map(({ values }) => values.map((value) => value - values[0])), from: t[0], isRate: false };
    }
    const ends = intervalsOf(t);
    const middles = Float64Array.from(ends.slice(1), (end, k) => 0.5 * (t[ends[k]] + t[end]));
    const rates = seen.map(({ values }) =>
      Float64Array.from(ends.slice(1), (end, k) => (values[end] - values[ends[k]]) / (t[end] - t[ends[k]])),
    );
    return { t: middles, names, values: rates, from: t[0], isRate: true };
  }
}

/**
 * Returns the planes below which particles are counted: up to four planes of the scene normal to gravity, or else one
 * plane above the lowest tenth of the box.
 */
function planesOf(system) {
  const { fall, gravity, lower, size, head } = system;
  const sign = Math.sign(gravity[fall]);
  const flows = (head.flows ?? []).filter(({ axis }) => axis === fall || axis === "xyz"[fall]);
  const planes = flows.slice(0, 4).map(({ name, at }) => ({ name, axis: fall, at, sign }));
  const at = sign < 0 ? lower[fall] + 0.1 * size[fall] : lower[fall] + 0.9 * size[fall];
  return planes.length > 0 ? planes : [{ name: "in the lowest tenth", axis: fall, at, sign }];
}

class Paths {
  constructor(system) {
    this.system = system;
    this.series = new RecentSeries(6 * system.count);
    this.axis = system.axes[0] ?? 0;
  }

  sample(time, { positions, velocities, images }) {
    const { moving, size } = this.system;
    const values = [];
    for (const id of moving) {
      for (let k = 0; k < 3; k += 1) {
        values.push(positions[3 * id + k] + (images ? images[3 * id + k] * size[k] : 0), velocities[3 * id + k]);
      }
    }
    this.series.add(time, values);
  }

  /**
   * Returns positions along the axis with the largest range. The axis changes only if another range is 1.5 times as
   * large.
   */
  results() {
    const { system } = this;
    const [t, ...columns] = this.series.read();
    const reach = (k) => Math.max(...Array.from(system.moving, (_, n) => spread(columns[6 * n + 2 * k])));
    for (const k of system.axes) {
      this.axis = reach(k) > 1.5 * reach(this.axis) ? k : this.axis;
    }
    const take = (offset) => Array.from(system.moving, (_, n) => columns[6 * n + 2 * this.axis + offset]);
    const names = Array.from(system.moving, (id) => `${system.head.species[system.head.particles[id]].name} ${id}`);
    return { t, axis: "xyz"[this.axis], x: take(0), v: take(1), names };
  }
}

function spread(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return high - low;
}

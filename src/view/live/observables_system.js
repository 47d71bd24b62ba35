/**
 * The moving particles, the axes that are not flat, and the meaningful observables.
 * Optional data in the head: `walls` (whether the lower and upper sides of each axis are walls), `shearRate`,
 * `conserved` (axes along which the momentum is conserved), `flows` (name, axis and position of planes), `isContained`
 * (a closed surface encloses the particles) and `hardSpheres` (a single species of elastic hard spheres).
 */
class ObservedSystem {
  constructor(head) {
    const { species, particles } = head;
    this.head = head;
    this.lower = head.lower;
    this.size = head.size;
    this.flat = head.flat ?? head.size.map((edge) => edge === 0);
    this.periodic = (head.periodic ?? [true, true, true]).map((is, k) => is && !this.flat[k]);
    this.axes = [0, 1, 2].filter((k) => !this.flat[k]);
    this.dimensions = this.axes.length;
    this.moving = Uint32Array.from(particles.keys()).filter((id) => !species[particles[id]].isStatic);
    this.count = this.moving.length;
    this.gravity = head.gravity ?? species[particles[this.moving[0]]]?.acceleration ?? [0, 0, 0];
    this.isHeavy = this.axes.some((k) => this.gravity[k] !== 0);
    this.hasStatic = this.count < particles.length;
    this.hasSurfaces = hasAny(head.surfaces);
    this.isSheared = Boolean(head.shearRate);
    this.hasOutlet = !head.isContained || (head.flows ?? []).length > 0;
    this.isOpen = false;
    this.masses = Float64Array.from(particles, (index) => species[index].mass ?? 1);
    this.totalMass = this.moving.reduce((sum, id) => sum + this.masses[id], 0);
    this.hasOneMass = this.moving.every((id) => this.masses[id] === this.masses[this.moving[0]]);
    this.volume = this.axes.reduce((product, k) => product * this.size[k], 1);
    this.isPeriodic = this.axes.every((k) => this.periodic[k]);
    const isAlone = !this.hasStatic && !this.hasSurfaces;
    this.conserved = (head.conserved ?? this.periodic.map((is, k) => is && isAlone && this.gravity[k] === 0)).map(
      (is, k) => is && !this.flat[k],
    );
    this.limit(this.isSheared, false);
    this.fall = this.axes.reduce(
      (most, k) => (Math.abs(this.gravity[k]) > Math.abs(this.gravity[most]) ? k : most),
      this.axes[0] ?? 0,
    );
  }

  /** Records that the box is sheared, or that particles leave it. */
  limit(isSheared, isOpen) {
    this.isSheared ||= isSheared;
    this.isOpen ||= isOpen;
    const isEven = !this.hasStatic && !this.hasSurfaces && !this.isHeavy && !this.isSheared;
    this.isHomogeneous = this.isPeriodic && isEven;
    // The density is uniform apart from layers at walls, so g(r) can be divided by a single density.
    this.isUniform = isEven && !this.isOpen && this.axes.every((k) => this.periodic[k] || this.isWalled(k));
    // Walls and gravity limit displacements, so diffusion is measured along other axes.
    this.freeAxes = this.isSheared ? [] : this.axes.filter((k) => this.periodic[k] && this.gravity[k] === 0);
  }

  hasEscaped(positions) {
    const closed = this.axes.filter((k) => !this.periodic[k]);
    return this.moving.some((id) =>
      closed.some((k) => {
        const at = (positions[3 * id + k] - this.lower[k]) / this.size[k];
        return at < -1e-9 || at > 1 + 1e-9;
      }),
    );
  }

  walls(axis) {
    if (this.periodic[axis] || this.flat[axis]) {
      return 0;
    }
    return (this.head.walls?.[axis] ?? [true, true]).filter(Boolean).length;
  }

  isWalled(axis) {
    return this.walls(axis) === 2;
  }

  get freedom() {
    return Math.max(1, this.dimensions * this.count - this.conserved.filter(Boolean).length);
  }

  /** Returns the meaningful observables, and those to show first. */
  offer() {
    const { count } = this;
    const few = count > 0 && count <= FEW;
    const is = {
      speeds: count >= MANY && !this.isSheared,
      radial: count >= MANY && this.isUniform,
      energy: count > 0,
      pressure: count >= 2 && this.isHomogeneous,
      displacement: count >= 5 && this.freeAxes.length > 0,
      autocorrelation: count >= MANY && this.freeAxes.length > 0,
      outflow: count > FEW && this.isHeavy && !this.periodic[this.fall] && this.hasOutlet,
      events: count > 0,
      positions: few,
      portrait: few,
    };
    const offered = Object.keys(is).filter((name) => is[name]);
    let wanted = ["speeds", "radial", "energy", "events"];
    if (few) {
      wanted = ["positions", "energy", "events"];
    } else if (this.isHeavy) {
      wanted = ["energy", "outflow", "events"];
    }
    return { offered, shown: wanted.filter((name) => is[name]).slice(0, 2) };
  }
}

/** Largest number of particles for plots of single particles. */
const FEW = 12;

const MANY = 20;

function hasAny(surfaces) {
  return Array.isArray(surfaces) ? surfaces.length > 0 : Boolean(surfaces);
}

// Converts the description of a scene for the renderer, and chooses the playback speed.

const liveElement = (id) => document.getElementById(`live-${id}`);

/** Radius of a bond relative to its smaller particle, as in the player of reports. */
const BOND_RADIUS = 0.36;

function liveParticles(head) {
  const { moving, fixed, fixedPositions, species, particles, bonds, flat, periodic, surfaces } = head;
  const ids = [...moving, ...fixed];
  const place = new Map(ids.map((id, index) => [id, index]));
  const radii = Float32Array.from(ids, (id) => species[particles[id]].diameter / 2);
  const bondEnds = Uint32Array.from(bonds.flat(), (id) => place.get(id) ?? 0);
  return {
    moving: moving.length,
    fixed: fixed.length,
    bonds: bonds.length,
    flat,
    periodic,
    radii,
    species: Uint8Array.from(ids, (id) => Math.min(particles[id], 255)),
    fixedPositions,
    bondEnds,
    bondRadii: Float32Array.from(bonds.keys(), (bond) => BOND_RADIUS * Math.min(radii[bondEnds[2 * bond]], radii[bondEnds[2 * bond + 1]])),
    surfaces: surfaces && { ...surfaces, bytes: decoded(head.surfaceData) },
  };
}

/** Speeds to choose from, in simulated time per second. */
const liveSpeeds = [...Array(10).keys()].flatMap((k) => [1, 2, 5].map((digit) => digit * 10 ** (k - 5)));

/** Returns a natural speed. Particles move by a few diameters per second, or fall through the box in a few seconds. */
function liveNaturalSpeed(head, { velocities }) {
  const { moving, species, particles, gravity, size } = head;
  let squares = 0;
  for (let k = 0; k < velocities.length; k += 1) {
    squares += velocities[k] * velocities[k];
  }
  const typical = Math.sqrt(squares / Math.max(moving.length, 1));
  const diameter = Array.from(moving, (id) => species[particles[id]].diameter).reduce((sum, own) => sum + own, 0) / Math.max(moving.length, 1);
  const extent = Math.max(...size.map((length, axis) => (gravity[axis] !== 0 ? length : 0)));
  const falling = Math.sqrt(norm(gravity) * extent);
  const wanted = falling > 2 * typical ? extent / (3 * falling) : (1.5 * diameter + 0.01 * Math.max(...size)) / typical;
  return liveNearestSpeed(wanted > 0 && wanted < Infinity ? wanted : 1);
}

function liveNearestSpeed(wanted) {
  const distance = (speed) => Math.abs(Math.log(speed / wanted));
  return liveSpeeds.reduce((best, speed) => (distance(speed) < distance(best) ? speed : best));
}

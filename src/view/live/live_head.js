// A head of the engine in the words of the renderer and of the camera.

const liveElement = (id) => document.getElementById(`live-${id}`);

/** Radius of a bond relative to the smaller of its two ends, as in the player of reports. */
const BOND_RADIUS = 0.36;

/** What the renderer has to know of the particles of a scene. */
function liveParticles(head) {
  const { moving, fixed, fixedPositions, species, particles, bonds = [] } = head;
  const ids = [...moving, ...fixed];
  const place = new Map(ids.map((id, index) => [id, index]));
  const radii = Float32Array.from(ids, (id) => species[particles[id]].diameter / 2);
  const bondEnds = Uint32Array.from(bonds.flat(), (id) => place.get(id) ?? 0);
  return {
    moving: moving.length,
    fixed: fixed.length,
    bonds: bonds.length,
    flat: liveFlat(head),
    periodic: head.periodic ?? [false, false, false],
    radii,
    species: Uint8Array.from(ids, (id) => Math.min(particles[id], 255)),
    fixedPositions,
    bondEnds,
    bondRadii: Float32Array.from(bonds.keys(), (bond) => BOND_RADIUS * Math.min(radii[bondEnds[2 * bond]], radii[bondEnds[2 * bond + 1]])),
    surfaces: head.surfaces && { ...head.surfaces, bytes: head.surfaces.bytes ?? head.surfaces.data },
  };
}

const liveFlat = (head) => head.flat ?? head.size.map((length) => length === 0);

/** What the camera has to know: the box, or the particles where it has no extent, and which way is up. */
function liveView(head, positions) {
  const flat = liveFlat(head);
  const gravity = head.gravity ?? [0, 0, 0];
  const down = gravity.map(Math.abs).indexOf(Math.max(...gravity.map(Math.abs)));
  const isFalling = gravity[down] !== 0;
  let view = [head.lower, add(head.lower, head.size)];
  if (head.size.every((length) => !(length > 0))) {
    view = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (const places of [positions, head.fixedPositions]) {
      for (let at = 0; at < places.length; at += 1) {
        view[0][at % 3] = Math.min(view[0][at % 3], places[at]);
        view[1][at % 3] = Math.max(view[1][at % 3], places[at]);
      }
    }
  }
  const upright = flat[2] ? (flat[1] ? 2 : 1) : 2;
  return { view, flat, up: isFalling ? down : upright, isUpsideDown: isFalling && gravity[down] > 0 };
}

/** The speeds that one can choose, simulated time per second: 1, 2 and 5 times powers of ten. */
const liveSpeeds = [...Array(10).keys()].flatMap((k) => [1, 2, 5].map((digit) => digit * 10 ** (k - 5)));

/** A speed that looks natural: a gas in which particles go some diameters in a second, or a fall through the box in some seconds. */
function liveNaturalSpeed(head, { velocities }) {
  const { moving, species, particles, gravity = [0, 0, 0], size } = head;
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

const liveNearestSpeed = (wanted) => liveSpeeds.reduce((best, speed) => (Math.abs(Math.log(speed / wanted)) < Math.abs(Math.log(best / wanted)) ? speed : best));

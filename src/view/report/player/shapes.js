const SIDES = 14;

/** Returns a triangle strip around a cylinder. A vertex is a normal and an end. */
function tube() {
  const strip = [];
  for (let side = 0; side <= SIDES; side += 1) {
    const angle = (2 * Math.PI * side) / SIDES;
    strip.push(Math.cos(angle), Math.sin(angle), 0, Math.cos(angle), Math.sin(angle), 1);
  }
  return new Float32Array(strip);
}

/** Returns the edges of a box that have a length, each once. */
function boxEdges({ lower, size }, flat) {
  const edges = [];
  const corner = (index) => [0, 1, 2].map((k) => lower[k] + ((index >> k) & 1 ? size[k] : 0));
  for (let axis = 0; axis < 3; axis += 1) {
    for (let index = 0; index < 8; index += 1) {
      const isOnce = [0, 1, 2].every((k) => !flat[k] || !((index >> k) & 1));
      if (!flat[axis] && !((index >> axis) & 1) && isOnce) {
        edges.push(...corner(index), ...corner(index | (1 << axis)));
      }
    }
  }
  return new Float32Array(edges);
}

/** Returns the halves of each bond along the shortest path. The path may cross a side of the box. */
function bondRods({ moving, bonds, bondEnds, bondRadii, fixedPositions, periodic }, { positions, box, displacement = 0 }) {
  const rods = new Float32Array(14 * bonds);
  for (let bond = 0; bond < bonds; bond += 1) {
    const place = (end) => {
      const index = bondEnds[2 * bond + end];
      return index < moving ? [positions, 3 * index] : [fixedPositions, 3 * (index - moving)];
    };
    const [[from, a], [to, b]] = [place(0), place(1)];
    // In a sheared box, the next image along y is displaced along x.
    const rise = to[b + 1] - from[a + 1];
    const slide = periodic[1] && Math.abs(rise) > box.size[1] / 2 ? Math.sign(rise) * displacement : 0;
    for (let k = 0; k < 3; k += 1) {
      let way = to[b + k] - from[a + k] - (k === 0 ? slide : 0);
      if (periodic[k] && Math.abs(way) > box.size[k] / 2) {
        way -= Math.sign(way) * box.size[k];
      }
      rods[14 * bond + k] = from[a + k];
      rods[14 * bond + 3 + k] = from[a + k] + way / 2;
      rods[14 * bond + 7 + k] = to[b + k] - way / 2;
      rods[14 * bond + 10 + k] = to[b + k];
    }
    rods[14 * bond + 6] = bondRadii[bond];
    rods[14 * bond + 13] = bondRadii[bond];
  }
  return rods;
}

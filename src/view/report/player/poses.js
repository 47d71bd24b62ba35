// Positions of moving surfaces between two frames.

/** Rotates a vector by a matrix, given by its columns. */
const turned = (columns, [x, y, z]) => [0, 1, 2].map((k) => columns[k] * x + columns[3 + k] * y + columns[6 + k] * z);

/** Returns the columns of the rotation by an angle about a unit vector. */
function rotation(axis, angle) {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  return [0, 1, 2].flatMap((k) => {
    const unit = unitVector(k, 1);
    return add(add(scaled(unit, cosine), scaled(cross(axis, unit), sine)), scaled(axis, (1 - cosine) * axis[k]));
  });
}

/** Returns the columns of the rotation from one pose to another. */
function rotationBetween(from, to) {
  const row = (pose, k) => [pose[k], pose[3 + k], pose[6 + k]];
  return [0, 1, 2].flatMap((column) => [0, 1, 2].map((k) => dot(row(to, k), row(from, column))));
}

/**
 * Returns the pose at fraction `s` of the screw motion from one pose to another. Uniform motion is reproduced exactly.
 */
function poseBetween(from, to, s) {
  const relative = rotationBetween(from, to);
  const shift = subtract(to.slice(9), turned(relative, from.slice(9)));
  const twist = [relative[5] - relative[7], relative[6] - relative[2], relative[1] - relative[3]];
  const angle = Math.atan2(norm(twist), relative[0] + relative[4] + relative[8] - 1);
  if (angle < 1e-6 || norm(twist) < 1e-6) {
    return [...from.slice(0, 9), ...add(from.slice(9), scaled(subtract(to.slice(9), from.slice(9)), s))];
  }
  const axis = scaled(twist, 1 / norm(twist));
  const along = scaled(axis, dot(axis, shift));
  const across = subtract(shift, along);
  // A point on the axis of the screw motion.
  const centre = scaled(add(across, scaled(cross(axis, across), 1 / Math.tan(angle / 2))), 0.5);
  const turn = rotation(axis, s * angle);
  const columns = [0, 3, 6].flatMap((k) => turned(turn, from.slice(k, k + 3)));
  const place = add(add(turned(turn, subtract(from.slice(9), centre)), centre), scaled(along, s));
  return [...columns, ...place];
}

/**
 * Returns the poses between two frames. The list is empty if all surfaces are at rest. If a surface is absent from one
 * frame, its state is taken from the earlier frame.
 */
function posesBetween(from, to, s) {
  if (from.length === 0 && to.length === 0) {
    return from;
  }
  const number = Math.max(from.length, to.length);
  const of = (poses, k) => (poses.length === 0 ? AT_REST : poses[k]);
  return [...Array(number).keys()].map((k) => {
    const [a, b] = [of(from, k), of(to, k)];
    return a && b ? poseBetween(a, b, s) : a;
  });
}

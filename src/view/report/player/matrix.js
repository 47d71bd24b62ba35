// Vectors of three numbers, and matrices of sixteen numbers in column order.

const add = (a, b) => a.map((x, k) => x + b[k]);
const subtract = (a, b) => a.map((x, k) => x - b[k]);
const scaled = (a, factor) => a.map((x) => x * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unitVector = (axis, sign) => [0, 1, 2].map((k) => (k === axis ? sign : 0));

/** Returns the view matrix of a camera at `eye` that looks along -back, with `right` and `above` in the picture. */
function viewMatrix(eye, right, above, back) {
  return [
    right[0], above[0], back[0], 0,
    right[1], above[1], back[1], 0,
    right[2], above[2], back[2], 0,
    -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ];
}

/** `slope` is the tangent of half the field of view. */
function perspective(slope, aspect, near, far) {
  return [
    1 / (slope * aspect), 0, 0, 0,
    0, 1 / slope, 0, 0,
    0, 0, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0,
  ];
}

/** Vectors of three numbers, and unit quaternions w, x, y, z that turn body axes into space axes. */

/** @typedef {[number, number, number]} Vector */
/** @typedef {[number, number, number, number]} Quaternion */

/** @type {(a: Vector, b: Vector) => Vector} */
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

/** @type {(a: Vector, b: Vector) => Vector} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** @type {(k: number, a: Vector) => Vector} */
export const times = (k, a) => [k * a[0], k * a[1], k * a[2]];

/** @type {(a: Vector, b: Vector) => number} */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @type {(a: Vector, b: Vector) => Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** @type {(a: Vector) => number} */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);

/** @type {(a: Vector) => Vector} */
export const unit = (a) => times(1 / (length(a) || 1), a);

/** @type {(a: Vector, b: Vector, s: number) => Vector} */
export const mix = (a, b, s) => plus(times(1 - s, a), times(s, b));

/**
 * The product of two rotations: first b, then a.
 * @type {(a: Quaternion, b: Quaternion) => Quaternion}
 */
export const after = (a, b) => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
];

/** @type {(q: Quaternion) => Quaternion} */
export const inverse = (q) => [q[0], -q[1], -q[2], -q[3]];

/**
 * The rotation by an angle about a unit vector.
 * @type {(axis: Vector, angle: number) => Quaternion}
 */
export function turn(axis, angle) {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
}

/**
 * The smallest rotation that takes one unit vector to another, not opposite, one.
 * @type {(a: Vector, b: Vector) => Quaternion}
 */
export function swing(a, b) {
  const [x, y, z] = cross(a, b);
  const w = 1 + dot(a, b);
  const size = Math.hypot(w, x, y, z) || 1;
  return [w / size, x / size, y / size, z / size];
}

/**
 * The three axes of the body in space: the columns of the rotation matrix.
 * @type {(q: Quaternion) => [Vector, Vector, Vector]}
 */
export function axes([w, x, y, z]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

/**
 * The quaternion of a body whose axes 1 and 3 are these.
 * @type {(first: Vector, third: Vector) => Quaternion}
 */
export function ofAxes(first, third) {
  const second = cross(third, first);
  const [a, d, g] = first;
  const [b, e, h] = second;
  const [c, f, i] = third;
  /** @type {Quaternion[]} */
  const rows = [
    [1 + a + e + i, h - f, c - g, d - b],
    [h - f, 1 + a - e - i, b + d, c + g],
    [c - g, b + d, 1 - a + e - i, f + h],
    [d - b, c + g, f + h, 1 - a - e + i],
  ];
  let best = 0;
  for (let k = 1; k < 4; k++) if (rows[k][k] > rows[best][best]) best = k;
  const size = Math.hypot(...rows[best]) || 1;
  const [w, x, y, z] = rows[best];
  return [w / size, x / size, y / size, z / size];
}

/** Vectors of three numbers, and unit quaternions w, x, y, z that turn body axes into space axes. */
import { outer } from "./rotation.js";

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

/** @type {Vector[]} */
export const UNITS = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

/** A vector along axes. @type {(axes: Vector[], v: Vector) => Vector} */
export const along = ([a, b, c], [x, y, z]) => plus(times(x, a), plus(times(y, b), times(z, c)));

/**
 * The quaternion of a body whose axes 1 and 3 are these.
 * @type {(first: Vector, third: Vector) => Quaternion}
 */
export function ofAxes(first, third) {
  const rows = outer(first, third);
  let best = 0;
  for (let k = 1; k < 4; k++) if (rows[k][k] > rows[best][best]) best = k;
  const size = Math.hypot(...rows[best]) || 1;
  const [w, x, y, z] = rows[best];
  return [w / size, x / size, y / size, z / size];
}

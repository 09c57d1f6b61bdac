/** A motion between its samples. */
import { axes, between } from "./rotation.js";
import { minus, mix, unit } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./vector.js").Quaternion} Quaternion */

/**
 * Where the numbers of a sample stand; the Python side writes them in this order.
 * @type {Record<string, [number, number]>}
 */
export const CHANNELS = {
  orientation: [0, 4],
  omega: [4, 3],
  position: [7, 3],
  force: [10, 3],
  slip: [13, 3],
  momentum: [16, 3],
  theta: [19, 1],
  well: [20, 3], // first and second argument of the potential, and the level
};
export const STRIDE = 23;

/**
 * @typedef {object} Pose
 * @property {number} time
 * @property {Quaternion} orientation
 * @property {Vector} omega angular velocity [rad/s]
 * @property {Vector} position of the centre of mass [m]
 * @property {Vector} force of the plane [N]
 * @property {Vector} slip velocity of the contact point [m/s]
 * @property {Vector} momentum L [kg m^2/s]
 * @property {number} theta [rad]
 * @property {Vector} well
 */

export class Motion {
  /**
   * @param {Float64Array} times ascending [s]
   * @param {Float32Array} samples STRIDE numbers each, see CHANNELS
   * @param {boolean} wound whether theta counts turns, about y, and is not bound to [0, pi]
   */
  constructor(times, samples, wound) {
    this.wound = wound;
    this.times = times;
    this.samples = samples;
  }

  get start() {
    return this.times[0];
  }

  get end() {
    return this.times[this.times.length - 1];
  }

  /**
   * The last sample that is not later.
   * @param {number} t
   */
  index(t) {
    let low = 0;
    let high = this.times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle;
      else high = middle;
    }
    return low;
  }

  /**
   * Some numbers of a sample.
   * @param {number} i
   * @param {string} name
   * @returns {any}
   */
  at(i, name) {
    const [first, count] = CHANNELS[name];
    const numbers = new Array(count);
    for (let k = 0; k < count; k++) numbers[k] = this.samples[i * STRIDE + first + k]; // ten times as fast as a slice
    return numbers;
  }

  /**
   * The largest length of a vector of the samples.
   * @param {string} name
   */
  longest(name) {
    const first = CHANNELS[name][0];
    let most = 0;
    for (let i = first; i < this.samples.length; i += STRIDE) {
      const [x, y, z] = [this.samples[i], this.samples[i + 1], this.samples[i + 2]];
      most = Math.max(most, x * x + y * y + z * z);
    }
    return Math.sqrt(most);
  }

  /**
   * The inclination of an attitude; where it counts turns, the one next to `about`.
   * @param {Quaternion} q
   * @param {number} about
   */
  theta(q, about) {
    const [x, y, z] = axes(q)[2];
    if (!this.wound) return Math.atan2(Math.hypot(x, y), z);
    const angle = Math.atan2(x, z);
    return angle + 2 * Math.PI * Math.round((about - angle) / (2 * Math.PI));
  }

  /**
   * What the body does at a time.
   * @param {number} t
   * @returns {Pose}
   */
  pose(t) {
    const time = Math.min(Math.max(t, this.start), this.end);
    const i = this.index(time);
    const j = Math.min(i + 1, this.times.length - 1);
    const h = this.times[j] - this.times[i];
    const s = h > 0 ? (time - this.times[i]) / h : 0;
    /** @type {(name: string) => Vector} */
    const linear = (name) => mix(this.at(i, name), this.at(j, name), s);
    const turned = between(
      this.at(i, "orientation"),
      this.at(i, "omega"),
      this.at(j, "orientation"),
      this.at(j, "omega"),
      h,
      s,
    );
    const orientation = h > 0 ? turned : this.at(i, "orientation");
    return {
      time,
      orientation,
      omega: linear("omega"),
      position: linear("position"),
      force: linear("force"),
      slip: linear("slip"),
      momentum: linear("momentum"),
      theta: this.theta(orientation, (1 - s) * this.at(i, "theta")[0] + s * this.at(j, "theta")[0]),
      well: linear("well"),
    };
  }
}

/**
 * The lowest point of a surface of the body, from its centre of mass, in axes of the surfaces.
 * @param {Vector[]} frame these axes in space
 * @param {import("./scene.js").Surface} surface
 * @param {import("./scene.js").Body["meridian"]} meridian of a surface of revolution, else empty
 * @returns {Vector}
 */
export function lowest(frame, { centre, half }, meridian) {
  let [x, y, z] = frame.map((axis) => axis[2]);
  if (!meridian.length) [x, y, z] = unit([half[0] * x, half[1] * y, half[2] * z]);
  else {
    const across = Math.hypot(x, y);
    const at = 1 + (Math.atan2(across, -z) / Math.PI) * (meridian.length - 3); // equal steps of the normal
    const i = Math.min(Math.floor(at), meridian.length - 3);
    const [height, radius] = mix(meridian[i], meridian[i + 1], at - i);
    [x, y, z] = [(radius * x) / (across || 1), (radius * y) / (across || 1), -height];
  }
  return minus(centre, [half[0] * x, half[1] * y, half[2] * z]);
}

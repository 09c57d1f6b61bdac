/** Where one looks from: an orbit around a point, which may follow the body; or from above. */
import { cross, length, minus, mix, plus, times, unit } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */

/** How far the camera is behind the body [s]: the same at every number of pictures a second. */
const LAG = 0.06;

export const LENS = Math.tan((17 * Math.PI) / 180);

export class Camera {
  constructor() {
    this.mode = "orbit";
    this.yaw = 0.9;
    this.pitch = 0.34;
    this.distance = 7;
    /** @type {Vector} */
    this.target = [0, 0, 0.9];
    /** @type {Vector} */
    this.home = [0, 0, 0.9];
  }

  /**
   * Follows the body; in orbit only where it would leave the picture.
   * @param {Vector} body where the body is
   * @param {number} passed since the picture before [s]; infinite to be there at once
   */
  follow(body, passed) {
    const away = minus(body, this.home);
    const room = this.mode === "orbit" ? Math.max(0, 0.8 * LENS * this.distance - 1) : 0;
    const goal = minus(body, times(Math.min(1, room / (length(away) || 1)), away));
    this.target = mix(this.target, goal, 1 - Math.exp(-passed / LAG));
  }

  /** Eye and the directions of the picture: right, up, ahead. */
  frame() {
    const above = this.mode === "above";
    const pitch = above ? 1.45 : this.pitch;
    /** @type {Vector} */
    const back = [Math.cos(pitch) * Math.cos(this.yaw), Math.cos(pitch) * Math.sin(this.yaw), Math.sin(pitch)];
    const eye = plus(this.target, times(this.distance, back));
    if (eye[2] < 0.05) eye[2] = 0.05;
    const ahead = unit(minus(this.target, eye));
    const right = unit(cross(ahead, [0, 0, 1]));
    return { eye, right, up: cross(right, ahead), ahead };
  }

  /**
   * Turns by dragging.
   * @param {number} dx
   * @param {number} dy
   */
  drag(dx, dy) {
    if (this.mode === "above") this.mode = "follow";
    this.yaw -= 0.007 * dx;
    this.pitch = Math.min(1.5, Math.max(-0.1, this.pitch + 0.006 * dy));
  }

  /**
   * Comes nearer or goes away.
   * @param {number} factor
   */
  zoom(factor) {
    this.distance = Math.min(40, Math.max(2.5, this.distance * factor));
  }
}

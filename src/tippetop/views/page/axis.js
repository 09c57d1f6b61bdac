/** The small sphere in the corner of the picture. */
import { axes } from "./rotation.js";

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */

const PI = Math.PI;

/** The axis of the body as a point of the unit sphere, and its path. */
export class AxisPanel {
  /**
   * @param {HTMLCanvasElement} canvas
   */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  }

  /**
   * @param {Motion} motion
   * @param {Pose} pose
   * @param {{right: number[], up: number[], ahead: number[]}} view
   * @param {Palette} colours
   * @param {number} memory how long a past is drawn [s]
   */
  draw(motion, pose, view, colours, memory) {
    const { canvas, context } = this;
    const ratio = window.devicePixelRatio || 1;
    const size = canvas.clientWidth;
    if (canvas.width !== Math.round(size * ratio)) canvas.width = canvas.height = Math.round(size * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, size, size);
    const c = size / 2;
    const r = c - 6;
    /** @type {(p: number[], a: number[]) => number} */
    const along = (p, a) => p[0] * a[0] + p[1] * a[1] + p[2] * a[2];
    const shine = context.createRadialGradient(c - 0.3 * r, c - 0.4 * r, 0.1 * r, c, c, r);
    shine.addColorStop(0, colours.paper);
    shine.addColorStop(1, colours.line);
    context.globalAlpha = 0.85;
    context.fillStyle = shine;
    context.beginPath();
    context.arc(c, c, r, 0, 2 * PI);
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = colours.quiet;
    context.lineWidth = 0.5;
    for (const height of [-0.5, 0, 0.5]) {
      const wide = Math.sqrt(1 - height * height);
      this.path(
        Array.from({ length: 73 }, (_, k) => [wide * Math.cos((k * PI) / 36), wide * Math.sin((k * PI) / 36), height]),
        view,
        0.25,
      );
    }
    const to = motion.index(pose.time);
    const from = motion.index(Math.max(motion.start, pose.time - memory));
    const step = Math.max(1, Math.ceil((to - from) / 3000));
    const points = [];
    for (let i = from; i < to; i += step) points.push(axes(motion.at(i, "orientation"))[2]);
    const third = axes(pose.orientation)[2];
    points.push(third);
    context.strokeStyle = colours.run;
    context.lineWidth = 1.1;
    this.path(points, view, 0.16);
    const near = along(third, view.ahead) < 0;
    context.globalAlpha = near ? 1 : 0.4;
    context.fillStyle = colours.alarm;
    context.beginPath();
    context.arc(c + r * along(third, view.right), c - r * along(third, view.up), 3.5, 0, 2 * PI);
    context.fill();
    context.globalAlpha = 1;
  }

  /**
   * A curve on the sphere: its far side is faint.
   * @param {number[][]} points
   * @param {{right: number[], up: number[], ahead: number[]}} view
   * @param {number} faint
   */
  path(points, { right, up, ahead }, faint) {
    const { context } = this;
    const c = this.canvas.clientWidth / 2;
    const r = c - 6;
    for (const near of [false, true]) {
      context.globalAlpha = near ? 1 : faint;
      context.beginPath();
      let drawing = false;
      for (const p of points) {
        const here = p[0] * ahead[0] + p[1] * ahead[1] + p[2] * ahead[2] < 0 === near;
        const x = c + r * (p[0] * right[0] + p[1] * right[1] + p[2] * right[2]);
        const y = c - r * (p[0] * up[0] + p[1] * up[1] + p[2] * up[2]);
        if (here && drawing) context.lineTo(x, y);
        else if (here) context.moveTo(x, y);
        drawing = here;
      }
      context.stroke();
    }
    context.globalAlpha = 1;
  }
}

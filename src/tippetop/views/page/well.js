/** The plot of the effective potential. */
import { Chart, ticks, tidy } from "./chart.js";
import { angle } from "./panels.js";

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {[number, number]} Span */

const PI = Math.PI;
const UNITS = /** @type {[number, string][]} */ ([
  [1, "J"],
  [1e3, "mJ"],
  [1e6, "µJ"],
  [1e9, "nJ"],
  [1e12, "pJ"],
]);

/**
 * In which unit the height of a well is read best: how many of it a joule is, and its name.
 * @type {(height: number) => [number, string]}
 */
export function unitOf(height) {
  return UNITS.find(([size]) => size * height >= 0.2) ?? UNITS[UNITS.length - 1];
}

/** The potential V(theta; momenta), its level, and the ball that rolls in it. */
export class WellPanel {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {(z: number, first: number, second: number) => number} potential
   */
  constructor(canvas, potential) {
    this.chart = new Chart(canvas, "");
    this.potential = potential;
    this.height = 0;
  }

  /**
   * The scale, from the whole motion: how far the level is above the bottom.
   * @param {Motion} motion
   * @param {(t: number) => boolean} touches whether there is a potential at a time
   */
  take(motion, touches) {
    const depths = [1e-12];
    for (let k = 0; k < 80; k++) {
      const i = Math.round((k * (motion.times.length - 1)) / 79);
      if (!touches(motion.times[i])) continue;
      const [first, second, level] = motion.at(i, "well");
      const bottom = Math.min(...this.values(first, second, 121).filter(isFinite));
      // a shallow motion keeps a scale on which its well has a width
      if (isFinite(level) && isFinite(bottom)) depths.push(level - bottom, 1e-2 * Math.abs(level));
    }
    this.height = 1.8 * Math.max(...depths);
  }

  /**
   * @param {number} first
   * @param {number} second
   * @param {number} count
   */
  values(first, second, count) {
    return Array.from({ length: count }, (_, k) => this.at((PI * (k + 0.5)) / count, first, second));
  }

  /**
   * @param {number} theta
   * @param {number} first
   * @param {number} second
   */
  at(theta, first, second) {
    return this.potential(Math.cos(theta), first, second);
  }

  /**
   * @param {Pose} pose
   * @param {Palette} colours
   * @param {boolean} wound whether theta goes on beyond 0 and π
   * @param {boolean} valid whether there is a potential now
   */
  draw(pose, colours, wound, valid) {
    const { chart } = this;
    const { context } = chart;
    const [first, second, level] = pose.well;
    const count = Math.max(60, Math.round(chart.right - chart.left) || 60);
    const values = this.values(first, second, count);
    const bottom = Math.min(...values.filter(isFinite));
    const low = bottom - 0.12 * this.height;
    const [unit, name] = unitOf(this.height);
    chart.title = `Potential V(θ) − min V, ${name}`;
    /** @type {Span} */
    const range = wound ? [-PI, PI] : [0, PI];
    const caption = valid ? `Ẽ = ${tidy(parseFloat((1e3 * level).toPrecision(4)))} mJ` : "";
    chart.begin(range, [low, low + 1.12 * this.height], colours, caption);
    const ys = ticks(0, unit * 1.0 * this.height, 3);
    const xs = wound ? [-180, -90, 0, 90, 180] : [0, 45, 90, 135, 180];
    chart.axes(
      colours,
      xs.map(angle),
      ys.map((y) => [bottom + y / unit, tidy(y)]),
    );
    if (!valid || !isFinite(bottom)) {
      context.fillStyle = colours.quiet;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText(
        "the sphere does not touch the plane",
        (chart.left + chart.right) / 2,
        (chart.top + chart.bottom) / 2,
      );
      return;
    }
    const steps = wound ? 2 * count : count;
    const at = (/** @type {number} */ k) => range[0] + ((range[1] - range[0]) * (k + 0.5)) / steps;
    const v = (/** @type {number} */ k) => this.at(at(k), first, second);
    chart.within(() => {
      context.fillStyle = colours.fill;
      context.beginPath();
      context.lineTo(chart.left, chart.y(level));
      for (let k = 0; k < steps; k++) {
        context.lineTo(chart.x(at(k)), chart.y(Math.min(v(k), level)));
      }
      context.lineTo(chart.right, chart.y(level));
      context.fill();
      context.strokeStyle = colours.run;
      context.lineWidth = 1.6 * chart.scale;
      context.beginPath();
      for (let k = 0; k < steps; k++) context.lineTo(chart.x(at(k)), Math.max(chart.y(v(k)), -1e4));
      context.stroke();
      context.strokeStyle = colours.upper;
      context.lineWidth = 1.2;
      context.setLineDash([5, 3]);
      chart.stroke(chart.left, chart.y(level), chart.right, chart.y(level));
      context.setLineDash([]);
      const theta = wound ? pose.theta - 2 * PI * Math.round(pose.theta / (2 * PI)) : pose.theta;
      const place = chart.y(this.at(theta, first, second));
      chart.dot(chart.x(theta), Math.max(place, chart.top), colours.alarm, colours.paper, 6);
    });
  }
}

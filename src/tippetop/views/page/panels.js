/** The plots beside the picture: theta(t), the well, the normal force, the axis on its sphere, phases and events. */
import { Chart, ticks, tidy } from "./chart.js";
import { STRIDE } from "./motion.js";
import { axes } from "./vector.js";

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {[number, number]} Span */
/** @typedef {import("./log.js").Log} Log */

const PI = Math.PI;
/** @type {[number, string][]} */
const ANGLES = [
  [0, "0"],
  [PI / 4, "π/4"],
  [PI / 2, "π/2"],
  [(3 * PI) / 4, "3π/4"],
  [PI, "π"],
];

/**
 * Marks now.
 * @type {(chart: Chart, t: number, colours: Palette) => void}
 */
function mark(chart, t, colours) {
  chart.context.strokeStyle = colours.alarm;
  chart.context.lineWidth = 1;
  chart.stroke(chart.x(t), chart.top, chart.x(t), chart.bottom);
}

/**
 * Shades the phases of the contact behind a plot over time.
 * @type {(chart: Chart, log: Log, colours: Palette, top?: number, bottom?: number) => void}
 */
export function shade(chart, log, colours, top = chart.top, bottom = chart.bottom) {
  for (const { start, end, phase, ball } of log.phases) {
    if (end < chart.low[0] || start > chart.high[0]) continue;
    const known = /** @type {Record<string, string>} */ (colours.phases);
    chart.context.fillStyle = phase === "slip" && ball === "stem" ? colours.balls.stem : known[phase];
    const x = chart.x(Math.max(start, chart.low[0]));
    chart.context.fillRect(x, top, Math.max(chart.x(Math.min(end, chart.high[0])) - x, 0.75), bottom - top);
  }
}

export class ThetaPanel {
  /**
   * @param {HTMLCanvasElement} canvas
   */
  constructor(canvas) {
    this.chart = new Chart(canvas, "Inclination θ(t)");
  }

  /**
   * @param {Motion} motion
   * @param {Log} log
   * @param {Pose} pose
   * @param {Span} span
   * @param {Palette} colours
   */
  draw(motion, log, pose, span, colours) {
    const { chart } = this;
    const wound = log.wound;
    const [least, most] = this.range(motion, log, span);
    const low = wound ? least : Math.max(0, least - 0.04);
    const high = wound ? most : Math.min(PI, most + 0.04);
    const room = 0.06 * (high - low) + 1e-9;
    const degrees = ((pose.theta * 180) / PI).toFixed(1).replace("-", "−");
    chart.begin(span, [low - room, high + room], colours, `θ = ${degrees}°`);
    if (log.changes) chart.within(() => shade(chart, log, colours));
    const whole = high - low > 1.3 && !wound;
    const few = chart.bottom - chart.top < 70 ? 2 : 1;
    const ys = whole
      ? ANGLES.filter((_, k) => k % few === 0)
      : ticks(low, high, 4).map((y) => /** @type {[number, string]} */ ([y, tidy(y)]));
    chart.axes(colours, chart.times(), ys);
    const { context } = chart;
    chart.within(() => {
      this.band(log, colours);
      context.strokeStyle = colours.run;
      context.lineWidth = 1;
      const from = motion.index(span[0]);
      const to = Math.min(motion.index(span[1]) + 2, motion.times.length);
      chart.curve(motion.times, (i) => motion.samples[i * STRIDE + 19], from, to);
      this.turnings(log, colours, span);
      mark(chart, pose.time, colours);
      chart.dot(chart.x(pose.time), chart.y(pose.theta), colours.alarm, colours.paper);
    });
  }

  /**
   * The least and the largest inclination of what is shown.
   * @param {Motion} motion
   * @param {Log} log
   * @param {Span} span
   */
  range(motion, log, span) {
    if (span[0] <= motion.start && span[1] >= motion.end) return log.thetas;
    let [low, high] = [Infinity, -Infinity];
    const to = Math.min(motion.index(span[1]) + 2, motion.times.length);
    for (let i = motion.index(span[0]); i < to; i++) {
      const theta = motion.samples[i * STRIDE + 19];
      [low, high] = [Math.min(low, theta), Math.max(high, theta)];
    }
    return [low, high];
  }

  /**
   * The nutational band between the envelopes of maxima and minima.
   * @param {Log} log
   * @param {Palette} colours
   */
  band(log, colours) {
    const { chart } = this;
    chart.context.fillStyle = colours.fill;
    for (const { low, high } of log.bands) {
      chart.context.beginPath();
      for (const [t, angle] of high) chart.context.lineTo(chart.x(t), chart.y(angle));
      for (let i = low.length - 1; i >= 0; i--) chart.context.lineTo(chart.x(low[i][0]), chart.y(low[i][1]));
      chart.context.fill();
    }
  }

  /**
   * The logged turning angles.
   * @param {Log} log
   * @param {Palette} colours
   * @param {Span} span
   */
  turnings(log, colours, span) {
    const { chart } = this;
    const shown = log.turnings.filter(({ time }) => time >= span[0] && time <= span[1]);
    const radius = shown.length > 400 ? 1 : shown.length > 120 ? 1.5 : 2.3;
    for (const { time, theta, least } of shown) {
      chart.context.fillStyle = least ? colours.lower : colours.upper;
      chart.context.beginPath();
      chart.context.arc(chart.x(time), chart.y(theta), radius, 0, 2 * PI);
      chart.context.fill();
    }
  }
}

export class ForcePanel {
  /**
   * @param {HTMLCanvasElement} canvas
   */
  constructor(canvas) {
    this.chart = new Chart(canvas, "Normal force / weight");
  }

  /**
   * @param {Motion} motion
   * @param {Log} log
   * @param {Pose} pose
   * @param {Span} span
   * @param {Palette} colours
   * @param {number} weight [N]
   */
  draw(motion, log, pose, span, colours, weight) {
    const { chart } = this;
    const force = (/** @type {number} */ i) => motion.samples[i * STRIDE + 12] / weight;
    const [least, most] = log.forces;
    const low = Math.min(0, least / weight);
    const high = Math.max(1.2, most / weight);
    const now = pose.force[2] / weight;
    chart.begin(span, [low - 0.06 * (high - low), high + 0.06 * (high - low)], colours, `g = ${now.toFixed(3)} mg`);
    if (log.changes) chart.within(() => shade(chart, log, colours));
    chart.axes(
      colours,
      chart.times(),
      ticks(low, high, 4).map((y) => [y, tidy(y)]),
    );
    chart.within(() => {
      const { context } = chart;
      context.strokeStyle = colours.quiet;
      context.lineWidth = 1;
      context.setLineDash([4, 4]);
      chart.stroke(chart.left, chart.y(1), chart.right, chart.y(1));
      context.setLineDash([]);
      context.strokeStyle = colours.alarm;
      if (low > -0.5 && log.nearLiftoff) chart.stroke(chart.left, chart.y(0), chart.right, chart.y(0));
      context.strokeStyle = colours.run;
      const from = motion.index(span[0]);
      chart.curve(motion.times, force, from, Math.min(motion.index(span[1]) + 2, motion.times.length));
      mark(chart, pose.time, colours);
      chart.dot(chart.x(pose.time), chart.y(now), colours.alarm, colours.paper);
    });
  }
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
   */
  take(motion) {
    const depths = [];
    for (let k = 0; k < 80; k++) {
      const i = Math.round((k * (motion.times.length - 1)) / 79);
      const [first, second, level] = motion.at(i, "well");
      const bottom = Math.min(...this.values(first, second, 121).filter(isFinite));
      if (isFinite(level) && isFinite(bottom)) depths.push(level - bottom);
    }
    this.height = 1.8 * Math.max(1e-12, ...depths);
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
    chart.title = `Potential V(θ) − min V, ${this.height < 2e-4 ? "µJ" : "mJ"}`;
    /** @type {Span} */
    const range = wound ? [-PI, PI] : [0, PI];
    const caption = valid ? `Ẽ = ${tidy(parseFloat((1e3 * level).toPrecision(4)))} mJ` : "";
    chart.begin(range, [low, low + 1.12 * this.height], colours, caption);
    const unit = this.height < 2e-4 ? 1e6 : 1e3;
    const ys = ticks(0, unit * 1.0 * this.height, 3);
    /** @type {[number, string][]} */
    const xs = wound
      ? [
          [-PI, "−π"],
          [-PI / 2, "−π/2"],
          [0, "0"],
          [PI / 2, "π/2"],
          [PI, "π = θ"],
        ]
      : ANGLES;
    chart.axes(
      colours,
      xs.map(([x, text]) => [x, text === "π" ? "π = θ" : text]),
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
      for (let k = 0; k < steps; k++) {
        const value = v(k);
        if (value < level) {
          context.lineTo(chart.x(at(k)), chart.y(value));
        } else {
          context.lineTo(chart.x(at(k)), chart.y(level));
        }
      }
      context.closePath();
      context.fill();
      context.strokeStyle = colours.run;
      context.lineWidth = 1.6;
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
      chart.dot(chart.x(theta), Math.max(place - 6, chart.top), colours.alarm, colours.paper, 6);
    });
  }
}

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

/** Phases and events on one line. */
export class TimeLine {
  /**
   * @param {HTMLCanvasElement} canvas
   */
  constructor(canvas) {
    this.chart = new Chart(canvas, "");
  }

  /**
   * @param {Log} log
   * @param {number} t
   * @param {Span} span the whole motion
   * @param {Span} window what the plots show
   * @param {Palette} colours
   */
  draw(log, t, span, window, colours) {
    const { chart } = this;
    chart.begin(span, [0, 1], colours);
    chart.top = 4;
    [chart.left, chart.right] = [8, chart.canvas.clientWidth - 8];
    const { context } = chart;
    context.fillStyle = colours.line;
    context.fillRect(chart.left, 12, chart.right - chart.left, 8);
    shade(chart, log, colours, 10, 22);
    context.fillStyle = colours.quiet;
    context.globalAlpha = 0.25;
    if (window[1] - window[0] < span[1] - span[0]) {
      context.fillRect(chart.x(window[0]), 4, Math.max(2, chart.x(window[1]) - chart.x(window[0])), chart.bottom - 4);
    }
    context.globalAlpha = 1;
    const dense = log.turnings.length > (chart.right - chart.left) / 2;
    if (!dense) {
      context.fillStyle = colours.quiet;
      for (const { time } of log.turnings) context.fillRect(chart.x(time), 24, 1, 4);
    }
    const drawn = /** @type {Record<string, number>} */ ({});
    for (const { time, kind } of log.marks) {
      if (kind === "turning") continue;
      const x = Math.round(chart.x(time));
      if (drawn[kind] === x) continue;
      drawn[kind] = x;
      const small = kind === "impact";
      context.fillStyle = kind === "liftoff" || small ? colours.alarm : colours.upper;
      context.beginPath();
      context.moveTo(x, small ? 24 : 22);
      context.lineTo(x - (small ? 2 : 4), small ? 29 : 30);
      context.lineTo(x + (small ? 2 : 4), small ? 29 : 30);
      context.fill();
    }
    chart.bottom = chart.canvas.clientHeight - 16;
    context.fillStyle = colours.quiet;
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const [value, text] of chart.times()) {
      const wide = context.measureText(text).width / 2;
      const x = Math.min(Math.max(chart.x(value), chart.left + wide), chart.right - wide);
      context.fillText(text, x, chart.bottom + 3);
    }
    mark(chart, t, colours);
    chart.dot(chart.x(t), 16, colours.alarm, colours.paper, 6);
  }
}

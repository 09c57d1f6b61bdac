/** The plots over time beside the picture: theta(t) and the normal force. */
import { Chart, ticks, tidy } from "./chart.js";
import { STRIDE } from "./motion.js";
import { cover } from "./palette.js";

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {[number, number]} Span */
/** @typedef {import("./log.js").Log} Log */

const PI = Math.PI;
const DEGREE = PI / 180;
/**
 * An angle on an axis.
 * @type {(degrees: number) => [number, string]}
 */
export const angle = (degrees) => [degrees * DEGREE, `${tidy(degrees)}°`];

/**
 * Marks now.
 * @type {(chart: Chart, t: number, colours: Palette) => void}
 */
export function mark(chart, t, colours) {
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
    chart.context.fillStyle = cover(phase, ball, colours);
    const x = chart.x(Math.max(start, chart.low[0]));
    chart.context.fillRect(x, top, Math.max(chart.x(Math.min(end, chart.high[0])) - x, 0.75), bottom - top);
  }
}

/**
 * Whether all of a motion is shown.
 * @type {(motion: Motion, span: Span) => boolean}
 */
const entire = (motion, span) => span[0] <= motion.start && span[1] >= motion.end;

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
    const degrees = (pose.theta / DEGREE).toFixed(1).replace("-", "−");
    chart.begin(span, [low - room, high + room], colours, `θ = ${degrees}°`);
    const whole = high - low > 1.3 && !wound;
    const few = chart.bottom - chart.top < 70 * chart.scale ? 2 : 1;
    const ys = (
      whole ? [0, 45, 90, 135, 180].filter((_, k) => k % few === 0) : ticks(low / DEGREE, high / DEGREE, 4)
    ).map(angle);
    chart.still(entire(motion, span) ? [log, colours, log.changes] : undefined, () => {
      if (log.changes) chart.within(() => shade(chart, log, colours));
      chart.axes(colours, chart.times(), ys);
      chart.within(() => {
        this.band(log, colours);
        chart.context.strokeStyle = colours.run;
        chart.context.lineWidth = chart.scale;
        const from = motion.index(span[0]);
        const to = Math.min(motion.index(span[1]) + 2, motion.times.length);
        chart.curve(motion.times, (i) => motion.samples[i * STRIDE + 19], from, to);
        this.turnings(log, colours, span);
      });
    });
    chart.within(() => {
      mark(chart, pose.time, colours);
      chart.dot(chart.x(pose.time), chart.y(pose.theta), colours.alarm, colours.paper);
    });
  }

  /**
   * The least and the largest inclination in the window.
   * @param {Motion} motion
   * @param {Log} log
   * @param {Span} span
   */
  range(motion, log, span) {
    if (entire(motion, span)) return log.thetas;
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
    this.chart = new Chart(canvas, "Normal force gₙ / weight");
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
    chart.begin(
      span,
      [low - 0.06 * (high - low), high + 0.06 * (high - low)],
      colours,
      now.toFixed(3).replace("-", "−"),
    );
    chart.still(entire(motion, span) ? [log, colours, log.changes] : undefined, () => {
      if (log.changes) chart.within(() => shade(chart, log, colours));
      chart.axes(
        colours,
        chart.times(),
        ticks(low, high, 4).map((y) => [y, tidy(y)]),
      );
      chart.within(() => this.curve(motion, span, colours, force, log.nearLiftoff && low > -0.5));
    });
    chart.within(() => {
      mark(chart, pose.time, colours);
      chart.dot(chart.x(pose.time), chart.y(now), colours.alarm, colours.paper);
    });
  }

  /**
   * The force over time, with the weight, and with zero where the top comes near it.
   * @param {Motion} motion
   * @param {Span} span
   * @param {Palette} colours
   * @param {(i: number) => number} force of a sample, in weights
   * @param {boolean} near
   */
  curve(motion, span, colours, force, near) {
    const { chart } = this;
    const { context } = chart;
    context.strokeStyle = colours.quiet;
    context.lineWidth = 1;
    context.setLineDash([4, 4]);
    chart.stroke(chart.left, chart.y(1), chart.right, chart.y(1));
    context.setLineDash([]);
    context.strokeStyle = colours.alarm;
    if (near) chart.stroke(chart.left, chart.y(0), chart.right, chart.y(0));
    context.strokeStyle = colours.run;
    context.lineWidth = chart.scale;
    const from = motion.index(span[0]);
    chart.curve(motion.times, force, from, Math.min(motion.index(span[1]) + 2, motion.times.length));
  }
}

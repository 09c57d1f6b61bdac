/** The line of times below the picture. */
import { Chart } from "./chart.js";
import { mark, shade } from "./panels.js";

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {[number, number]} Span */
/** @typedef {import("./log.js").Log} Log */

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
    chart.bottom = chart.canvas.clientHeight - 16 * chart.scale;
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

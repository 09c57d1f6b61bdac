/** The map of a sweep: a cell, or a dot, for each top over two of its axes. */
import { Chart, ticks, tidy } from "./chart.js";

/** @typedef {import("./palette.js").Palette} Palette */

/**
 * @typedef {object} Axis
 * @property {string} key
 * @property {string} label
 * @property {boolean} log
 * @property {boolean} sampled whether its numbers were drawn at random
 * @property {ArrayLike<number>} numbers one for each top
 */

/** After the figures of the package. */
export const CLASSES = /** @type {Record<string, string>} */ ({
  none: "#4b5563",
  upright: "#0f766e",
  "near-upright": "#9ad1c8",
  tumbling: "#e0a800",
  inverted: "#c2410c",
  "lifted-off": "#6d28d9",
  "under-way": "#b8c4d0",
  rolling: "#5b8c5a",
  "on-stem": "#b06ab3",
  bouncing: "#0ea5e9",
  nutating: "#d9c7a3",
  "at-rest": "#111111",
});

/**
 * A class in words.
 * @type {(name: string) => string}
 */
export function said(name) {
  return name === "near-upright" ? "still near upright" : name.replaceAll("-", " ");
}

const VIRIDIS = ["#440154", "#414487", "#2a788e", "#22a884", "#7ad151", "#fde725"];

/**
 * A colour of the scale, for 0 to 1.
 * @type {(s: number) => string}
 */
function scale(s) {
  const at = Math.min(0.9999, Math.max(0, s)) * (VIRIDIS.length - 1);
  const [a, b] = [VIRIDIS[Math.floor(at)], VIRIDIS[Math.floor(at) + 1]];
  const part = at - Math.floor(at);
  const mixed = [1, 3, 5].map((i) => {
    const [x, y] = [parseInt(a.slice(i, i + 2), 16), parseInt(b.slice(i, i + 2), 16)];
    return Math.round(x + (y - x) * part);
  });
  return `rgb(${mixed.join(",")})`;
}

/** @type {(axis: Axis, value: number) => number} */
const placed = (axis, value) => (axis.log ? Math.log10(value) : value);

export class SweepMap {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Axis[]} axes
   */
  constructor(canvas, axes) {
    this.chart = new Chart(canvas, "");
    this.axes = axes;
    /** @type {number[]} tops that are shown */
    this.tops = [];
    this.chosen = -1;
    this.pointed = -1;
    this.values = axes.map((axis) => [...new Set(Array.from(axis.numbers))].filter(isFinite).sort((a, b) => a - b));
    this.edges = axes.map((axis, i) => this.around(axis, this.values[i]));
  }

  /**
   * Edges between the numbers of an axis, as they are placed.
   * @param {Axis} axis
   * @param {number[]} values
   */
  around(axis, values) {
    const at = values.map((v) => placed(axis, v));
    if (at.length === 1) return [at[0] - 0.5, at[0] + 0.5];
    const middles = at.slice(1).map((v, i) => (v + at[i]) / 2);
    return [2 * at[0] - middles[0], ...middles, 2 * at[at.length - 1] - middles[middles.length - 1]];
  }

  /**
   * Takes the numbers of further axes: only tops that have them are shown.
   * @param {(number | undefined)[]} further undefined: all
   */
  slice(further) {
    const rest = this.axes.slice(2);
    const n = this.axes[0].numbers.length;
    this.tops = [];
    for (let i = 0; i < n; i++) {
      if (rest.every((axis, k) => further[k] === undefined || axis.numbers[i] === further[k])) this.tops.push(i);
    }
  }

  /** @param {number} top */
  place(top) {
    const [x, y] = this.axes;
    return [placed(x, x.numbers[top]), y ? placed(y, y.numbers[top]) : 0];
  }

  /**
   * Where numbers on the first two axes are on the canvas; an infinite one at its edge.
   * @param {number} x
   * @param {number} y
   */
  spot(x, y) {
    const { chart, axes } = this;
    const height = isFinite(y) ? chart.y(placed(axes[1], y)) : y < 0 ? chart.bottom : chart.top;
    return [chart.x(placed(axes[0], x)), height];
  }

  /**
   * @param {Palette} colours
   * @param {{values: ArrayLike<number>, names?: string[], words: string}} column
   * @param {() => void} over draws what lies over the cells
   */
  draw(colours, column, over) {
    const { chart } = this;
    const [x, y] = this.axes;
    const [xs, ys] = [this.edges[0], this.edges[1] ?? [-0.5, 0.5]];
    const span = (/** @type {number[]} */ e) => /** @type {[number, number]} */ ([e[0], e[e.length - 1]]);
    chart.begin(span(xs), span(ys), colours);
    const finite = this.tops.map((i) => column.values[i]).filter(isFinite);
    const [low, high] = [Math.min(...finite), Math.max(...finite)];
    const colour = (/** @type {number} */ v) =>
      column.names
        ? (CLASSES[column.names[v]] ?? colours.line)
        : isFinite(v)
          ? scale((v - low) / (high - low || 1))
          : colours.line;
    const { context } = chart;
    const dots = x.sampled || y?.sampled;
    for (const top of this.tops) {
      context.fillStyle = colour(column.values[top]);
      const [left, right, above, below] = this.box(top, dots ? 3 : 0);
      context.fillRect(left, above, right - left + 0.5, below - above + 0.5);
    }
    over();
    for (const [top, ring] of /** @type {[number, string][]} */ ([
      [this.pointed, "#ffffff"],
      [this.chosen, "#000000"],
    ])) {
      if (!this.tops.includes(top)) continue;
      const [left, right, above, below] = this.box(top, dots ? 4 : 0);
      context.lineWidth = 3;
      context.strokeStyle = ring === "#ffffff" ? "#000000" : "#ffffff";
      context.strokeRect(left - 1, above - 1, right - left + 2, below - above + 2);
      context.lineWidth = 1.6;
      context.strokeStyle = ring;
      context.strokeRect(left - 1, above - 1, right - left + 2, below - above + 2);
    }
    chart.axes(colours, this.numbers(x, span(xs), 5), y ? this.numbers(y, span(ys), 6) : [], false);
    return [low, high];
  }

  /**
   * The rectangle of a top on the canvas: its cell, or so many pixels around its dot.
   * @param {number} top
   * @param {number} dot
   */
  box(top, dot) {
    const { chart } = this;
    const [x, y] = this.place(top);
    if (dot) return [chart.x(x) - dot, chart.x(x) + dot, chart.y(y) - dot, chart.y(y) + dot];
    const cell = (/** @type {number[]} */ edges, /** @type {number} */ v) => {
      const k = Math.max(
        1,
        edges.findIndex((e) => e > v),
      );
      return [edges[k - 1], edges[k]];
    };
    const [a, b] = cell(this.edges[0], x);
    const [c, d] = cell(this.edges[1] ?? [-0.5, 0.5], y);
    return [chart.x(a), chart.x(b), chart.y(d), chart.y(c)];
  }

  /**
   * Numbers along an axis.
   * @param {Axis} axis
   * @param {[number, number]} span
   * @param {number} count
   * @returns {[number, string][]}
   */
  numbers(axis, span, count) {
    if (!axis.log) return ticks(span[0], span[1], count).map((v) => [v, tidy(v)]);
    /** @type {[number, string][]} */
    const found = [];
    for (let p = Math.floor(span[0]); p <= span[1]; p++) {
      for (const k of [1, 2, 5]) found.push([p + Math.log10(k), tidy(k * 10 ** p)]);
    }
    return found.filter(([v]) => v >= span[0] && v <= span[1]);
  }

  /**
   * The top at a place of the canvas; -1 if there is none.
   * @param {number} px
   * @param {number} py
   */
  at(px, py) {
    const { chart } = this;
    let best = -1;
    let least = Infinity;
    for (const top of this.tops) {
      const [x, y] = this.place(top);
      const away = (chart.x(x) - px) ** 2 + (chart.y(y) - py) ** 2;
      if (away < least) [best, least] = [top, away];
    }
    return best;
  }

  /**
   * The next top in a direction of the page.
   * @param {number} dx
   * @param {number} dy
   */
  beside(dx, dy) {
    const { chart } = this;
    const [x, y] = this.place(this.chosen);
    let best = this.chosen;
    let least = Infinity;
    for (const top of this.tops) {
      const [a, b] = this.place(top);
      const [along, across] = [(chart.x(a) - chart.x(x)) * dx + (chart.y(b) - chart.y(y)) * dy, 0];
      const off = Math.abs((chart.x(a) - chart.x(x)) * dy) + Math.abs((chart.y(b) - chart.y(y)) * dx) + across;
      if (along > 0.5 && along + 4 * off < least) [best, least] = [top, along + 4 * off];
    }
    return best;
  }
}

/** Thresholds as lines over the map of a sweep, white below black so that they show on every colour. */
import { numbers } from "./run.js";

/** @typedef {import("./map.js").SweepMap} SweepMap */
/** @typedef {{label: string, dash: number[], line: Float32Array}} Border `line`: x, y, x, y ...; NaN between two */

const DASHES = [[], [6, 3], [1.5, 2.5], [7, 2.5, 1.5, 2.5]];
const SVG = "http://www.w3.org/2000/svg";

export class Borders {
  /** @param {{labels: string[], lines: string[][]}} data what Python wrote: for each choice of further axes, each line */
  constructor({ labels, lines }) {
    this.labels = labels;
    this.lines = lines;
    /** @type {Border[]} */
    this.shown = [];
    this.choice = -1;
  }

  /**
   * Takes the lines of a choice of the further axes, and writes what they mean.
   * @param {number} choice
   * @param {HTMLElement} legend
   */
  take(choice, legend) {
    if (choice === this.choice) return;
    this.choice = choice;
    this.shown = this.labels.flatMap((label, k) => {
      const text = this.lines[choice]?.[k];
      return text ? [{ label, dash: DASHES[k % DASHES.length], line: numbers(text, "f4") }] : [];
    });
    legend.replaceChildren(...this.shown.map(entry));
  }

  /** @param {SweepMap} map */
  draw(map) {
    const { context } = map.chart;
    map.chart.within(() => {
      for (const { line, dash } of this.shown) {
        this.stroke(map, line, "rgba(255, 255, 255, 0.75)", 3.4);
        context.setLineDash(dash);
        this.stroke(map, line, "#000000", 1.4);
        context.setLineDash([]);
      }
    });
  }

  /**
   * @param {SweepMap} map
   * @param {Float32Array} line
   * @param {string} colour
   * @param {number} width
   */
  stroke(map, line, colour, width) {
    const { context } = map.chart;
    Object.assign(context, { strokeStyle: colour, lineWidth: width });
    context.beginPath();
    for (let i = 0; i < line.length; i += 2) {
      if (Number.isNaN(line[i])) continue;
      const [x, y] = map.spot(line[i], line[i + 1]);
      if (i && !Number.isNaN(line[i - 1])) context.lineTo(x, y);
      else context.moveTo(x, y);
    }
    context.stroke();
  }
}

/**
 * An entry of the legend.
 * @param {Border} border
 */
function entry({ label, dash }) {
  const item = Object.assign(document.createElement("span"), { className: "border" });
  label.split(/_(\w+)/).forEach((text, k) => {
    item.append(Object.assign(document.createElement(k % 2 ? "sub" : "span"), { textContent: text }));
  });
  const swatch = document.createElementNS(SVG, "svg");
  const line = document.createElementNS(SVG, "line");
  const how = { x1: "0", x2: "28", y1: "5", y2: "5", "stroke-dasharray": dash.join(" ") };
  for (const [name, value] of Object.entries(how)) line.setAttribute(name, value);
  swatch.setAttribute("aria-hidden", "true");
  swatch.append(line);
  item.prepend(swatch);
  return item;
}

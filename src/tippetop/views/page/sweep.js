/** The page of a sweep: its map, the line of a top, and the motion of the top that is chosen, integrated in the page. */
import { Borders } from "./borders.js";
import { CLASSES, SweepMap, said } from "./map.js";
import { palette } from "./palette.js";
import { numbers } from "./run.js";
import { refusal, sampling, simulated } from "./simulation.js";
import { part } from "./part.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {{name: string, words: string, unit: string, names?: string[], values: Float32Array}} Column */

export class SweepPage {
  /**
   * @param {any} data what Python wrote
   * @param {Stage} stage
   */
  constructor(data, stage) {
    this.stage = stage;
    this.given = data.given;
    this.body = data.body;
    this.axes = data.axes.map((/** @type {any} */ axis) => ({ ...axis, numbers: numbers(axis.numbers, "f8") }));
    /** @type {Column[]} */
    this.columns = data.columns.map((/** @type {any} */ c) => ({ ...c, values: numbers(c.values, "f4") }));
    /** @type {Record<string, Float64Array>} */
    this.changes = {};
    for (const [key, text] of Object.entries(data.changes)) this.changes[key] = numbers(String(text), "f8");
    this.map = new SweepMap(part("map"), this.axes);
    this.borders = new Borders(data.borders);
    this.column = this.columns[0];
    for (const { name, words } of this.columns) part("column").add(new Option(words, name));
    part("column").addEventListener("change", () => {
      this.column = this.columns.find((c) => c.name === part("column").value) ?? this.columns[0];
      this.draw();
    });
    part("x-label").textContent = this.axes[0].label;
    part("y-label").textContent = this.axes[1]?.label ?? "";
    /** @type {(number | undefined)[]} */
    this.further = [];
    this.sliders();
    this.pointer();
    this.map.slice(this.further);
    new ResizeObserver(() => this.draw()).observe(part("map"));
    part("theme").addEventListener("click", () => this.draw());
    for (const moment of ["beforeprint", "afterprint"]) addEventListener(moment, () => this.draw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.choose(this.map.tops[this.map.tops.length >> 1], false);
  }

  /** A slider for each further axis of the grid. */
  sliders() {
    this.axes.slice(2).forEach((/** @type {any} */ axis, /** @type {number} */ k) => {
      if (axis.sampled) return;
      const values = this.map.values[k + 2];
      const middle = values.length >> 1;
      this.further[k] = values[middle];
      const row = document.createElement("label");
      row.className = "slider";
      const words = Object.assign(document.createElement("span"), { textContent: axis.label });
      const output = Object.assign(document.createElement("output"), { value: String(values[middle]) });
      const input = Object.assign(document.createElement("input"), {
        type: "range",
        min: "0",
        max: String(values.length - 1),
        value: String(middle),
      });
      input.dataset.part = `further-${axis.key}`;
      input.setAttribute("aria-label", axis.label);
      row.append(words, output, input);
      part("further").append(row);
      input.addEventListener("input", () => {
        const [x, y] = this.map.chosen >= 0 ? this.map.place(this.map.chosen) : [0, 0];
        this.further[k] = values[Number(input.value)];
        output.value = String(Number(values[Number(input.value)].toPrecision(6)));
        this.map.slice(this.further);
        this.draw();
        this.choose(this.map.at(this.map.chart.x(x), this.map.chart.y(y)), true);
      });
    });
  }

  pointer() {
    const canvas = part("map");
    const top = (/** @type {PointerEvent} */ event) => {
      const box = canvas.getBoundingClientRect();
      return this.map.at(event.clientX - box.left, event.clientY - box.top);
    };
    canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      this.map.pointed = top(event);
      this.say(this.map.pointed);
      this.draw();
    });
    canvas.addEventListener("pointerleave", () => {
      this.map.pointed = -1;
      this.say(this.map.chosen);
      this.draw();
    });
    canvas.addEventListener("click", (/** @type {PointerEvent} */ event) => this.choose(top(event), true));
    /** @type {Record<string, [number, number]>} */
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    canvas.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      const way = ways[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      this.choose(this.map.beside(...way), true);
    });
  }

  /**
   * Takes a top: its line, and its motion.
   * @param {number} top
   * @param {boolean} keep whether the camera stays
   */
  choose(top, keep) {
    if (top === undefined || top < 0) return;
    this.map.chosen = top;
    this.say(top);
    this.draw();
    if (this.given) this.integrate(top, keep);
  }

  /**
   * The line of a top.
   * @param {number} top
   */
  say(top) {
    if (top < 0) return;
    const at = this.axes.map((/** @type {any} */ a) => `${a.label} = ${Number(a.numbers[top].toPrecision(5))}`);
    const rows = this.columns.map(({ words, unit, names, values }) => {
      const value = values[top];
      const text = names
        ? said(names[value] ?? "–")
        : isFinite(value)
          ? `${Number(value.toPrecision(5))} ${unit}`
          : "never";
      const row = document.createElement("tr");
      row.append(...[words, text].map((t) => Object.assign(document.createElement("td"), { textContent: t })));
      return row;
    });
    part("top").textContent = `Top ${top}: ${at.join(", ")}`;
    part("line-of-top").replaceChildren(...rows);
  }

  /**
   * Returns the numbers of a top. @param {number} top
   * @returns {import("./simulation.js").Given}
   */
  of(top) {
    const given = structuredClone(this.given);
    for (const [key, values] of Object.entries(this.changes)) {
      const [table, name] = key.split(".");
      if (table === "run" || table === "contact") given[name] = values[top];
      else given[table === "friction" ? "parameters" : table][name] = values[top];
    }
    given.step = sampling(given.initial.omega3 ?? 0, given.until);
    return given;
  }

  /**
   * @param {number} top
   * @param {boolean} keep
   */
  integrate(top, keep) {
    const given = this.of(top);
    const refused = refusal(given);
    document.body.classList.toggle("refused", !!refused);
    part("said").textContent = refused;
    if (refused) return;
    const { motion, log, potential, end, sizes } = simulated(given);
    const body = { ...this.body, ...sizes };
    this.stage.take({ body, motion, log, potential, wound: false }, keep);
    part("said").textContent = end ? `until ${motion.end.toFixed(3)} s: ${end}` : "";
  }

  /** Which choice of the further axes is shown, the last fastest. */
  choice() {
    return this.further.reduce((/** @type {number} */ at, value, k) => {
      const values = this.map.values[k + 2];
      return at * values.length + values.indexOf(Number(value));
    }, 0);
  }

  draw() {
    const colours = palette(this.stage.dark);
    this.borders.take(this.choice(), part("borders"));
    const [low, high] = this.map.draw(colours, this.column, () => this.borders.draw(this.map));
    const legend = part("legend");
    const { names, values, unit } = this.column;
    if (names) {
      const seen = new Map(names.map((name, i) => [name, this.map.tops.filter((t) => values[t] === i).length]));
      const items = [...seen].filter(([, count]) => count);
      legend.replaceChildren(
        ...items.map(([name, count]) => {
          const item = Object.assign(document.createElement("span"), { textContent: `${said(name)} (${count})` });
          item.style.setProperty("--colour", CLASSES[name] ?? "#888");
          return item;
        }),
      );
    } else {
      const text = isFinite(low) ? `${Number(low.toPrecision(4))} ${unit}` : "no number";
      const bar = Object.assign(document.createElement("i"), { className: "bar" });
      legend.replaceChildren(text, bar, isFinite(high) ? `${Number(high.toPrecision(4))} ${unit}` : "");
    }
  }
}

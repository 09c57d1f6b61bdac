/** Sliders with their words and values. */

/**
 * Writes a name with its index below the line: `γ_c`.
 * @type {(element: HTMLElement, name: string) => void}
 */
export const subscript = (element, name) => {
  element.innerHTML = name.replace(/_(\S+)/g, "<sub>$1</sub>");
};

/**
 * @typedef {object} Slider
 * @property {string} name
 * @property {string} words
 * @property {string} unit
 * @property {number} least
 * @property {number} most
 * @property {boolean} [log] whether it is even in the logarithm
 * @property {number} [scale] the displayed number of 1
 * @property {(value: number) => string} [also] the value in another unit
 */

const STEPS = 1000;
const CLOSE = 0.08; // marks that are nearer have one label

const scale = (/** @type {Slider} */ slider) => slider.scale ?? 1;

export class Sliders {
  /**
   * @param {HTMLElement} place
   * @param {() => void} changed
   */
  constructor(place, changed) {
    this.place = place;
    this.changed = changed;
    /** @type {Record<string, {slider: Slider, input: HTMLInputElement, typed: HTMLInputElement, output: HTMLOutputElement, marks: HTMLElement}>} */
    this.all = {};
    /** @type {Record<string, number>} */
    this.values = {};
  }

  /** @param {Slider} slider */
  add(slider) {
    const row = document.createElement("div");
    row.className = "slider";
    const words = document.createElement("span");
    subscript(words, slider.words);
    const output = document.createElement("output");
    const input = document.createElement("input");
    input.type = "range";
    input.min = "0";
    input.max = String(STEPS);
    input.dataset.part = `slider-${slider.name}`;
    input.setAttribute("aria-label", slider.words);
    const typed = document.createElement("input");
    typed.inputMode = "decimal";
    typed.dataset.part = `typed-${slider.name}`;
    typed.setAttribute("aria-label", `${slider.words}, ${slider.unit}`);
    const marks = document.createElement("i");
    row.append(words, typed, output, input, marks);
    this.place.append(row);
    this.all[slider.name] = { slider, input, typed, output, marks };
    typed.addEventListener("change", () => {
      const text = typed.value.replace(",", ".").replace(slider.unit, "");
      const given = text.trim() ? Number(text) : NaN; // another unit is no number
      const value = Number((given / scale(slider)).toPrecision(12));
      this.set({ [slider.name]: isFinite(value) ? value : this.values[slider.name] });
      this.changed();
    });
    input.addEventListener("input", () => {
      this.values[slider.name] = this.value(slider, Number(input.value) / STEPS);
      this.write(slider.name);
      this.changed();
    });
  }

  clear() {
    this.place.replaceChildren();
    this.all = {};
  }

  /** @type {(slider: Slider, s: number) => number} */
  value({ least, most, log }, s) {
    const value = log ? least * (most / least) ** s : least + (most - least) * s;
    return Number(value.toPrecision(4));
  }

  /** @type {(slider: Slider, value: number) => number} */
  part({ least, most, log }, value) {
    const s = log ? Math.log(value / least) / Math.log(most / least) : (value - least) / (most - least);
    return Math.min(1, Math.max(0, s));
  }

  /**
   * Sets values, within the limits of their sliders, without calling `changed`.
   * @param {Record<string, number>} values
   */
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      const known = this.all[name];
      this.values[name] = known ? Math.min(Math.max(value, known.slider.least), known.slider.most) : value;
      if (!known) continue;
      known.input.value = String(Math.round(STEPS * this.part(known.slider, value)));
      this.write(name);
    }
  }

  /** @param {string} name */
  write(name) {
    const { slider, input, typed, output } = this.all[name];
    const value = scale(slider) * this.values[name];
    const also = slider.also ? ` = ${slider.also(value)}` : "";
    typed.value = String(Number(value.toPrecision(4)));
    output.value = `${slider.unit}${also}`;
    input.setAttribute("aria-valuetext", `${typed.value} ${output.value}`);
  }

  /**
   * Marks below a slider.
   * @param {string} name
   * @param {{value: number, text: string, words: string}[]} marks
   */
  mark(name, marks) {
    const known = this.all[name];
    if (!known) return;
    const [first, second] = marks.map(({ value }) => this.part(known.slider, value));
    if (Math.abs(first - second) < CLOSE)
      marks = [
        { ...marks[0], text: `${marks[0].text} ${marks[1].text}` },
        { ...marks[1], text: "" },
      ];
    known.marks.replaceChildren(
      ...marks
        .filter(({ value }) => value > known.slider.least && value < known.slider.most)
        .map(({ value, text, words }) => {
          const mark = document.createElement("b");
          mark.style.left = `calc(8px + (100% - 16px) * ${this.part(known.slider, value)})`;
          subscript(mark, text);
          mark.title = words;
          return mark;
        }),
    );
  }
}

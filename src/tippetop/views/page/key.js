/** The legend of the line of times: what its colours mean, and for how much of the motion. */
import { cover } from "./palette.js";

/** @typedef {{phase: string, ball: string}} Place */

/** @typedef {import("./palette.js").Palette} Palette */
/** @typedef {import("./log.js").Log} Log */

const ORDER = ["slip", "roll", "rest", "flight", "both"];

export class Key {
  /** @param {HTMLElement} element */
  constructor(element) {
    this.element = element;
    /** @type {Log | undefined} */
    this.log = undefined;
    /** @type {Palette | undefined} */
    this.colours = undefined;
  }

  /**
   * Writes the legend if it has changed.
   * @param {Log} log
   * @param {[number, number]} span the whole motion
   * @param {Palette} colours
   */
  draw(log, span, colours) {
    if (log === this.log && colours === this.colours) return;
    [this.log, this.colours] = [log, colours];
    this.element.hidden = !log.phases.length;
    const entries = shares(log, span).map(({ words, phase, ball, share }) =>
      item(`${words}: ${percent(share)}`, cover(phase, ball, colours)),
    );
    const impacts = log.marks.filter(({ kind }) => kind === "impact").length;
    const mark = item(`${impacts} ${impacts === 1 ? "impact" : "impacts"}`, colours.alarm);
    mark.className = "impact";
    this.element.replaceChildren(...entries, ...(impacts ? [mark] : []));
  }
}

/**
 * A phase in words; in flight and on both balls, the ball means nothing.
 * @type {(of: {phase: string, ball: string}) => string}
 */
export const named = ({ phase, ball }) =>
  ball === "stem" && ["slip", "roll", "rest"].includes(phase) ? `${phase} on the stem` : phase;

/**
 * The phases of a motion, each with the part of the time that it takes.
 * @param {Log} log
 * @param {[number, number]} span
 */
function shares(log, [first, last]) {
  /** @type {Map<string, {words: string, phase: string, ball: string, share: number}>} */
  const kinds = new Map();
  for (const { start, end, phase, ball } of log.phases) {
    const words = named({ phase, ball });
    const kind = kinds.get(words) ?? { words, phase, ball: words === phase ? "body" : ball, share: 0 };
    kind.share += Math.max(0, Math.min(end, last) - Math.max(start, first)) / (last - first || 1);
    kinds.set(words, kind);
  }
  const place = (/** @type {Place} */ { phase, ball }) => ORDER.indexOf(phase) + (ball === "stem" ? ORDER.length : 0);
  return [...kinds.values()].sort((a, b) => place(a) - place(b));
}

/** @type {(share: number) => string} */
const percent = (share) => (share < 0.001 ? "< 0.1 %" : `${(100 * share).toFixed(1)} %`);

/** @type {(words: string, colour: string) => HTMLElement} */
function item(words, colour) {
  const entry = Object.assign(document.createElement("span"), { textContent: words });
  entry.style.setProperty("--colour", colour);
  return entry;
}

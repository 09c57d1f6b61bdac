/** Colours, told apart by colour-blind eyes too (after Okabe and Ito), for light and dark pages. */

/**
 * The three parts of a colour, 0 to 1.
 * @type {(hex: string) => [number, number, number]}
 */
export function rgb(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [(n >> 16) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
}

/** Arrows: name, colour, what it is. */
export const ARROWS = /** @type {[string, string, string][]} */ ([
  ["momentum", "#0f6fc6", "L angular momentum"],
  ["omega", "#e69f00", "ω angular velocity"],
  ["force", "#d1495b", "F force of the plane"],
  ["slip", "#0b9e77", "v sliding velocity"],
]);

const LIGHT = {
  ink: "#1c2733",
  quiet: "#66727f",
  line: "#dfe4ea",
  run: "#1f3b57",
  upper: "#c2410c",
  lower: "#0f766e",
  alarm: "#b4232f",
  fill: "rgba(194, 65, 12, 0.13)",
  paper: "#ffffff",
  phases: { slip: "#e8edf3", roll: "#bfe3d6", rest: "#f6d2cd", flight: "#fbe3b5", both: "#e3d3ee" },
  stem: { slip: "#c9dcf5", roll: "#86c9b1", rest: "#e6a39a" },
  sky: "#e9eef4",
  floor: "#f3f1ec",
  grid: "#b8bec6",
};

/** @type {typeof LIGHT} */
const DARK = {
  ink: "#e8edf2",
  quiet: "#93a1b0",
  line: "#2b3642",
  run: "#9cc3ea",
  upper: "#f2935c",
  lower: "#4fc3b0",
  alarm: "#ff7d87",
  fill: "rgba(242, 147, 92, 0.16)",
  paper: "#161d25",
  phases: { slip: "#222c37", roll: "#1d4a40", rest: "#5a2b28", flight: "#55431a", both: "#43305a" },
  stem: { slip: "#24405f", roll: "#2f7a67", rest: "#7d3b36" },
  sky: "#10161d",
  floor: "#232b34",
  grid: "#4b5866",
};

/** @typedef {typeof LIGHT} Palette */

/** @type {(dark: boolean) => Palette} */
export const palette = (dark) => (dark ? DARK : LIGHT);

/**
 * The colour of a phase of the contact.
 * @type {(phase: string, ball: string, colours: Palette) => string}
 */
export function cover(phase, ball, colours) {
  const known = /** @type {Record<string, Record<string, string>>} */ (/** @type {any} */ (colours));
  return (ball === "stem" && known.stem[phase]) || known.phases[phase] || colours.line;
}

/** The playground: a tippe top that is integrated in the page while its numbers are changed. */
import { turns } from "./chart.js";
import { facts } from "./phases.js";
import { refusal, sampling, simulated } from "./simulation.js";
import { Sliders, subscript } from "./sliders.js";
import { part } from "./part.js";
import { UNITS } from "./vector.js";

/** @typedef {import("./stage.js").Stage} Stage */
/** @typedef {import("./simulation.js").Given} Given */
/** @typedef {import("./sliders.js").Slider} Slider */

/**
 * @typedef {object} Preset
 * @property {string} name
 * @property {string} words
 * @property {Record<string, number>} parameters
 * @property {string} law
 * @property {Record<string, number>} initial
 * @property {boolean} atRest
 * @property {number} until
 * @property {number} e_n
 * @property {{r: number, h: number} | null} stem
 */

const DEGREE = 180 / Math.PI;
/** @type {Slider[]} */
const BODY = [
  { name: "m", words: "mass m", unit: "g", least: 0.002, most: 0.2, log: true, scale: 1e3 },
  { name: "R", words: "radius R", unit: "mm", least: 0.005, most: 0.06, log: true, scale: 1e3 },
  { name: "alpha", words: "eccentricity α", unit: "", least: 0.02, most: 0.6 },
  { name: "gamma", words: "γ = I₁/I₃", unit: "", least: 0.55, most: 1.5 },
  { name: "inertia", words: "I₃/mR²", unit: "", least: 0.15, most: 0.65 },
];
/** @type {Slider[]} */
const START = [
  { name: "omega3", words: "spin ω₃", unit: "rad/s", least: 0, most: 350, also: turns },
  { name: "theta", words: "tilt θ(0)", unit: "°", least: 0, most: Math.PI, scale: DEGREE },
  { name: "until", words: "how long", unit: "s", least: 1, most: 30 },
];
/** @type {Slider[]} */
const CONTACT = [
  { name: "e_n", words: "restitution e_n", unit: "", least: 0, most: 0.9 },
  {
    name: "r",
    words: "radius of the stem's ball",
    unit: "mm",
    least: 1e-3,
    most: 0.02,
    log: true,
    scale: 1e3,
  },
  { name: "h", words: "its height above the centre", unit: "mm", least: 5e-3, most: 0.06, scale: 1e3 },
];
const STEM = { r: 0.003, h: 0.0245 };
/** @type {Record<string, Slider>} */
const FRICTION = {
  mu: { name: "mu", words: "friction μ", unit: "s/m", least: 0.003, most: 10, log: true },
  mu_stem: { name: "mu_stem", words: "μ on the stem's side", unit: "s/m", least: 0.003, most: 10, log: true },
  mu_coulomb: { name: "mu_coulomb", words: "Coulomb's μ", unit: "", least: 0.01, most: 1, log: true },
  mu_static: { name: "mu_static", words: "μ at rest", unit: "", least: 0.01, most: 1.5, log: true },
  eps: { name: "eps", words: "ε", unit: "m/s", least: 1e-4, most: 0.1, log: true },
  v_s: { name: "v_s", words: "v_s", unit: "m/s", least: 1e-3, most: 1, log: true },
  patch: {
    name: "patch",
    words: "radius of the disc",
    unit: "mm",
    least: 5e-5,
    most: 2e-3,
    log: true,
    scale: 1e3,
  },
  mu_r: { name: "mu_r", words: "rolling resistance", unit: "mm", least: 0, most: 2e-4, scale: 1e3 },
};
const PURE = ["coulomb", "regularised", "stribeck", "contensou"]; // laws whose mu has no unit
const USUAL = /** @type {Record<string, number>} */ ({
  mu_stem: 0.3,
  mu_coulomb: 0.1,
  mu_static: 0.4,
  eps: 1e-2,
  v_s: 0.1,
  patch: 2e-4,
  mu_r: 0,
});
const LAWS = /** @type {Record<string, string>} */ ({
  viscous: "viscous: −μ gₙ v",
  contensou: "Coulomb that drills",
  coulomb: "Coulomb: slides or sticks",
  regularised: "Coulomb, regularised",
  mixed: "viscous and Coulomb",
  stribeck: "Stribeck",
  latitude: "viscous, by latitude",
  none: "no friction",
});
/** @type {Omit<import("./scene.js").Body, "unit" | "surfaces" | "weight">} */
const BALL = { kind: "ball", axes: UNITS, meridian: [], ellipsoid: [], fixed: false, asymmetric: false };

export class Playground {
  /**
   * @param {Stage} stage
   * @param {Preset[]} presets
   */
  constructor(stage, presets) {
    this.stage = stage;
    this.presets = presets;
    this.waiting = 0;
    this.preset = presets[0];
    const later = () => this.soon();
    this.body = new Sliders(part("body-sliders"), later);
    this.friction = new Sliders(part("friction-sliders"), later);
    this.start = new Sliders(part("start-sliders"), later);
    this.contact = new Sliders(part("contact-sliders"), later);
    this.groups = [this.body, this.friction, this.start, this.contact];
    for (const slider of BODY) this.body.add(slider);
    for (const slider of START) this.start.add(slider);
    part("stem").addEventListener("change", () => {
      this.stemChanged();
      this.soon();
    });
    for (const { name, words } of presets) part("preset").add(new Option(words, name));
    for (const law of Object.keys(facts.laws)) part("law").add(new Option(LAWS[law] ?? law, law));
    part("preset").addEventListener("change", () => this.take(part("preset").value));
    addEventListener("hashchange", () => this.linked());
    part("law").addEventListener("change", () => {
      this.lawChanged();
      this.soon();
    });
    part("copy").addEventListener("click", () => navigator.clipboard?.writeText(part("scenario").textContent));
    this.linked();
  }

  /** The settings in the address of the page. */
  linked() {
    const link = new URLSearchParams(location.hash.slice(1));
    this.take(link.get("preset") ?? this.presets[0].name, link);
  }

  /** Writes the settings into the address of the page. */
  link() {
    const settings = { preset: this.preset.name, law: part("law").value, stem: part("stem").checked ? "1" : "" };
    const shown = this.groups.flatMap(({ all, values }) => Object.keys(all).map((name) => [name, values[name]]));
    const link = new URLSearchParams({ ...settings, ...Object.fromEntries(shown) });
    history.replaceState(null, "", `#${link}`);
  }

  /**
   * @param {string} name of a preset
   * @param {URLSearchParams} link settings that differ from it
   */
  take(name, link = new URLSearchParams()) {
    const preset = this.presets.find((p) => p.name === name) ?? this.presets[0];
    this.preset = preset;
    const { m, R, alpha, I1, I3 } = preset.parameters;
    this.body.set({ m, R, alpha, gamma: I1 / I3, inertia: I3 / (m * R * R), g: preset.parameters.g });
    const law = link.get("law") ?? "";
    part("law").value = Object.hasOwn(facts.laws, law) ? law : preset.law;
    this.friction.values = { ...USUAL, mu: 0.3, ...preset.parameters };
    this.lawChanged();
    this.contact.values = { e_n: preset.e_n, ...STEM, ...preset.stem };
    part("stem").checked = link.has("stem") ? !!link.get("stem") : !!preset.stem;
    this.stemChanged();
    this.start.set({ omega3: preset.initial.omega3 ?? 0, theta: preset.initial.theta ?? 0, until: preset.until });
    const numbers = [...link].filter(([, text]) => text && isFinite(Number(text)));
    for (const group of this.groups) {
      const own = numbers.filter(([key]) => Object.hasOwn(group.all, key));
      group.set(Object.fromEntries(own.map(([key, text]) => [key, Number(text)])));
    }
    part("preset").value = preset.name;
    this.show(false);
  }

  /** The sliders of another law. */
  lawChanged() {
    const law = part("law").value;
    this.friction.clear();
    for (const name of facts.laws[law]) {
      const unit = name === "mu" && PURE.includes(law) ? "" : FRICTION[name].unit;
      this.friction.add({ ...FRICTION[name], unit });
    }
    const values = this.friction.values;
    this.friction.set(Object.fromEntries(facts.laws[law].map((name) => [name, values[name]])));
  }

  /** The sliders of a ball with or without a stem. */
  stemChanged() {
    const shown = part("stem").checked ? CONTACT : CONTACT.slice(0, 1);
    this.contact.clear();
    for (const slider of shown) this.contact.add(slider);
    this.contact.set(this.contact.values);
  }

  /** Returns the numbers of all controls. @returns {Given} */
  given() {
    const { m, R, alpha, gamma, inertia, g } = this.body.values;
    const { until, omega3, theta } = this.start.values;
    const I3 = rounded(inertia * m * R * R);
    const law = part("law").value;
    const { e_n, r, h } = this.contact.values;
    const numbers = Object.fromEntries(facts.laws[law].map((name) => [name, this.friction.values[name]]));
    return {
      law,
      parameters: { m, R, alpha, I1: rounded(gamma * I3), I3, g, ...numbers },
      initial: { ...this.preset.initial, omega3, theta },
      atRest: this.preset.atRest,
      until,
      step: sampling(omega3, until),
      e_n,
      stem: part("stem").checked ? { r, h } : null,
    };
  }

  /** Integrates a little later, once. */
  soon() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.show(true), 40);
  }

  /** @param {boolean} keep whether the camera stays */
  show(keep) {
    const given = this.given();
    const refused = refusal(given);
    document.body.classList.toggle("refused", !!refused);
    part("scenario").textContent = scenario(given);
    setTimeout(() => this.link()); // a browser may refuse many changes within a second
    if (refused) {
      this.stage.play(false);
      part("verdict").textContent = refused;
      return;
    }
    const began = performance.now();
    const found = simulated(given);
    const spent = performance.now() - began;
    const { motion, log, potential, sizes } = found;
    this.stage.take({ body: { ...BALL, ...sizes }, motion, log, potential, wound: false }, keep);
    this.thresholds(found.thresholds, Math.abs(motion.at(0, "well")[1]));
    part("verdict").textContent = verdict(found);
    part("cost").textContent = `integrated here in ${spent.toFixed(0)} ms, ${found.steps} steps`;
  }

  /**
   * @param {{name: string, unit: string, words: string, value: number}[]} thresholds
   * @param {number} lambda
   */
  thresholds(thresholds, lambda) {
    const by = Object.fromEntries(thresholds.map((t) => [t.name, t]));
    const mark = (/** @type {string} */ name, /** @type {string} */ text) => ({
      value: by[name].value,
      text,
      words: by[name].words,
    });
    this.start.mark("omega3", [mark("spin_upright", "ω_u"), mark("spin_full", "ω_s")]);
    this.body.mark("gamma", [mark("gamma_c", "γ_c"), mark("gamma_plus", "γ_+")]);
    const spins = /** @type {Record<string, string>} */ ({ lambda_u: "spin_upright", lambda_s: "spin_full" });
    const rows = ["lambda_u", "lambda_s", "lambda_de"].map((name) => {
      const { value, words } = by[name];
      const row = document.createElement("tr");
      const cells = [
        "",
        isFinite(value) ? (1e6 * value).toPrecision(4) : "∞",
        name in spins && isFinite(value) ? turns(by[spins[name]].value) : "",
        words,
        lambda > value ? "λ is above" : "λ is below",
      ];
      row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      subscript(row.cells[0], name.replace("lambda", "λ"));
      row.dataset.above = String(lambda > value);
      return row;
    });
    part("thresholds").replaceChildren(...rows);
    part("lambda").textContent = (1e6 * lambda).toPrecision(4);
  }
}

/** Without the rounding errors of the last digits. */
const rounded = (/** @type {number} */ value) => Number(value.toPrecision(12));

/**
 * Where the motion has come to, in a sentence.
 * @param {ReturnType<typeof simulated>} found
 */
function verdict({ motion, log, end }) {
  const theta = motion.at(motion.times.length - 1, "theta")[0] * DEGREE;
  const when = motion.end.toFixed(2);
  const passed = log.marks.find((m) => m.kind === "equator");
  const turned = passed ? `, passed 90° at ${passed.time.toFixed(2)} s` : "";
  const impacts = log.marks.filter((m) => m.kind === "impact").length;
  const hits = impacts ? `, ${impacts} impact${impacts > 1 ? "s" : ""}` : "";
  if (end) return `The page follows it to ${when} s and θ = ${theta.toFixed(1)}°: ${end}.`;
  const near = DEGREE * facts.near;
  const pole = theta > 90 ? "inverted" : "upright";
  const off = Math.min(theta, 180 - theta);
  const where = off < near ? pole : off < 4 * near ? `nearly ${pole}` : "tilted";
  return `After ${when} s it is ${where}, at θ = ${theta.toFixed(1)}°${turned}${hits}.`;
}

/**
 * The same top as a scenario of the engine.
 * @param {Given} given
 */
function scenario({ law, parameters, initial, atRest, until, e_n, stem }) {
  const written = (/** @type {number} */ value) => {
    if (Number.isInteger(value)) return value.toFixed(1);
    return Math.abs(value) < 1e-3 ? value.toExponential() : value;
  };
  const table = (/** @type {string[]} */ names, /** @type {Record<string, number>} */ values) =>
    names.map((n) => `${n} = ${written(values[n])}`).join("\n");
  const start = Object.keys(initial).filter((name) => initial[name]);
  return `system = "tippe-top"

[parameters]
${table(facts.parameters, parameters)}

[friction]
law = "${facts.keys[law]}"
${table(facts.laws[law], parameters)}

[initial]
${table(start, initial)}${atRest ? "\ncentre_at_rest = true" : ""}

[contact]
e_n = ${written(e_n)}
${stem ? `\n[stem]\n${table(["r", "h"], stem)}\n` : ""}
[run]
until = ${until.toFixed(3)}
output_step = 0.001
`;
}

/** A tippe top that is integrated in the page, as the page shows it. */
import { Contact } from "./contact.js";
import { Log } from "./log.js";
import { Motion, STRIDE } from "./motion.js";
import { facts } from "./phases.js";
import { ofAxes } from "./vector.js";

const THETA = 19; // its place in a sample
const [SHORTEST, LONGEST] = [5e-4, 0.002]; // seconds between samples
const MOST = 20_000; // samples
const GRID = 2_000; // angles at which the bounds of friction are computed, as in the engine

/**
 * @typedef {object} Given
 * @property {string} law
 * @property {Record<string, number>} parameters and numbers of the law, by name
 * @property {Record<string, number>} initial by name; missing ones are 0
 * @property {boolean} atRest whether the centre of mass starts at rest
 * @property {number} until [s]
 * @property {number} step of the samples [s]
 * @property {number} e_n restitution
 * @property {{r: number, h: number} | null} stem
 * @property {boolean} [stops] whether it ends where it lifts off
 */

const REFUSALS = {
  r: "`stem.r` must be smaller than parameters.R = {limit}, but is {given}.",
  h: "`stem.h` must exceed R - r = {limit}, or the stem never touches the plane, but is {given}.",
  mu: "`friction.{name}` must be less than {limit}, but is {given}: above it the contact force of this {ball} is not unique (Painleve).",
  mu_r: "`friction.mu_r` must be less than {limit}, or the contact force is not unique, but is {given}.",
};

/**
 * The sentence with which the engine refuses these numbers; empty if it takes them.
 * @param {Given} given
 */
export function refusal({ law, parameters, stem }) {
  const { m, R, alpha, I1, mu_r = 0 } = parameters;
  const say = (/** @type {string} */ text, /** @type {Record<string, number | string>} */ values) =>
    text.replace(/\{(\w+)\}/g, (_, key) => {
      const value = values[key];
      return typeof value === "number" ? String(Number(value.toPrecision(6))) : value;
    });
  const balls = [{ ball: "body", c: alpha * R, r: R }];
  if (stem) {
    const { r, h } = stem;
    if (r >= R) return say(REFUSALS.r, { limit: R, given: r });
    if (h <= R - r) return say(REFUSALS.h, { limit: R - r, given: h });
    balls.push({ ball: "stem", c: alpha * R + h, r });
  }
  const coefficients = facts.bounded[law];
  const mu = Math.max(0, ...coefficients.map((name) => parameters[name]));
  let [least, most, pressed] = [Infinity, Infinity, ""];
  for (const { ball, c, r } of balls)
    for (let i = 1; i < GRID; i++) {
      const theta = (i / GRID) * Math.PI;
      const [lever, height] = [Math.abs(c * Math.sin(theta)), Math.abs(r - c * Math.cos(theta))];
      const bound = (I1 / m + lever ** 2) / (lever * height);
      if (bound < least) [least, pressed] = [bound, ball];
      most = Math.min(most, (bound - mu) * height);
    }
  const name = coefficients.filter((name) => parameters[name] === mu).pop() ?? "";
  if (mu >= least) return say(REFUSALS.mu, { name, limit: least.toFixed(4), given: mu, ball: pressed });
  return mu_r < most ? "" : say(REFUSALS.mu_r, { limit: Number(most.toPrecision(3)), given: mu_r });
}

/**
 * Integrates, and returns what the page shows.
 * @param {Given} given
 */
export function simulated(given) {
  const top = new Contact(given);
  const { known, balls, solver } = top;
  const count = Math.max(1, Math.round(given.until / given.step));
  const times = new Float64Array(count + 1);
  const samples = new Float32Array((count + 1) * STRIDE);
  let n = 0;
  for (; n <= count && !top.end; n++) {
    top.to((n / count) * given.until);
    times[n] = solver.time;
    const acts = top.acts(solver.y);
    const force = [0, 1, 2].map((k) => acts.reduce((sum, [, by]) => sum + by[k], 0));
    const seen = new Float64Array(STRIDE + 2);
    known.seen(solver.y, force, balls[top.phase.ball], seen);
    samples.set(ofAxes([seen[0], seen[1], seen[2]], [seen[3], seen[4], seen[5]]), n * STRIDE);
    samples.set(seen.subarray(6), n * STRIDE + 4);
  }
  top.close();
  const motion = new Motion(times.slice(0, n), samples.slice(0, n * STRIDE), false);
  const theta = (/** @type {number} */ time) => motion.pose(time).theta;
  const changes = top.events.map((event) => ({ ...event, theta: theta(event.time) }));
  const events = [...turnings(motion), ...changes].sort((a, b) => a.time - b.time);
  const [body] = balls;
  return {
    motion,
    log: new Log(events, top.phases, motion, false),
    end: top.end,
    steps: solver.steps,
    sizes: drawn(known.sizes(body), given.stem),
    thresholds: known.thresholds(body),
    potential: (/** @type {[number, number, number]} */ ...z) => known.potential(...z, body),
  };
}

/**
 * theta at some times and the phases, from the variables themselves: for comparing with the engine.
 * @param {Given} given
 * @param {number[]} times
 */
export function followed(given, times) {
  const top = new Contact(given);
  const thetas = times.map((t) => (top.to(t) ? Math.atan2(Math.hypot(top.y[0], top.y[1]), top.y[2]) : NaN));
  return { thetas, phases: top.phases, events: top.events, end: top.end };
}

/**
 * The sizes of a body as the picture takes them.
 * @param {number[]} sizes
 * @param {{r: number, h: number} | null} stem
 */
function drawn([offset, radius, weight], stem) {
  /** @type {(h: number, r: number) => import("./scene.js").Surface} */
  const ball = (h, r) => ({ centre: [0, 0, h], half: [r, r, r] });
  const surfaces = [ball(offset, radius)];
  if (stem) surfaces.push(ball(offset + stem.h, stem.r));
  return { unit: radius, surfaces, weight };
}

/**
 * How far apart samples of a motion are: a fifteenth of a turn, within limits.
 * @param {number} spin [rad/s]
 * @param {number} until [s]
 */
export function sampling(spin, until) {
  return Math.max(SHORTEST, Math.min(LONGEST, 0.4 / Math.max(Math.abs(spin), 1)), until / MOST);
}

/**
 * The turning angles of a motion between its samples, by parabolas, and passages of pi/2.
 * @param {Motion} motion
 */
function turnings(motion) {
  const { times, samples } = motion;
  const theta = (/** @type {number} */ i) => samples[i * STRIDE + THETA];
  /** @type {{time: number, kind: string, theta: number, least?: boolean}[]} */
  const events = [];
  for (let i = 1; i + 1 < times.length; i++) {
    const [a, b, c] = [theta(i - 1), theta(i), theta(i + 1)];
    const h = times[i + 1] - times[i];
    if ((b - a) * (c - b) < 0 && Math.abs(a - 2 * b + c) > 1e-6) {
      const s = (0.5 * (a - c)) / (a - 2 * b + c);
      const most = b - 0.25 * (a - c) * s;
      events.push({ time: times[i] + s * h, kind: "turning", theta: most, least: a > b });
    }
    if ((a - Math.PI / 2) * (b - Math.PI / 2) < 0) {
      const s = (Math.PI / 2 - a) / (b - a);
      events.push({ time: times[i] - h + s * h, kind: "equator", theta: Math.PI / 2 });
    }
  }
  return events;
}

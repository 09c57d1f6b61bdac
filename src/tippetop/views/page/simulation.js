/** A motion that is integrated in the page, by the formulas that Python has written down. */
import { Extrapolation } from "./extrapolation.js";
import { facts, formulas } from "./formulas.js";
import { Log } from "./log.js";
import { Motion, STRIDE } from "./motion.js";
import { ofAxes } from "./vector.js";

export const TOLERANCE = 1e-13;
const FORCE = 12; // where the normal force stands in a sample, and theta
const THETA = 19;
const [SHORTEST, LONGEST] = [5e-4, 0.002]; // seconds between samples
const MOST = 20_000; // samples

/**
 * @typedef {object} Given
 * @property {string} law
 * @property {Record<string, number>} parameters and numbers of the law, by name
 * @property {Record<string, number>} initial by name; what is not given is 0
 * @property {boolean} atRest whether the centre of mass starts at rest
 * @property {number} until [s]
 * @property {number} step of the samples [s]
 */

/**
 * A start, its body, and the integrator that is there.
 * @param {Given} given
 * @param {number} tolerance
 */
export function begun(given, tolerance = TOLERANCE) {
  const known = formulas[given.law];
  const p = [...facts.parameters, ...facts.laws[given.law]].map((name) => given.parameters[name]);
  const b = known.body(p);
  const d = facts.initial.map((name) => given.initial[name] ?? 0);
  const theta = given.initial.theta ?? 0;
  const [sine, z] = [Math.sin(theta), Math.cos(theta)];
  const y = known.start(sine, z, d, b);
  if (given.atRest) for (const name of ["rx_dot", "ry_dot"]) y[facts.variables.indexOf(name)] = 0;
  const rates = (/** @type {Float64Array} */ at, /** @type {Float64Array} */ out) => known.rates(at, b, out);
  return { known, b, solver: new Extrapolation(rates, y, known.weights(b), facts.moving, tolerance) };
}

/**
 * Integrates, and gives what the page shows. Stops where the normal force falls to zero: the model ends there.
 * @param {Given} given
 * @param {number} tolerance
 */
export function simulated(given, tolerance = TOLERANCE) {
  const { known, b, solver } = begun(given, tolerance);
  const count = Math.max(1, Math.round(given.until / given.step));
  const times = new Float64Array(count + 1);
  const samples = new Float32Array((count + 1) * STRIDE);
  const seen = new Float64Array(STRIDE + 2);
  const force = () => {
    known.seen(solver.y, b, seen);
    return seen[2 + FORCE];
  };
  const last = solver.y.slice();
  let end = "";
  let n = 0;
  for (; n <= count && !end; n++) {
    times[n] = (n / count) * given.until;
    if (!solver.to(times[n])) {
      end = "stalled";
      break;
    }
    if (force() < 0) {
      end = "lifts off";
      if (n) times[n] = liftoff(solver, times[n - 1], last, force);
    }
    last.set(solver.y);
    samples.set(ofAxes([seen[0], seen[1], seen[2]], [seen[3], seen[4], seen[5]]), n * STRIDE);
    samples.set(seen.subarray(6), n * STRIDE + 4);
  }
  const motion = new Motion(times.slice(0, n), samples.slice(0, n * STRIDE), facts.planar);
  const events = turnings(motion);
  if (end === "lifts off") events.push({ time: motion.end, kind: "liftoff", theta: motion.pose(motion.end).theta });
  const log = new Log(events, [], motion, facts.planar);
  const potential = known.potential;
  return {
    motion,
    log,
    end,
    steps: solver.steps,
    sizes: drawn(known.sizes(b)),
    thresholds: known.thresholds(b),
    potential: potential
      ? (/** @type {number} */ z, /** @type {number} */ one, /** @type {number} */ two) => potential(z, one, two, b)
      : undefined,
  };
}

/**
 * Takes a motion back to the last moment at which the force is not negative; returns its time.
 * @param {Extrapolation} solver
 * @param {number} start time of the sample before [s]
 * @param {Float64Array} state of the sample before
 * @param {() => number} force of the state of the solver
 */
function liftoff(solver, start, state, force) {
  let [held, lifted] = [start, solver.time];
  const at = (/** @type {number} */ time) => {
    solver.y.set(state);
    solver.time = start;
    solver.to(time);
    return force();
  };
  for (let k = 0; k < 40; k++) {
    const middle = (held + lifted) / 2;
    if (at(middle) < 0) lifted = middle;
    else held = middle;
  }
  at(held);
  return held;
}

/**
 * The sizes of a body as the picture takes them.
 * @param {number[]} sizes
 * @param {{r: number, h: number}} [stem]
 */
export function drawn([offset, radius, weight, across, along], stem) {
  /** @type {[number, number]} */
  const ellipsoid = [across, along];
  const balls = [{ offset, radius }];
  if (stem) balls.push({ offset: offset + stem.h, radius: stem.r });
  return { unit: radius || -offset, balls, ellipsoid, weight };
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
export function turnings(motion) {
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

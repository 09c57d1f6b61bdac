/**
 * A tippe top that slips, rolls, flies, lands on its sphere or its stem, and stands on both: the phases of the engine and
 * what follows the end of each, by the same formulas.
 */
import { Extrapolation } from "./extrapolation.js";
import { facts, formulas } from "./phases.js";

/** @typedef {import("./simulation.js").Given} Given */
/** @typedef {number[] | Float64Array} Numbers */
/** @typedef {{label: string, ball: number}} Phase */
/** @typedef {[number, string, number][]} Ends functions that fall to zero where a phase ends, name and ball */

// places in the state: axis, L, velocity and height of the centre of mass; and in a body
const [L, V, HEIGHT] = [3, 6, 9];
const [MASS, RADIUS, OFFSET, , , GRAVITY, MU] = [0, 1, 2, 3, 4, 5, 6];
// speeds in units of sqrt(g R), lengths in units of R
const STOPPED = 1e-10; // slower, sliding has stopped; an impulse takes the rest
const BEGINS = 1e-8; // the speed with which sliding begins from rest
const CLOSES = 1e-6; // a slower impact does not bounce
const BOTH = 1e-6; // both balls slower than this: the body stands on them
const TOUCHES = 1e-12; // gap of a ball that touches
const FELT = { flight: 1e-14, other: 1e-13 }; // gap below zero at which a landing is noticed
const STILL = 1e-6; // speed of a disc and its edge, by its radius: slower, it rests
const OUTSIDE = 6.25; // w^2/U^2 from which the series of drilling friction is used
const TURN = 0.15; // rad, the longest step once the normal force was small: a shorter flight may be missed
const SMALL = 0.8; // of the weight
const TOLERANCE = 1e-13;
const [MOST_STEPS, MOST_PHASES, MOST_STRIKES] = [400_000, 10_000, 16];

export class Contact {
  /**
   * @param {Given} given
   * @param {number} tolerance
   */
  constructor(given, tolerance = TOLERANCE) {
    const known = formulas[given.law];
    const p = [...facts.parameters, ...facts.laws[given.law]].map((name) => given.parameters[name]);
    const body = known.body(p);
    this.known = known;
    this.balls = [body];
    if (given.stem) {
      const stem = body.slice();
      stem[RADIUS] = given.stem.r;
      stem[OFFSET] += given.stem.h;
      this.balls.push(stem);
    }
    this.exact = facts.exact.includes(given.law);
    this.patch = given.parameters.patch ?? 0;
    this.e_n = given.e_n;
    this.size = body[RADIUS];
    this.speed = Math.sqrt(body[GRAVITY] * body[RADIUS]);
    this.tolerance = tolerance;
    this.stops = given.stops;
    this.turn = TURN / Math.max(Math.abs(given.initial.omega3 ?? 0), 10);
    this.small = false;
    this.hop = 0; // [s] a part of the flight that has begun
    const d = facts.initial.map((name) => given.initial[name] ?? 0);
    const theta = given.initial.theta ?? 0;
    const y = known.start(Math.sin(theta), Math.cos(theta), d, body);
    if (given.atRest) y[V] = y[V + 1] = 0;
    const sizes = [1, body[MASS] * this.size * this.speed, this.speed, this.size, 1];
    this.weights = Array.from(y, (_, k) => sizes[Math.min(Math.floor(k / 3), 4)]);
    const rates = (/** @type {Float64Array} */ at, /** @type {Float64Array} */ out) => this.rates(at, out);
    this.solver = new Extrapolation(rates, y, this.weights, facts.moving, tolerance);
    /** @type {Phase} */
    this.phase = { label: "flight", ball: 0 };
    /** @type {{start: number, end: number, phase: string, ball: string}[]} */
    this.phases = [];
    /** @type {{time: number, kind: string}[]} */
    this.events = [];
    this.end = "";
    const gaps = this.balls.map((b) => this.gap(y, b));
    if (given.initial.gap === undefined) this.solver.y[HEIGHT] -= Math.min(...gaps);
    this.start();
  }

  get y() {
    return this.solver.y;
  }

  /** @type {(y: Numbers, b: number[]) => number} */
  gap(y, b) {
    return y[HEIGHT] - b[RADIUS] + b[OFFSET] * y[2];
  }

  /** The vertical velocity of the lowest point of a ball. */
  rise(/** @type {number} */ ball) {
    return this.known.point(this.y, this.balls[ball])[2];
  }

  touching() {
    return this.balls.map((_, k) => k).filter((k) => this.gap(this.y, this.balls[k]) <= TOUCHES * this.size);
  }

  bothRest() {
    return this.touching().length > 1 && this.balls.every((_, k) => Math.abs(this.rise(k)) < BOTH * this.speed);
  }

  // --- what the plane does -----------------------------------------------------------------------

  /**
   * Force and torque of friction per normal force: the law's formula for the region of these speeds.
   * @type {(y: Numbers, b: number[]) => number[]}
   */
  friction(y, b) {
    const { frictions, point } = this.known;
    if (frictions.length === 1) return frictions[0](y, b);
    const [x, z, , U2] = point(y, b);
    const w2 = x * x + z * z;
    return frictions[w2 <= U2 ? 0 : w2 < OUTSIDE * U2 ? 1 : 2](y, b);
  }

  /**
   * Force and torque at each contact.
   * @param {Numbers} y
   * @returns {[number[], number[]][]} body seen from the ball, and both
   */
  acts(y) {
    const { known, balls } = this;
    const { label, ball } = this.phase;
    const b = balls[ball];
    if (label === "flight") return [];
    if (label === "roll") return [[b, [...known.held(y, b), 0, 0, 0]]];
    if (label === "both") {
      const [I1, weight] = [b[3], b[MASS] * b[GRAVITY]];
      const [x, z] = [(y[4] * y[2] - y[5] * y[1]) / I1, (y[5] * y[0] - y[3] * y[2]) / I1];
      return this.shared(y, weight, y[4] * x - y[3] * z);
    }
    const per = this.friction(y, b);
    return [[b, scaled(known.normal(y, per, b), per)]];
  }

  /**
   * Force and torque, or impulses, at both balls, of normal forces with this sum whose torque gives this swing of the axis.
   * @param {Numbers} y
   * @param {number} total
   * @param {number} swing
   * @returns {[number[], number[]][]}
   */
  shared(y, total, swing) {
    const pers = this.balls.map((b) => this.friction(y, b));
    const [one, two] = this.balls.map((b, k) => {
      const turn = this.known.turn(y, pers[k], b);
      return turn[0] * y[1] - turn[1] * y[0];
    });
    const N = (swing - total * one) / (two - one);
    return [
      [this.balls[0], scaled(total - N, pers[0])],
      [this.balls[1], scaled(N, pers[1])],
    ];
  }

  /**
   * @param {Float64Array} y
   * @param {Float64Array} out
   */
  rates(y, out) {
    this.known.rates(y, this.balls[0], out);
    for (const [b, by] of this.acts(y)) this.push(y, out, b, by);
  }

  /**
   * Adds what a force and torque, or impulses, do to L and the velocity.
   * @param {Numbers} y
   * @param {Numbers} out
   * @param {number[]} b
   * @param {Numbers} by
   */
  push(y, out, b, by) {
    const turn = this.known.turn(y, by, b);
    for (let k = 0; k < 3; k++) {
      out[L + k] += turn[k];
      out[V + k] += by[k] / b[MASS];
    }
  }

  /**
   * Changes the velocity of the lowest point of a ball by an impulse.
   * @param {number[]} b
   * @param {number[]} change
   */
  kick(b, change, y = this.y) {
    this.push(y, y, b, [...this.known.pinned(y, change, b), 0, 0, 0]);
  }

  // --- phases ------------------------------------------------------------------------------------

  /** @returns {Ends} */
  ends() {
    const { y, known, balls, phase } = this;
    const { label, ball } = phase;
    if (label === "flight") return balls.map((b, k) => [this.gap(y, b) + FELT.flight * this.size, "lands", k]);
    const acts = this.acts(y);
    if (label === "both") return acts.map(([, by], k) => [by[2], "leaves", k]);
    const [b, by] = acts[0];
    /** @type {Ends} */
    const all = [[by[2], "lifts", ball]];
    if (balls.length > 1) all.push([this.gap(y, balls[1 - ball]) + FELT.other * this.size, "touches", 1 - ball]);
    if (label === "roll") all.push([b[MU] * by[2] - Math.hypot(by[0], by[1]), "gives", ball]);
    else {
      const [x, z, , U2] = known.point(y, b);
      const w = Math.hypot(x, z);
      if (this.exact) all.push([w - STOPPED * this.speed, "stops", ball]);
      const slow = (STILL * this.patch * this.speed) / this.size;
      if (this.patch) all.push([w * w + U2 - slow * slow, "rests", ball]);
    }
    return all;
  }

  /**
   * Begins a phase.
   * @param {string} label
   * @param {number} ball
   */
  begin(label, ball) {
    this.close();
    this.phase = { label, ball };
    const rise = label === "flight" ? this.rise(ball) : 0;
    this.hop = 0.2 * (rise > 0.1 * CLOSES * this.speed ? rise / this.balls[0][GRAVITY] : this.turn);
    this.phases.push({ start: this.solver.time, end: NaN, phase: label, ball: ball ? "stem" : "body" });
    if (this.phases.length > MOST_PHASES) this.end = "the contact changes too often";
  }

  close() {
    if (this.phases.length) this.phases[this.phases.length - 1].end = this.solver.time;
  }

  /** The first phase. */
  start() {
    const [ball] = this.touching().sort((i, j) => this.rise(i) - this.rise(j));
    const rise = ball === undefined ? Infinity : this.rise(ball);
    if (rise > BOTH * this.speed) this.begin("flight", 0);
    else if (rise < -CLOSES * this.speed || this.touching().length > 1) this.strike(ball);
    else this.onPlane(ball);
  }

  /**
   * What follows on the plane, of a ball whose lowest point does not rise.
   * @param {number} ball
   * @returns {string} the label of the phase
   */
  onPlane(ball) {
    const { y, known } = this;
    const b = this.balls[ball];
    this.kick(b, [0, 0, -this.rise(ball)]);
    y[HEIGHT] -= this.gap(y, b);
    const [x, z] = known.point(y, b);
    if (this.exact && Math.hypot(x, z) <= 2 * STOPPED * this.speed) {
      this.kick(b, [-x, -z, 0]);
      const F = known.held(y, b);
      const size = Math.hypot(F[0], F[1]);
      if (F[2] > 0 && b[MU] * F[2] >= size) {
        this.begin("roll", ball);
        return "roll";
      }
      const k = (-BEGINS * this.speed) / (size || 1);
      this.kick(b, [k * F[0], k * F[1], 0]);
    }
    const label = known.normal(y, this.friction(y, b), b) > 0 ? "slip" : "flight";
    this.begin(label, ball);
    return label;
  }

  /** The body on both balls, or on the one that presses. */
  onBoth() {
    if (this.exact) {
      this.end = "it stands on sphere and stem, which Coulomb's law itself does not decide";
      return;
    }
    const { y } = this;
    const mass = this.balls[0][MASS];
    const impulses = this.shared(y, -mass * y[V + 2], y[4] * y[0] - y[3] * y[1]);
    for (const [b, by] of impulses) this.push(y, y, b, by);
    y[V + 2] = 0;
    y[HEIGHT] -= this.gap(y, this.balls[0]);
    const before = this.phase;
    this.phase = { label: "both", ball: 0 };
    const [one, two] = this.acts(y).map(([, by]) => by[2]);
    this.phase = before;
    if (Math.min(one, two) > 0) this.begin("both", 0);
    else this.onPlane(one > two ? 0 : 1);
  }

  // --- impacts -----------------------------------------------------------------------------------

  /**
   * An impact of a ball, and of the other one should that be pressed into the plane; and what follows.
   * @param {number} ball
   */
  strike(ball) {
    let bounces = false;
    for (let pressed = [ball], k = 0; pressed.length && !this.bothRest(); k++) {
      if (k === MOST_STRIKES) {
        this.end = "sphere and stem strike the plane in turn too often for this page";
        return;
      }
      ball = pressed[0];
      bounces = this.impact(ball);
      pressed = this.touching().filter((k) => k !== ball && this.rise(k) < -BOTH * this.speed);
    }
    if (this.bothRest()) this.onBoth();
    else if (bounces) this.begin("flight", ball);
    else this.onPlane(ball);
  }

  /**
   * Follows an impact in the normal impulse: compression to v_n = 0, then restitution of e_n^2 of its work.
   * @param {number} ball
   */
  impact(ball) {
    const { known, exact } = this;
    const b = this.balls[ball];
    const fast = this.rise(ball);
    const e_n = fast > -CLOSES * this.speed ? 0 : this.e_n;
    let sticks = false;
    const n = this.y.length;
    const rates = (/** @type {Float64Array} */ y, /** @type {Float64Array} */ out) => {
      let per = this.friction(y, b);
      if (sticks) {
        const pinned = known.pinned(y, [0, 0, 1], b);
        per = [...scaled(1 / pinned[2], pinned), 0, 0, 0];
      }
      out.fill(0);
      this.push(y, out, b, per);
      out[n] = known.point(y, b)[2];
    };
    const start = [...this.y, 0];
    const solver = new Extrapolation(rates, start, [...this.weights, 1], facts.moving, this.tolerance);
    solver.step = 0.1 * b[MASS] * Math.abs(fast);
    let work = -Infinity;
    const ends = () => {
      const [x, z, rise] = known.point(solver.y, b);
      /** @type {Ends} */
      const all = [work === -Infinity ? [-rise, "turns", ball] : [work * (1 - e_n * e_n) - solver.y[n], "opens", ball]];
      if (exact && !sticks) all.push([Math.hypot(x, z) - STOPPED * this.speed, "stops", ball]);
      return all;
    };
    for (let k = 0; k < MOST_STRIKES; k++) {
      const name = reach(solver, Infinity, ends)?.[1];
      if (name === "stops") {
        const [x, z, up] = known.pinned(solver.y, [0, 0, 1], b);
        sticks = Math.hypot(x, z) <= b[MU] * up;
        const size = (sticks ? 0 : -BEGINS * this.speed) / Math.hypot(x, z);
        const v = known.point(solver.y, b);
        this.kick(b, [size * x - v[0], size * z - v[1], 0], solver.y);
      } else if (name === "turns" && e_n) work = solver.y[n];
      else break;
    }
    this.y.set(solver.y.subarray(0, n));
    this.events.push({ time: this.solver.time, kind: "impact" });
    return e_n > 0;
  }

  // --- the run -----------------------------------------------------------------------------------

  /** The longest step now: short after a change, so that a landing or a flight that is as short is not passed over. */
  longest() {
    const { start } = this.phases[this.phases.length - 1];
    this.small ||= this.acts(this.y).some(([b, by]) => by[2] < SMALL * b[MASS] * b[GRAVITY]);
    return Math.min(this.small ? this.turn : Infinity, this.hop + 0.3 * (this.solver.time - start));
  }

  /**
   * Goes to a time; false where the motion ends before.
   * @param {number} end
   */
  to(end) {
    const { solver } = this;
    while (solver.time < end && !this.end) {
      const until = Math.min(end, solver.time + this.longest());
      const found = reach(solver, until, () => this.ends());
      if (!found && solver.time < until) this.end = "its steps become too short for this page";
      if (solver.steps > MOST_STEPS) this.end = "it takes too many steps for this page";
      if (found) this.follow(found[1], found[2]);
    }
    return !this.end;
  }

  /**
   * What follows the end of a phase.
   * @param {string} name
   * @param {number} ball
   */
  follow(name, ball) {
    const log = (/** @type {string} */ kind) => this.events.push({ time: this.solver.time, kind });
    if (name === "lands" || name === "touches") this.strike(ball);
    else if (name === "leaves") this.onPlane(1 - ball);
    else if (name === "rests") this.end = "its contact comes to rest, which this page does not follow";
    else if (name === "lifts") {
      log("liftoff");
      if (this.stops) this.end = "it lifts off, where its model ends";
      else this.begin("flight", ball);
    } else if (name === "gives") {
      log("slip");
      this.onPlane(ball);
    } else log(this.onPlane(ball) === "roll" ? "stick" : "reversal");
  }
}

/** @type {(k: number, values: Numbers) => number[]} */
const scaled = (k, values) => Array.from(values, (value) => k * value);

/**
 * Makes steps until a time, or until the first of some functions falls below zero: there the solver is left.
 * @param {Extrapolation} solver
 * @param {number} end
 * @param {() => Ends} ends
 * @returns {Ends[0] | undefined} the function that did
 */
function reach(solver, end, ends) {
  const least = () => ends().reduce((a, b) => (b[0] < a[0] ? b : a));
  const before = solver.y.slice();
  let first = least();
  while (solver.time < end) {
    const [start, step] = [solver.time, solver.step];
    before.set(solver.y);
    if (!solver.once(end)) return undefined;
    let found = least();
    if (found[0] >= 0) {
      first = found;
      continue;
    }
    const at = (/** @type {number} */ time) => {
      solver.y.set(before);
      [solver.time, solver.step] = [start, step];
      solver.to(time);
      return least();
    };
    let [low, f, high, g] = [start, Math.max(first[0], 0), solver.time, found[0]];
    for (let k = 0; k < 100 && high - low > 1e-15 * (1 + high); k++) {
      const even = k % 3 === 2 || !(f > g) ? 0.5 : f / (f - g);
      const middle = low + (high - low) * Math.min(Math.max(even, 1e-3), 1 - 1e-3);
      if (middle <= low || middle >= high) break;
      const value = at(middle);
      if (value[0] < 0) [high, g] = [middle, value[0]];
      else [low, f] = [middle, value[0]];
    }
    found = at(high);
    solver.step = step;
    return found;
  }
  return undefined;
}

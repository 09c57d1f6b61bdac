/** Events and phases of a motion, as the plots and the steps from event to event take them. */
import { before } from "./chart.js";
import { CHANNELS, STRIDE } from "./motion.js";

/** @typedef {{time: number, kind: string, text: string}} Mark */
/** @typedef {{time: number, theta: number, least: boolean}} Turning */
/** @typedef {{start: number, end: number, phase: string, ball: string}} Phase */

const WORDS = /** @type {Record<string, string>} */ ({
  turning: "turning angle",
  liftoff: "lifts off",
  equator: "axis horizontal",
  inverted: "within 0.1 rad of inverted",
  settled: "sliding died out",
  fallen: "has fallen",
  stick: "sticks",
  slip: "begins to slide",
  reversal: "sliding turns back",
  impact: "strikes the plane",
});
const PAUSE = 3; // times the usual gap between turnings: there the band is broken

export class Log {
  /**
   * @param {{time: number, kind: string, theta: number | null, least?: boolean}[]} events ascending; null: no number
   * @param {Phase[]} phases
   * @param {import("./motion.js").Motion} motion
   * @param {boolean} wound whether theta is not bound to [0, pi]
   */
  constructor(events, phases, motion, wound) {
    this.phases = phases;
    this.starts = phases.map((p) => p.start);
    this.wound = wound;
    this.changes = phases.length > 1;
    /** @type {Mark[]} */
    this.marks = events.map(({ time, kind, theta }) => ({
      time,
      kind,
      text: `${WORDS[kind] ?? kind} at ${time.toFixed(4)} s${theta === null ? "" : `, θ = ${((theta * 180) / Math.PI).toFixed(2)}°`}`,
    }));
    this.times = this.marks.map((m) => m.time);
    /** @type {Turning[]} */
    this.turnings = events.flatMap(({ time, kind, theta, least }) =>
      kind === "turning" && theta !== null ? [{ time, theta, least: !!least }] : [],
    );
    this.bands = bands(this.turnings);
    let [low, high, least, most] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = 0; i < motion.samples.length; i += STRIDE) {
      const theta = motion.samples[i + CHANNELS.theta[0]];
      const force = motion.samples[i + CHANNELS.force[0] + 2];
      [low, high] = [Math.min(low, theta), Math.max(high, theta)];
      if (isFinite(force)) [least, most] = [Math.min(least, force), Math.max(most, force)];
    }
    this.thetas = [low, high > low ? high : low + 0.1];
    this.forces = [least, most];
    this.nearLiftoff = least < 0.6 * most;
  }

  /**
   * The phase at a time.
   * @param {number} t
   * @returns {Phase | undefined}
   */
  phase(t) {
    return this.phases[Math.max(0, before(this.starts, t))];
  }

  /**
   * Whether the body itself touches the plane at a time: its potential is that of this contact.
   * @param {number} t
   */
  touches(t) {
    const phase = this.phase(t);
    return !phase || (phase.ball === "body" && phase.phase !== "flight");
  }

  /**
   * The event next to a time, forwards or backwards.
   * @param {number} t
   * @param {boolean} forwards
   * @param {boolean} all whether turnings count
   * @returns {Mark | undefined}
   */
  next(t, forwards, all) {
    const step = 1e-9 * (1 + Math.abs(t));
    const counts = (/** @type {Mark} */ m) => all || m.kind !== "turning";
    if (forwards) return this.marks.slice(before(this.times, t + step) + 1).find(counts);
    return this.marks
      .slice(0, before(this.times, t - step) + 1)
      .reverse()
      .find(counts);
  }
}

/**
 * Pieces of the band between maxima and minima, broken where turnings pause.
 * @param {Turning[]} turnings
 */
function bands(turnings) {
  const usual = (/** @type {number} */ i) => {
    const near = turnings.slice(Math.max(0, i - 8), i + 8);
    const gaps = near.slice(1).map((t, k) => t.time - near[k].time);
    return gaps.sort((a, b) => a - b)[gaps.length >> 1];
  };
  /** @type {{low: [number, number][], high: [number, number][]}[]} */
  const pieces = [{ low: [], high: [] }];
  turnings.forEach(({ time, theta, least }, i) => {
    if (i && time - turnings[i - 1].time > PAUSE * usual(i)) pieces.push({ low: [], high: [] });
    pieces[pieces.length - 1][least ? "low" : "high"].push([time, theta]);
  });
  return pieces.filter(({ low, high }) => low.length > 1 && high.length > 1);
}

/** The time of the motion: it plays at a speed, stops at the end, and is moved by hand. */

export const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];

/** [ms] A slower frame slows the motion down: the browser was suspended, or the page in the background. */
const LONGEST = 2000;

export class Clock {
  constructor() {
    this.time = 0;
    this.start = 0;
    this.end = 1;
    this.speed = 1;
    this.playing = false;
    /** @type {number | undefined} of the frame before [ms] */
    this.last = undefined;
    /** Since the frame before [s]. */
    this.passed = 0;
    /** Whether the next picture is not a small step from the last. */
    this.jumped = true;
  }

  /**
   * @param {number} start
   * @param {number} end
   */
  take(start, end) {
    [this.start, this.end] = [start, end];
    this.set(Math.min(Math.max(this.time, start), end));
  }

  /** @param {number} time */
  set(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.jumped = true;
  }

  /** @param {boolean} playing */
  play(playing) {
    if (playing && this.time >= this.end) this.set(this.start);
    this.playing = playing;
    this.last = undefined;
  }

  /**
   * Goes on to a moment of the page.
   * @param {number} now [ms]
   * @returns {number} how far the motion went [s]
   */
  tick(now) {
    this.passed = this.last === undefined ? 0 : Math.min(now - this.last, LONGEST) / 1e3;
    this.last = now;
    if (!this.playing) return 0;
    const step = this.passed * this.speed;
    this.time = Math.min(this.time + step, this.end);
    if (this.time >= this.end) this.playing = false;
    return step;
  }

  /** @param {number} steps along the list of speeds */
  faster(steps) {
    const at = SPEEDS.reduce(
      (best, s, i) => (Math.abs(Math.log(s / this.speed)) < Math.abs(Math.log(SPEEDS[best] / this.speed)) ? i : best),
      0,
    );
    this.speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at + steps))];
  }
}

/** @type {(speed: number) => string} */
export const speedText = (speed) => (speed >= 1 ? `${speed}×` : `1/${Math.round(1 / speed)}`);

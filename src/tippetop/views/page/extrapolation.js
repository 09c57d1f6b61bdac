/**
 * An explicit Runge-Kutta pair of orders 12 and 10 without a table of numbers: the modified midpoint rule with 2, 4, ...,
 * 12 substeps, extrapolated (Gragg 1965, Bulirsch and Stoer 1966). 43 evaluations a step.
 */

const COLUMNS = 6;

/** @typedef {(y: Float64Array, out: Float64Array) => void} Rates */

export class Extrapolation {
  /**
   * @param {Rates} rates
   * @param {ArrayLike<number>} start
   * @param {ArrayLike<number>} weights usual size of each variable
   * @param {number} moving how many variables, the first ones, control the step
   * @param {number} tolerance of a step, relative to weight and value
   */
  constructor(rates, start, weights, moving, tolerance) {
    const n = start.length;
    const empty = () => new Float64Array(n);
    this.rates = rates;
    this.weights = weights;
    this.moving = moving;
    this.tolerance = tolerance;
    this.y = Float64Array.from(start);
    this.time = 0;
    this.step = 1e-4;
    this.steps = 0;
    this.slope = empty();
    this.k = empty();
    this.earlier = empty();
    this.later = empty();
    /** The last row of the scheme: value of the first column, of the second, ... */
    this.row = Array.from({ length: COLUMNS }, empty);
    this.error = empty();
  }

  /**
   * Integrates up to a time; false where that cannot be done.
   * @param {number} end
   */
  to(end) {
    while (this.time < end) if (!this.once(end)) return false;
    return true;
  }

  /**
   * Makes one step, at most up to a time; false where none is short enough.
   * @param {number} end
   */
  once(end) {
    for (;;) {
      const last = this.time + 1.000001 * this.step >= end;
      const wanted = this.step;
      if (last) this.step = end - this.time;
      const taken = this.step;
      if (this.advances()) {
        this.time = last ? end : this.time + taken;
        if (last) this.step = Math.max(this.step, wanted);
        this.steps += 1;
        return true;
      }
      if (!(this.step > 1e-13)) return false;
    }
  }

  /** Makes one step if its error allows it; returns whether, and sets the length of the next. */
  advances() {
    const { y, row, error } = this;
    const n = y.length;
    this.rates(y, this.slope);
    for (let j = 0; j < COLUMNS; j++) {
      this.midpoint(2 * (j + 1));
      // Neville's scheme in the square of the substep: row[k] turns from the row before to this one
      for (let i = 0; i < n; i++) {
        let value = this.later[i];
        for (let k = 0; k < j; k++) {
          const before = row[k][i];
          row[k][i] = value;
          const ratio = (j + 1) / (j - k);
          value += (value - before) / (ratio * ratio - 1);
        }
        if (j === COLUMNS - 1) error[i] = value - row[j - 1][i];
        row[j][i] = value;
      }
    }
    let worst = 0;
    for (let i = 0; i < this.moving; i++) {
      const scale = this.tolerance * (this.weights[i] + Math.abs(y[i]));
      worst = Math.max(worst, Math.abs(error[i]) / scale);
    }
    if (!isFinite(worst)) worst = 1e30;
    const factor = Math.min(3, Math.max(0.1, 0.9 * (worst || 1e-30) ** (-1 / 11)));
    this.step *= factor;
    if (worst > 1) return false;
    y.set(row[COLUMNS - 1]);
    return true;
  }

  /**
   * The modified midpoint rule over the step, into `later`.
   * @param {number} substeps
   */
  midpoint(substeps) {
    const { y, slope, k } = this;
    const n = y.length;
    const h = this.step / substeps;
    let a = this.earlier;
    let b = this.later;
    for (let i = 0; i < n; i++) {
      a[i] = y[i];
      b[i] = y[i] + h * slope[i];
    }
    for (let m = 1; m < substeps; m++) {
      this.rates(b, k);
      for (let i = 0; i < n; i++) a[i] += 2 * h * k[i];
      [a, b] = [b, a];
    }
    [this.earlier, this.later] = [a, b];
  }
}

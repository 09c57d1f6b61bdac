/** A small plot on a canvas: scales, axes, curves that keep their peaks. */

/** @typedef {import("./palette.js").Palette} Palette */

/** Of a font of 11 pixels. */
const MARGIN = { left: 46, right: 12, top: 22, bottom: 24 };

/**
 * Round numbers within a range, about so many.
 * @type {(low: number, high: number, count: number) => number[]}
 */
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  if (!(rough > 0) || !isFinite(rough)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((k) => k * power >= rough) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/** @type {(value: number) => string} */
export function tidy(value) {
  const text = Math.abs(value) < 1e-12 ? "0" : String(parseFloat(value.toPrecision(6)));
  return text.replace("-", "−");
}

/**
 * A spin in turns.
 * @type {(spin: number) => string}
 */
export const turns = (spin) => `${(spin / (2 * Math.PI)).toFixed(1)} turns/s`;

export class Chart {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {string} title
   */
  constructor(canvas, title) {
    this.canvas = canvas;
    this.title = title;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    /** The size of the letters, of 11 pixels. */
    this.scale = 1;
    this.left = 0;
    this.right = 1;
    this.top = 0;
    this.bottom = 1;
    this.low = [0, 0];
    this.high = [1, 1];
    /** @type {any[]} what `copy` shows */
    this.known = [];
    /** @type {HTMLCanvasElement | undefined} */
    this.copy = undefined;
  }

  /**
   * Empties it, with these ranges and this caption at the right of the title.
   * @param {[number, number]} x
   * @param {[number, number]} y
   * @param {Palette} colours
   * @param {string} caption
   */
  begin(x, y, colours, caption = "") {
    const { canvas, context } = this;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
      canvas.width = Math.round(w * ratio);
      canvas.height = Math.round(h * ratio);
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, w, h);
    const { font, fontSize } = getComputedStyle(canvas);
    const scale = parseFloat(fontSize) / 11;
    this.scale = scale;
    [this.left, this.right] = [MARGIN.left * scale, w - MARGIN.right * scale];
    [this.top, this.bottom] = [MARGIN.top * scale, h - MARGIN.bottom * scale];
    this.low = [x[0], y[0]];
    this.high = [x[1], y[1]];
    context.fillStyle = colours.ink;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.font = `600 ${font}`;
    context.fillText(this.title, this.left, 13 * scale);
    const wide = context.measureText(this.title).width;
    context.font = font;
    context.fillStyle = colours.quiet;
    context.textAlign = "right";
    if (this.left + wide + 14 + context.measureText(caption).width < this.right)
      context.fillText(caption, this.right, 13 * scale);
  }

  /** @param {number} value */
  x(value) {
    return this.left + ((value - this.low[0]) / (this.high[0] - this.low[0])) * (this.right - this.left);
  }

  /** @param {number} value */
  y(value) {
    return this.bottom - ((value - this.low[1]) / (this.high[1] - this.low[1])) * (this.bottom - this.top);
  }

  /**
   * The value of x at a place of the canvas.
   * @param {number} place
   */
  value(place) {
    const s = Math.min(1, Math.max(0, (place - this.left) / (this.right - this.left)));
    return this.low[0] + s * (this.high[0] - this.low[0]);
  }

  /**
   * Grid, numbers and the words below.
   * @param {Palette} colours
   * @param {[number, string][]} xs
   * @param {[number, string][]} ys
   * @param {boolean} grid whether there are lines across
   */
  axes(colours, xs, ys, grid = true) {
    const { context } = this;
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    context.fillStyle = colours.quiet;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const [value, text] of ys) {
      const y = Math.round(this.y(value)) + 0.5;
      if (y < this.top - 1 || y > this.bottom + 1) continue;
      if (grid) this.stroke(this.left, y, this.right, y);
      context.fillText(text, this.left - 6, y);
    }
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const [value, text] of xs) {
      const x = this.x(value);
      if (x < this.left - 1 || x > this.right + 1) continue;
      const wide = context.measureText(text).width / 2;
      const last = this.right + MARGIN.right * this.scale - 2 - wide;
      context.fillText(text, Math.min(x, last), this.bottom + 7);
      this.stroke(Math.round(x) + 0.5, this.bottom, Math.round(x) + 0.5, this.bottom + 4);
    }
    this.stroke(this.left, this.bottom + 0.5, this.right, this.bottom + 0.5);
  }

  /**
   * Numbers along x for times.
   * @returns {[number, string][]}
   */
  times() {
    const count = Math.max(2, (this.right - this.left) / (80 * this.scale));
    const xs = ticks(this.low[0], this.high[0], count);
    return xs.map((t, i) => [t, i === xs.length - 1 ? `${tidy(t)} s` : tidy(t)]);
  }

  /**
   * @param {number} x0
   * @param {number} y0
   * @param {number} x1
   * @param {number} y1
   */
  stroke(x0, y0, x1, y1) {
    this.context.beginPath();
    this.context.moveTo(x0, y0);
    this.context.lineTo(x1, y1);
    this.context.stroke();
  }

  /**
   * What `draw` does is cut off at the edges of the plot.
   * @param {() => void} draw
   */
  within(draw) {
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(this.left, this.top - 2, this.right - this.left, this.bottom - this.top + 3);
    context.clip();
    draw();
    context.restore();
  }

  /**
   * Draws the constant parts once and copies them to each picture: a hundred thousand samples would take all the time
   * that there is for a picture.
   * @param {any[] | undefined} key what it depends on, besides the chart; undefined: it is another one each time
   * @param {() => void} draw
   */
  still(key, draw) {
    if (!key) return draw();
    const { canvas, context } = this;
    const known = [...key, canvas.width, canvas.height, context.font, ...this.low, ...this.high];
    this.copy ??= document.createElement("canvas");
    if (known.length !== this.known.length || known.some((part, i) => part !== this.known[i])) {
      Object.assign(this.copy, { width: canvas.width, height: canvas.height });
      this.context = /** @type {CanvasRenderingContext2D} */ (this.copy.getContext("2d"));
      this.context.setTransform(context.getTransform());
      this.context.font = context.font;
      draw();
      this.context = context;
      this.known = known;
    }
    context.save();
    context.resetTransform();
    context.drawImage(this.copy, 0, 0);
    context.restore();
  }

  /**
   * A curve over ascending x; where more points than pixels are, the least and the largest of each pixel are joined.
   * @param {ArrayLike<number>} xs
   * @param {(i: number) => number} value
   * @param {number} from
   * @param {number} to index after the last
   */
  curve(xs, value, from, to) {
    const { context } = this;
    const dense = (to - from) / (this.right - this.left) > 3;
    context.beginPath();
    if (!dense) {
      for (let i = from; i < to; i++) context.lineTo(this.x(xs[i]), this.y(value(i)));
      context.stroke();
      return;
    }
    let column = -1e9;
    let [low, high] = [Infinity, -Infinity];
    const put = () => {
      if (!isFinite(low)) return;
      context.lineTo(column, this.y(low));
      context.lineTo(column, this.y(high) - 0.5);
    };
    for (let i = from; i < to; i++) {
      const x = Math.floor(this.x(xs[i]));
      if (x !== column) {
        put();
        [column, low, high] = [x, Infinity, -Infinity];
      }
      const v = value(i);
      if (v < low) low = v;
      if (v > high) high = v;
    }
    put();
    context.stroke();
  }

  /**
   * A filled dot with a ring around it.
   * @param {number} x
   * @param {number} y
   * @param {string} fill
   * @param {string} ring
   * @param {number} radius
   */
  dot(x, y, fill, ring, radius = 4.5) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = ring;
    context.stroke();
  }
}

/**
 * The index of the last entry of an ascending list that is not larger; -1 if there is none.
 * @type {(list: ArrayLike<number>, value: number) => number}
 */
export function before(list, value) {
  let [low, high] = [-1, list.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}

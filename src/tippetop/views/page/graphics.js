/** WebGL2: programs, uniforms by name, ribbons. */

/** @typedef {import("./vector.js").Vector} Vector */

export class Program {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {string} vertex
   * @param {string} fragment
   */
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.program = /** @type {WebGLProgram} */ (gl.createProgram());
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ]) {
      const shader = /** @type {WebGLShader} */ (gl.createShader(/** @type {number} */ (kind)));
      gl.shaderSource(shader, /** @type {string} */ (source));
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) || "shader");
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(this.program) || "program");
    }
    /** @type {Map<string, WebGLUniformLocation | null>} */
    this.places = new Map();
  }

  /**
   * Sets uniforms by name: numbers, vectors, a matrix of three columns, lists of vectors.
   * @param {Record<string, number | number[] | number[][]>} values
   */
  set(values) {
    const { gl } = this;
    gl.useProgram(this.program);
    for (const [name, value] of Object.entries(values)) {
      if (!this.places.has(name)) this.places.set(name, gl.getUniformLocation(this.program, name));
      const place = this.places.get(name) ?? null;
      if (typeof value === "number") gl.uniform1f(place, value);
      else if (Array.isArray(value[0])) {
        const flat = /** @type {number[][]} */ (value).flat();
        if (value.length === 3) gl.uniformMatrix3fv(place, false, flat);
        else gl.uniform3fv(place, flat);
      } else if (value.length === 2) gl.uniform2fv(place, /** @type {number[]} */ (value));
      else gl.uniform3fv(place, /** @type {number[]} */ (value));
    }
  }
}

/** A curve through points, each with its time, as a strip that the vertex shader widens. */
export class Ribbon {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Program} program
   * @param {ArrayLike<number>} points x, y, z of each
   * @param {ArrayLike<number>} times of each
   */
  constructor(gl, program, points, times) {
    this.gl = gl;
    this.times = times;
    const n = times.length;
    const data = new Float32Array(2 * n * 11);
    for (let i = 0; i < n; i++) {
      for (let side = 0; side < 2; side++) {
        const at = (2 * i + side) * 11;
        for (let k = 0; k < 3; k++) {
          data[at + k] = points[3 * Math.max(i - 1, 0) + k];
          data[at + 3 + k] = points[3 * i + k];
          data[at + 6 + k] = points[3 * Math.min(i + 1, n - 1) + k];
        }
        data[at + 9] = 2 * side - 1;
        data[at + 10] = times[i];
      }
    }
    this.vertices = gl.createVertexArray();
    gl.bindVertexArray(this.vertices);
    this.buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    let first = 0;
    for (const [name, count] of /** @type {[string, number][]} */ ([
      ["before", 3],
      ["here", 3],
      ["next", 3],
      ["side", 1],
      ["time", 1],
    ])) {
      const place = gl.getAttribLocation(program.program, name);
      if (place >= 0) {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, count, gl.FLOAT, false, 44, first * 4);
      }
      first += count;
    }
    gl.bindVertexArray(null);
  }

  /**
   * Draws the points from one index up to another, with the program that is set.
   * @param {number} from
   * @param {number} to
   */
  draw(from, to) {
    if (to - from < 2) return;
    this.gl.bindVertexArray(this.vertices);
    this.gl.drawArrays(this.gl.TRIANGLE_STRIP, 2 * from, 2 * (to - from));
    this.gl.bindVertexArray(null);
  }

  /** Frees what it holds. */
  remove() {
    this.gl.deleteBuffer(this.buffer);
    this.gl.deleteVertexArray(this.vertices);
  }
}

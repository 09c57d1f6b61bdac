/** The picture: body, floor, shadow, arrows and traces, drawn by WebGL2 for a pose. */
import { Camera, LENS } from "./camera.js";
import { Program, Ribbon } from "./graphics.js";
import { lowest } from "./motion.js";
import { ARROWS, rgb } from "./palette.js";
import { INK, RAYS, RIBBON, SCREEN } from "./shaders.js";
import { axes } from "./rotation.js";
import { UNITS, along, dot, length, minus, plus, times } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./motion.js").Pose} Pose */
/** @typedef {import("./palette.js").Palette} Palette */

/** @typedef {{centre: Vector, half: Vector}} Surface centre from the centre of mass, and half axes [m] */

/**
 * @typedef {object} Body
 * @property {"ball" | "heavy" | "cylinder" | "lathe"} kind
 * @property {number} unit the length that is 1 in the picture [m]
 * @property {Vector[]} axes of the surfaces, in axes of the body
 * @property {Surface[]} surfaces what may touch the plane, the stem last
 * @property {Vector[]} meridian of a lathe, in units of its half axes: height, radius, inclination of the normal
 * @property {Vector | []} ellipsoid half axes of a heavy top [m]
 * @property {number} weight [N]
 * @property {boolean} fixed whether its tip is fixed
 * @property {boolean} asymmetric whether it has no axis of symmetry
 */

const KINDS = { ball: 0, heavy: 1, cylinder: 2, lathe: 3 };
const [NEAR, FAR] = [0.5, 60];
/** Longest arrows, in units; a force of the weight has length 1. */
const LONGEST = /** @type {Record<string, number>} */ ({ momentum: 2.1, omega: 2.5, slip: 1.3 });
/** A sliding velocity as long as the longest arrow is at least this part of the fastest omega R: less is rounding noise. */
const SLIDES = 1e-3;
const ON_BALL = 1.5; // seconds that the trace on the ball stays
const AIMED = 2000; // samples that the camera is set up by

export class Scene {
  /**
   * @param {HTMLCanvasElement} canvas
   */
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true, alpha: false });
    /** null: this browser does not offer WebGL2, and the body is not drawn */
    this.gl = gl;
    /** @type {Map<string, Program>} */
    this.programs = new Map();
    this.ribbons = gl && new Program(gl, RIBBON, INK);
    this.screen = gl && triangle(gl);
    this.camera = new Camera();
    /** The optional parts of the picture. */
    this.shown = /** @type {Record<string, boolean>} */ ({
      momentum: true,
      omega: true,
      force: true,
      slip: true,
      trace: true,
      mass: false,
    });
    /** How carefully a picture is drawn: rays along the side of a pixel, and pixels for one of the page. */
    this.quality = { side: 1, pixels: 1 };
    /** @type {Body | undefined} */
    this.body = undefined;
    /** @type {Motion | undefined} */
    this.motion = undefined;
    /** @type {Record<string, number>} units of the picture for one unit of the arrow */
    this.scales = {};
    /** @type {Ribbon | undefined} */
    this.floor = undefined;
    /** @type {Ribbon | undefined} */
    this.skin = undefined;
    /** @type {(t: number) => number} */
    this.ballAt = () => 0;
    /** Whether the traces are still to be made. */
    this.untraced = false;
    this.width = 0;
    this.height = 0;
  }

  /**
   * Takes a body and its motion.
   * @param {Body} body
   * @param {Motion} motion
   * @param {(t: number) => number} ballAt which ball touches the plane, or did last
   * @param {boolean} keep whether the camera stays where it is
   */
  take(body, motion, ballAt, keep = false) {
    this.body = body;
    this.motion = motion;
    this.ballAt = ballAt;
    const n = motion.times.length;
    this.scales = { force: 1 / body.weight };
    for (const name of ["momentum", "omega", "slip"]) {
      const least = name === "slip" ? SLIDES * motion.longest("omega") * body.unit : 0;
      const most = Math.max(motion.longest(name), least);
      this.scales[name] = most > 0 ? LONGEST[name] / most : 0;
    }
    this.floor?.remove();
    this.skin?.remove();
    this.floor = this.skin = undefined;
    this.untraced = true;
    if (keep) return;
    const last = Math.min(n, AIMED) - 1;
    const rows = Array.from({ length: last + 1 }, (_, i) => Math.round((i * (n - 1)) / (last || 1)));
    const path = rows.map((i) => this.touched(i).floor);
    const high = rows.reduce((sum, i) => sum + motion.at(i, "position")[2], 0) / rows.length / body.unit;
    const [x, y] = [0, 1].map((i) => path.reduce((sum, at) => sum + at[i], 0) / path.length);
    const wide = Math.max(...path.map((at) => Math.hypot(at[0] - x, at[1] - y)));
    this.camera.home = [x, y, body.kind === "heavy" ? 0.85 : Math.min(0.95, 2 * high)];
    this.camera.distance = Math.min(12, Math.max(body.kind === "heavy" ? 8.4 : 6.6, 5.8 + 1.3 * wide));
    if (wide > 3) this.camera.mode = "follow";
  }

  /**
   * The axes of the surfaces in space.
   * @param {import("./vector.js").Quaternion} q
   */
  frame(q) {
    const turned = axes(q);
    return /** @type {Body} */ (this.body).axes.map((axis) => along(turned, axis));
  }

  /**
   * Where the body touches the plane at a sample, in units of the picture: on the floor, and on its surface, from the
   * centre of mass in axes of the surfaces.
   * @param {number} i
   */
  touched(i) {
    const body = /** @type {Body} */ (this.body);
    const motion = /** @type {Motion} */ (this.motion);
    const k = 1 / body.unit;
    const frame = this.frame(motion.at(i, "orientation"));
    const surface = body.surfaces[this.ballAt(motion.times[i])];
    const p = lowest(frame, surface, body.meridian);
    const at = plus(motion.at(i, "position"), along(frame, p));
    const out = plus(surface.centre, times(1.006, minus(p, surface.centre)));
    return { floor: [at[0] * k, at[1] * k, 0.004], skin: times(k, out) };
  }

  /** Makes the traces of the contact point, of all samples: the first picture does without them. */
  trace() {
    const { gl, ribbons, body, motion } = this;
    this.untraced = false;
    if (!gl || !ribbons || !body || !motion) return;
    const n = motion.times.length;
    const floor = new Float32Array(3 * n);
    const skin = new Float32Array(3 * n);
    for (let i = 0; i < n; i++) {
      const touched = this.touched(i);
      floor.set(touched.floor, 3 * i);
      skin.set(touched.skin, 3 * i);
    }
    const moves = body.kind !== "heavy" || !body.fixed;
    this.floor = moves ? new Ribbon(gl, ribbons, floor, motion.times) : undefined;
    this.skin = KINDS[body.kind] % 3 === 0 ? new Ribbon(gl, ribbons, skin, motion.times) : undefined;
  }

  /**
   * The program that casts the rays, made when it is first wanted.
   * @param {WebGL2RenderingContext} gl
   * @param {number} kind
   */
  rays(gl, kind) {
    const key = [kind, this.quality.side, this.shown.mass ? 1 : 0];
    const known = this.programs.get(key.join());
    if (known) return known;
    const made = new Program(gl, SCREEN, RAYS(key[0], key[1], key[2]));
    this.programs.set(key.join(), made);
    return made;
  }

  /**
   * Seconds that a function takes until the graphics card has drawn what it asked for.
   * @param {() => void} work
   */
  timed(work) {
    const { gl } = this;
    const began = performance.now();
    work();
    gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return (performance.now() - began) / 1e3;
  }

  /** Fits the canvas to its place on the page. */
  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * this.quality.pixels;
    const { clientWidth, clientHeight } = this.canvas;
    const [w, h] = [Math.max(1, Math.round(clientWidth * ratio)), Math.max(1, Math.round(clientHeight * ratio))];
    if (w !== this.canvas.width || h !== this.canvas.height) [this.canvas.width, this.canvas.height] = [w, h];
    [this.width, this.height] = [w, h];
  }

  /**
   * The arrows of a pose: where each starts and what it is in the picture, and its size in its own unit.
   * @param {Pose} pose
   */
  arrows(pose) {
    const body = /** @type {Body} */ (this.body);
    const k = 1 / body.unit;
    const frame = this.frame(pose.orientation);
    const surface = body.surfaces[this.ballAt(pose.time)];
    const centre = times(k, pose.position);
    const contact = plus(centre, times(k, along(frame, lowest(frame, surface, body.meridian))));
    return ARROWS.map(([name]) => {
      const vector = /** @type {Vector} */ (pose[/** @type {"omega"} */ (name)]);
      const drawn = times(this.shown[name] ? this.scales[name] : 0, vector);
      const start = name === "force" || name === "slip" ? contact : centre;
      return { name, start: name === "slip" ? plus(start, [0, 0, 0.03]) : start, drawn, size: length(vector) };
    });
  }

  /**
   * Draws a pose.
   * @param {Pose} pose
   * @param {Palette} colours
   * @param {{dark: boolean, turned: number, passed: number}} how `turned`: angle of the spin during one picture [rad];
   * `passed`: time since the last [s], infinite after a jump
   */
  draw(pose, colours, how) {
    const { gl, body, motion } = this;
    if (!body || !motion) return;
    this.resize();
    const k = 1 / body.unit;
    const turned = this.frame(pose.orientation);
    const centre = times(k, pose.position);
    const [{ centre: offset, half }, stem] = body.surfaces;
    const heavy = body.kind === "heavy";
    const middle = heavy ? centre : plus(centre, times(k, along(turned, offset)));
    const looked = body.kind === "cylinder" ? centre : middle;
    this.camera.follow([looked[0], looked[1], this.camera.home[2]], how.passed);
    if (!gl || gl.isContextLost()) return;
    const rays = this.rays(gl, KINDS[body.kind]);
    const view = this.camera.frame();
    const lens = LENS * Math.max(1, 0.8 * (this.height / this.width));
    const size = [this.width, this.height];
    const arrows = this.arrows(pose);
    const light = how.dark ? [0.5, 0.3, 0.82] : [0.42, 0.3, 0.86];
    gl.viewport(0, 0, this.width, this.height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.ALWAYS);
    gl.disable(gl.BLEND);
    if (body.kind === "lathe") rays.set({ meridian: body.meridian });
    rays.set({
      size,
      ...view,
      lens,
      near: NEAR,
      far: FAR,
      centre,
      middle: [this.camera.target[0], this.camera.target[1], 0],
      body: turned,
      surface: middle,
      halves: times(k, /** @type {Vector} */ (heavy ? body.ellipsoid : half)),
      stemRadius: stem ? stem.half[0] * k : 0,
      stemHeight: stem ? (stem.centre[2] - offset[2]) * k : 0,
      spinBlur: Math.max(how.turned, 1e-3),
      grid: 0.01 * k > 0.2 ? 0.01 * k : 0.1 * k,
      dark: how.dark ? 1 : 0,
      lightDirection: times(1 / Math.hypot(...light), /** @type {Vector} */ (light)),
      arrowStart: arrows.map((a) => a.start),
      arrowVector: arrows.map((a) => a.drawn),
      arrowColour: ARROWS.map(([, colour]) => rgb(colour)),
      skyColour: rgb(colours.sky),
      floorColour: rgb(colours.floor),
      lineColour: rgb(colours.grid),
      heavyColour: rgb("#27527f"),
      lightColour: rgb("#eadfca"),
      markColour: rgb("#e4572e"),
      stemColour: rgb("#3a424d"),
    });
    gl.bindVertexArray(this.screen);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (this.shown.trace) this.traces(gl, pose, { view, lens, size, turned, centre, dark: how.dark });
  }

  /**
   * Draws the traces of the contact point.
   * @param {WebGL2RenderingContext} gl
   * @param {Pose} pose
   * @param {any} how
   */
  traces(gl, pose, how) {
    const { motion, ribbons } = this;
    if (!motion || !ribbons) return;
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const to = motion.index(pose.time) + 1;
    const common = { size: how.size, ...how.view, lens: how.lens, near: NEAR, far: FAR, now: pose.time };
    ribbons.set({
      ...common,
      turn: UNITS,
      shift: [0, 0, 0],
      width: 0.0042 * this.height,
      memory: motion.end - motion.start || 1,
      faint: 0.3,
      towards: 0.0006,
      ink: how.dark ? [0.5, 0.76, 1] : [0.1, 0.32, 0.6],
    });
    this.floor?.draw(0, to);
    ribbons.set({
      turn: how.turned,
      shift: how.centre,
      memory: ON_BALL,
      faint: 0,
      towards: 0.0004,
      ink: [0.95, 0.62, 0.1],
    });
    this.skin?.draw(motion.index(pose.time - ON_BALL), to);
  }

  /**
   * Where a point of the picture is on the canvas, in its pixels; undefined behind the eye.
   * @param {Vector} p
   * @returns {[number, number] | undefined}
   */
  project(p) {
    const { eye, right, up, ahead } = this.camera.frame();
    /** @type {Vector} */
    const q = [p[0] - eye[0], p[1] - eye[1], p[2] - eye[2]];
    const z = dot(q, ahead);
    if (z <= 0) return undefined;
    const lens = LENS * Math.max(1, 0.8 * (this.height / this.width));
    const k = this.height / (2 * lens * z);
    return [this.width / 2 + k * dot(q, right), this.height / 2 - k * dot(q, up)];
  }
}

/**
 * One triangle that covers the picture.
 * @param {WebGL2RenderingContext} gl
 */
function triangle(gl) {
  const screen = gl.createVertexArray();
  gl.bindVertexArray(screen);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  return screen;
}

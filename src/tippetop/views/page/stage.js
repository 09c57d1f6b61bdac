/** A motion on the page: picture, plots, controls and keyboard, all at one time. */
import { Clock, SPEEDS, speedText } from "./clock.js";
import { AxisPanel } from "./axis.js";
import { turns } from "./chart.js";
import { keyboard, pointer } from "./gestures.js";
import { ForcePanel, ThetaPanel } from "./panels.js";
import { Key, named } from "./key.js";
import { TimeLine } from "./timeline.js";
import { WellPanel } from "./well.js";
import { ARROWS, palette } from "./palette.js";
import { part } from "./part.js";
import { Recorder } from "./recorder.js";
import { Scene } from "./scene.js";
import { axes } from "./rotation.js";
import { dot } from "./vector.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./log.js").Log} Log */
/** @typedef {import("./scene.js").Body} Body */

/**
 * @typedef {object} Shown
 * @property {Body} body
 * @property {Motion} motion
 * @property {Log} log
 * @property {((z: number, first: number, second: number) => number) | undefined} potential
 * @property {boolean} wound
 */

const NEAR = 8; // seconds of watching that the plots show at low speeds
/** How pictures are drawn in motion, from the most beautiful to the fastest. */
const QUALITIES = [
  { side: 2, pixels: 1 },
  { side: 1, pixels: 1 },
  { side: 1, pixels: 0.6 },
  { side: 1, pixels: 0.35 },
];
const SLOW = [0.006, 0.03, 0.09]; // seconds of a picture with one ray for a pixel, above which the next one is taken
const PATIENCE = 0.6; // seconds that a picture of a motion that rests may take

export class Stage {
  /** @param {string} name of a recorded film */
  constructor(name) {
    this.clock = new Clock();
    this.scene = new Scene(part("scene"));
    this.theta = new ThetaPanel(part("theta"));
    this.force = new ForcePanel(part("force"));
    this.axis = new AxisPanel(part("axis"));
    this.line = new TimeLine(part("line"));
    this.key = new Key(part("key"));
    this.recorder = new Recorder(part("scene"), name);
    /** @type {WellPanel | undefined} */
    this.well = undefined;
    /** @type {Shown | undefined} */
    this.shown = undefined;
    this.near = false;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.dirty = true;
    this.printing = false;
    /** Whether the page has had a frame of its own: the first must not wait for traces. */
    this.framed = false;
    this.frames = { count: 0, seconds: 0, one: 0 };
    this.quality = 1;
    this.rested = 0;
    this.controls();
    keyboard(this);
    pointer(this);
    part("flat").hidden = !!this.scene.gl;
    part("scene").addEventListener("webglcontextlost", () => (part("flat").hidden = false));
    addEventListener("beforeprint", () => this.print(true));
    addEventListener("afterprint", () => this.print(false));
    const again = () => (this.dirty = true);
    new ResizeObserver(again).observe(document.body);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
    requestAnimationFrame((now) => this.frame(now));
  }

  get dark() {
    if (this.printing) return false;
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  }

  /**
   * Shows a motion.
   * @param {Shown} shown
   * @param {boolean} keep whether the camera stays
   */
  take(shown, keep = false) {
    this.shown = shown;
    const { body, motion, log } = shown;
    this.clock.take(motion.start, motion.end);
    this.scene.take(body, motion, (t) => (body.surfaces[1] && log.phase(t)?.ball === "stem" ? 1 : 0), keep);
    if (!keep) part("camera").value = this.scene.camera.mode;
    const { potential } = shown;
    part("well-figure").hidden = !potential;
    part("force-figure").hidden = !isFinite(log.forces[0]);
    if (potential) {
      this.well = new WellPanel(part("well"), potential);
      this.well.take(motion, (t) => log.touches(t));
    } else this.well = undefined;
    part("scrub").min = String(motion.start);
    part("scrub").max = String(motion.end);
    part("scrub").step = String((motion.end - motion.start) / 1e6 || 1e-9);
    if (!this.frames.one) this.measure();
    this.dirty = true;
  }

  /** Finds out how fast this computer draws: on few pixels first, for some draw without a graphics card. */
  measure() {
    const few = QUALITIES[QUALITIES.length - 1];
    this.scene.quality = few;
    this.scene.timed(() => this.draw(0)); // compiles
    this.frames.one = this.scene.timed(() => this.draw(0)) / few.pixels ** 2;
    if (this.frames.one < SLOW[1]) {
      this.scene.quality = QUALITIES[1];
      this.frames.one = this.scene.timed(() => this.draw(0));
    }
    this.quality = SLOW.filter((limit) => this.frames.one > limit).length;
  }

  /** @param {boolean} printing on paper, which is white */
  print(printing) {
    this.printing = printing;
    this.draw(0);
  }

  /** @param {number} time */
  set(time) {
    this.clock.set(time);
    this.dirty = true;
  }

  /** @param {boolean} playing */
  play(playing) {
    this.clock.play(playing);
    this.dirty = true;
  }

  /** @param {number} speed */
  pace(speed) {
    this.clock.speed = speed;
    part("speed").value = String(speed);
    this.near = speed < 0.15;
    part("near").setAttribute("aria-pressed", String(this.near));
    this.dirty = true;
  }

  /**
   * To the next event, or back to the last.
   * @param {boolean} forwards
   * @param {boolean} all
   */
  step(forwards, all) {
    const found = this.shown?.log.next(this.clock.time, forwards, all);
    this.play(false);
    if (!found) return;
    this.set(found.time);
    part("said").textContent = found.text;
  }

  controls() {
    for (const speed of SPEEDS) part("speed").add(new Option(speedText(speed), String(speed)));
    /** @type {Record<string, () => void>} */
    const buttons = {
      play: () => this.play(!this.clock.playing),
      back: () => this.step(false, true),
      forward: () => this.step(true, true),
      near: () => {
        this.near = !this.near;
        part("near").setAttribute("aria-pressed", String(this.near));
        this.dirty = true;
      },
      theme: () => {
        document.documentElement.dataset.theme = this.dark ? "light" : "dark";
        this.dirty = true;
      },
      record: () => this.record(),
      full: () => {
        if (document.fullscreenElement) document.exitFullscreen();
        else document.documentElement.requestFullscreen();
      },
    };
    for (const [name, action] of Object.entries(buttons)) part(name).addEventListener("click", action);
    part("record").hidden = !this.scene.gl || !this.recorder.possible;
    part("full").hidden = !document.fullscreenEnabled;
    part("speed").addEventListener("change", () => this.pace(Number(part("speed").value)));
    part("scrub").addEventListener("input", () => this.set(Number(part("scrub").value)));
    part("camera").addEventListener("change", () => this.look(part("camera").value));
    for (const [name, colour, words] of ARROWS) this.toggle(name, words, colour);
    this.toggle("trace", "trace", "#5b7ea4");
    this.toggle("mass", "centre of mass", "#e4572e");
    this.pace(this.calm ? 0.1 : 1);
  }

  /**
   * A button that shows or hides something in the picture.
   * @param {string} name
   * @param {string} words
   * @param {string} colour
   */
  toggle(name, words, colour) {
    const button = document.createElement("button");
    button.className = "toggle";
    button.dataset.part = `show-${name}`;
    button.style.setProperty("--colour", colour);
    button.textContent = words;
    const press = () => button.setAttribute("aria-pressed", String(this.scene.shown[name]));
    button.addEventListener("click", () => {
      this.scene.shown[name] = !this.scene.shown[name];
      press();
      this.dirty = true;
    });
    press();
    part("toggles").append(button);
  }

  /** @param {string} mode */
  look(mode) {
    this.scene.camera.mode = mode;
    part("camera").value = mode;
    this.clock.jumped = true;
    this.dirty = true;
  }

  record() {
    if (this.recorder.recording) this.recorder.stop();
    else {
      this.recorder.start();
      this.play(true);
    }
    part("record").setAttribute("aria-pressed", String(this.recorder.recording));
    part("record").textContent = this.recorder.recording ? "■ save" : "● film";
  }

  /** @param {number} steps */
  hasten(steps) {
    this.clock.faster(steps);
    this.pace(this.clock.speed);
  }

  /** @param {number} steps of a sixtieth of a second of watching */
  nudge(steps) {
    this.play(false);
    this.set(this.clock.time + (steps * this.clock.speed) / 60);
  }

  /** The stretch of time that the plots show. @returns {[number, number]} */
  window() {
    const { start, end, time, speed } = this.clock;
    const wide = NEAR * Math.min(speed, 1);
    if (!this.near || wide >= end - start) return [start, end > start ? end : start + 1e-3];
    const first = Math.min(Math.max(time - wide / 2, start), end - wide);
    return [first, first + wide];
  }

  /** @param {number} now */
  frame(now) {
    const step = this.clock.tick(now);
    if (this.scene.untraced && this.framed) {
      this.scene.trace();
      this.dirty = true;
    }
    this.framed = true;
    const moves = this.clock.playing || step > 0 || this.dirty;
    this.rested = moves ? 0 : this.rested + 1;
    if (moves) this.scene.quality = QUALITIES[this.quality];
    if (moves) this.draw(step);
    else if (this.rested === 12 && this.quality) this.rest();
    requestAnimationFrame((later) => this.frame(later));
  }

  /** Draws a motion that rests once more, as carefully as this computer can in a moment. */
  rest() {
    const cost = this.frames.one;
    this.scene.quality = QUALITIES[4 * cost < PATIENCE ? 0 : cost < PATIENCE ? 1 : Math.min(this.quality, 2)];
    this.draw(0);
  }

  /**
   * Draws everything.
   * @param {number} step how far the motion went since the last picture [s]
   */
  draw(step) {
    if (!this.shown || !this.scene.canvas.clientWidth) return;
    const began = performance.now();
    const { body, motion, log, wound } = this.shown;
    const colours = palette(this.dark);
    const time = this.clock.time;
    const pose = motion.pose(time);
    const about = axes(pose.orientation)[body.kind === "cylinder" ? 1 : 2];
    const spin = body.asymmetric ? pose.omega[2] : Math.abs(dot(pose.omega, about));
    this.dirty = false;
    const passed = this.clock.jumped ? Infinity : this.clock.passed;
    this.scene.draw(pose, colours, { dark: this.dark, turned: Math.min(Math.abs(spin) * step, 6.2), passed });
    this.clock.jumped = false;
    const span = this.window();
    this.theta.draw(motion, log, pose, span, colours);
    if (isFinite(log.forces[0])) this.force.draw(motion, log, pose, span, colours, body.weight);
    this.well?.draw(pose, colours, wound, isFinite(pose.well[2]) && log.touches(time));
    if (body.kind !== "cylinder") {
      this.axis.draw(motion, pose, this.scene.camera.frame(), colours, Math.max(2, (motion.end - motion.start) / 4));
    }
    this.line.draw(log, time, [motion.start, motion.end], span, colours);
    this.key.draw(log, [motion.start, motion.end], colours);
    this.say(time, log, body.asymmetric ? "ω_z" : log.wound ? "θ′" : "ω₃", spin);
    this.frames.count += 1;
    this.frames.seconds += (performance.now() - began) / 1e3;
  }

  /**
   * Writes the numbers.
   * @param {number} time
   * @param {Log} log
   * @param {string} name
   * @param {number} spin
   */
  say(time, log, name, spin) {
    part("time").textContent = `${time.toFixed(4)} s`;
    part("spin-name").textContent = name;
    part("spin").textContent = `${spin.toFixed(1)} rad/s`;
    part("turns").textContent = turns(spin);
    const phase = log.phase(time);
    part("phase").textContent = phase ? named(phase) : "";
    const scrub = part("scrub");
    if (document.activeElement !== scrub || this.clock.playing) scrub.value = String(time);
    scrub.setAttribute("aria-valuetext", `${time.toFixed(3)} seconds`);
    const play = part("play");
    play.textContent = this.clock.playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", this.clock.playing ? "pause" : "play");
  }
}

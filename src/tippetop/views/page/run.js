/** The page of a run: what was computed before is decoded, and shown. */
import { potential } from "./formulas.js";
import { Log } from "./log.js";
import { Motion } from "./motion.js";
import { part } from "./part.js";
import { Stage } from "./stage.js";

/**
 * Numbers that stand in the page as base64, little-endian.
 * @type {(text: string, kind: "f8" | "f4") => any}
 */
export function numbers(text, kind) {
  const decode = /** @type {any} */ (Uint8Array).fromBase64; // new in browsers, and ten times as fast
  if (decode) return typed(decode.call(Uint8Array, text), kind);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i); // twenty times as fast as Uint8Array.from
  return typed(bytes, kind);
}

/** @type {(bytes: Uint8Array, kind: "f8" | "f4") => any} */
const typed = (bytes, kind) => (kind === "f8" ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer));

/** @param {any} data what Python wrote */
export function show(data) {
  const motion = new Motion(numbers(data.times, "f8"), numbers(data.samples, "f4"), data.wound);
  const log = new Log(data.events, data.phases, motion, data.wound);
  const stage = new Stage(data.name);
  stage.take({ body: data.body, motion, log, potential: potential ?? undefined, wound: data.wound });
  part("title").textContent = data.title;
  part("about").textContent = data.about;
  for (const sentence of data.notes) {
    const note = document.createElement("p");
    note.textContent = sentence;
    part("notes").append(note);
  }
  return stage;
}

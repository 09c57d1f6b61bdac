/** Begins the playground. */
import { handle } from "./handle.js";
import { Playground } from "./playground.js";
import { simulated, thetas } from "./simulation.js";
import { Stage } from "./stage.js";

const text = /** @type {HTMLElement} */ (document.getElementById("data")).textContent || "{}";
const stage = new Stage("tippe-top");
const playground = new Playground(stage, JSON.parse(text).presets);
if (!stage.calm) stage.play(true);
/** @type {any} */ (window).tippetop = Object.assign(handle(stage), { playground, simulated, thetas });

/** Begins the page of a sweep. */
import { handle } from "./handle.js";
import { Stage } from "./stage.js";
import { SweepPage } from "./sweep.js";

const text = /** @type {HTMLElement} */ (document.getElementById("data")).textContent || "{}";
const stage = new Stage("top");
const data = JSON.parse(text);
const sweep = new SweepPage(data, stage);
document.body.classList.toggle("still", !data.given);
for (const sentence of data.notes) {
  const note = Object.assign(document.createElement("p"), { textContent: sentence });
  document.querySelector("[data-part=notes]")?.append(note);
}
/** @type {any} */ (window).tippetop = Object.assign(handle(stage), { sweep });

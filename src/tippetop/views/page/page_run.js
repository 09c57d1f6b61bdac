/** Begins the page of a run. */
import { handle } from "./handle.js";
import { show } from "./run.js";

const text = /** @type {HTMLElement} */ (document.getElementById("data")).textContent || "{}";
/** @type {any} */ (window).tippetop = handle(show(JSON.parse(text)));

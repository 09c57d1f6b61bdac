/** Begins the page of a run. */
import { handle } from "./handle.js";
import { begin } from "./part.js";
import { show } from "./run.js";

begin((data) => handle(show(data)));

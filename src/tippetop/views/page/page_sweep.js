/** Begins the page of a sweep. */
import { handle } from "./handle.js";
import { begin, part } from "./part.js";
import { Stage } from "./stage.js";
import { SweepPage } from "./sweep.js";

begin((data) => {
  const stage = new Stage("top");
  const sweep = new SweepPage(data, stage);
  document.body.classList.toggle("still", !data.given);
  for (const sentence of data.notes) {
    const note = Object.assign(document.createElement("p"), { textContent: sentence });
    part("notes").append(note);
  }
  return Object.assign(handle(stage), { sweep });
});

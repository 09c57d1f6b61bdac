/** Begins the playground. */
import { handle } from "./handle.js";
import { begin } from "./part.js";
import { Playground } from "./playground.js";
import { followed, refusal } from "./simulation.js";
import { Stage } from "./stage.js";

begin((data) => {
  const stage = new Stage("tippe-top");
  const playground = new Playground(stage, data.presets);
  if (!stage.calm) stage.play(true);
  return Object.assign(handle(stage), { playground, followed, refusal });
});

/** What keys and pointers do to a motion on the page. */
import { part } from "./part.js";

/** @typedef {import("./stage.js").Stage} Stage */

/**
 * Keys, as the help of the page lists them.
 * @param {Stage} stage
 */
export function keyboard(stage) {
  /** @type {Record<string, (event: KeyboardEvent) => void>} */
  const keys = {
    " ": () => stage.play(!stage.clock.playing),
    ArrowRight: (event) => stage.nudge(event.shiftKey ? 10 : 1),
    ArrowLeft: (event) => stage.nudge(event.shiftKey ? -10 : -1),
    ".": () => stage.step(true, true),
    ",": () => stage.step(false, true),
    ">": () => stage.step(true, false),
    "<": () => stage.step(false, false),
    "+": () => stage.hasten(1),
    "-": () => stage.hasten(-1),
    Home: () => stage.set(stage.clock.start),
    End: () => stage.set(stage.clock.end),
    o: () => stage.look("orbit"),
    f: () => stage.look("follow"),
    a: () => stage.look("above"),
    m: () => part("show-mass").click(),
    z: () => part("near").click(),
    d: () => part("theme").click(),
    l: () => part("full").click(),
    "?": () => part("help").toggleAttribute("open"),
  };
  document.addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    const typing = ["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(target.tagName);
    if (
      event.ctrlKey ||
      event.metaKey ||
      event.altKey ||
      (typing && (event.key === " " || event.key.startsWith("Arrow")))
    )
      return;
    if (target.matches("select, [inputmode]")) return;
    const action = keys[event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}

/**
 * Dragging and the wheel turn and near the camera; the plots over time set the time.
 * @param {Stage} stage
 */
export function pointer(stage) {
  const canvas = part("scene");
  /** @type {Map<number, PointerEvent>} */
  const down = new Map();
  canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    down.set(event.pointerId, event);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    if (down.size === 1) {
      const scrolls = event.pointerType === "touch";
      stage.scene.camera.drag(event.clientX - last.clientX, scrolls ? 0 : event.clientY - last.clientY);
    } else {
      const other = [...down.values()].find((e) => e.pointerId !== event.pointerId);
      if (other) {
        const apart = (/** @type {PointerEvent} */ e) =>
          Math.hypot(e.clientX - other.clientX, e.clientY - other.clientY);
        stage.scene.camera.zoom((apart(last) + 1) / (apart(event) + 1));
      }
    }
    down.set(event.pointerId, event);
    part("camera").value = stage.scene.camera.mode;
    stage.dirty = true;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (/** @type {PointerEvent} */ event) => down.delete(event.pointerId));
  }
  canvas.addEventListener(
    "wheel",
    (/** @type {WheelEvent} */ event) => {
      event.preventDefault();
      stage.scene.camera.zoom(Math.exp(0.0012 * event.deltaY));
      stage.dirty = true;
    },
    { passive: false },
  );
  for (const chart of [stage.theta.chart, stage.force.chart, stage.line.chart]) {
    const place = (/** @type {PointerEvent} */ event) => {
      stage.play(false);
      stage.set(chart.value(event.clientX - chart.canvas.getBoundingClientRect().left));
    };
    /** @type {PointerEvent | undefined} */
    let from;
    chart.canvas.addEventListener("pointerdown", (event) => (from = event));
    chart.canvas.addEventListener("click", place);
    chart.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 1 || !from) return;
      const [dx, dy] = [event.clientX - from.clientX, event.clientY - from.clientY];
      const scrolls = event.pointerType === "touch" && Math.abs(dy) > Math.abs(dx);
      if (!scrolls) place(event);
    });
  }
}

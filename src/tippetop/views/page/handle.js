/**
 * What a test, or a curious reader in the console, sees of the page: `window.tippetop`.
 *   time, start, end, playing, speed     the clock; set(t), play(), pause() move it
 *   pose(t)                              orientation w x y z, axis, omega, position, force, slip, momentum, theta at t
 *   arrows()                             of the pose drawn: name, start and drawn (units of the picture), size (SI)
 *   scales                               units of the picture for one SI unit of each arrow; force: 1 is the weight
 *   frames                               pictures drawn, and the seconds that this took
 */

/** @param {import("./stage.js").Stage} stage */
export function handle(stage) {
  return {
    ready: true,
    stage,
    get time() {
      return stage.clock.time;
    },
    get start() {
      return stage.clock.start;
    },
    get end() {
      return stage.clock.end;
    },
    get playing() {
      return stage.clock.playing;
    },
    get speed() {
      return stage.clock.speed;
    },
    get scales() {
      return stage.scene.scales;
    },
    get frames() {
      return stage.frames;
    },
    set: (/** @type {number} */ t) => stage.set(t),
    play: () => stage.play(true),
    pause: () => stage.play(false),
    pose: (/** @type {number} */ t) => stage.shown?.motion.pose(t),
    arrows: () => (stage.shown ? stage.scene.arrows(stage.shown.motion.pose(stage.clock.time)) : []),
    draw: () => stage.draw(0),
  };
}

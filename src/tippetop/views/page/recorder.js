/** Records what the picture shows as a film that the browser saves. */

export class Recorder {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {string} name of the file, without ending
   */
  constructor(canvas, name) {
    this.canvas = canvas;
    this.name = name;
    /** @type {MediaRecorder | undefined} */
    this.recorder = undefined;
  }

  /** Whether this browser can. */
  get possible() {
    return typeof MediaRecorder !== "undefined" && "captureStream" in this.canvas;
  }

  get recording() {
    return this.recorder !== undefined;
  }

  start() {
    const type = ["video/mp4;codecs=avc1", "video/webm;codecs=vp9", "video/webm"].find((t) =>
      MediaRecorder.isTypeSupported(t),
    );
    /** @type {Blob[]} */
    const pieces = [];
    const recorder = new MediaRecorder(this.canvas.captureStream(60), { mimeType: type, videoBitsPerSecond: 12e6 });
    recorder.ondataavailable = (event) => pieces.push(event.data);
    recorder.onstop = () => this.save(new Blob(pieces, { type: recorder.mimeType }));
    recorder.start(500);
    this.recorder = recorder;
  }

  stop() {
    this.recorder?.stop();
    this.recorder = undefined;
  }

  /**
   * Hands a film to the browser as a download.
   * @param {Blob} film
   */
  save(film) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(film);
    link.download = `${this.name}.${film.type.includes("mp4") ? "mp4" : "webm"}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }
}

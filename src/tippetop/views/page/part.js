/** The parts of the page, by name. */

/** @type {(name: string) => any} */
export const part = (name) => {
  const found = document.querySelector(`[data-part="${name}"]`);
  if (!found) throw new Error(`the page has no part ${name}`);
  return found;
};

/**
 * Starts the page with its data as soon as it has a size: a frame in a closed `details` has none.
 * @param {(data: any) => any} start makes `window.tippetop`
 */
export function begin(start) {
  new ResizeObserver((_, observer) => {
    if (!innerWidth) return;
    observer.disconnect();
    const text = /** @type {HTMLElement} */ (document.getElementById("data")).textContent || "{}";
    Object.assign(window, { tippetop: start(JSON.parse(text)) });
  }).observe(document.documentElement);
}

/** The parts of the page, by name. */

/** @type {(name: string) => any} */
export const part = (name) => {
  const found = document.querySelector(`[data-part="${name}"]`);
  if (!found) throw new Error(`the page has no part ${name}`);
  return found;
};

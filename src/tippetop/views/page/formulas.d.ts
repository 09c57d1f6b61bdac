/** What Python writes down from its formulas when a page is made. */

/** The potential V(z; first, second) [J] of the body on the page of a run; null where it has none. */
export const potential: ((z: number, first: number, second: number) => number) | null;

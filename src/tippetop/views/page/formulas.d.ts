/** What Python writes down from its formulas when a page is made. */

/** The potential V(z; first, second) [J] of the body on the page of a run; null where it has none. */
export const potential: ((z: number, first: number, second: number) => number) | null;

/** What the numbers of `formulas` mean, by place. */
export const facts: {
  variables: string[];
  /** how many of the variables move; the others are integrals of them */
  moving: number;
  parameters: string[];
  initial: string[];
  /** the numbers of each friction law, which follow the parameters */
  laws: Record<string, string[]>;
  planar: boolean;
  /** how close to upright or inverted counts as such [rad] */
  near: number;
};

type Numbers = ArrayLike<number>;

/** The formulas of a system under each friction law, SI units. */
export const formulas: Record<
  string,
  {
    /** the numbers of the body that all others take, of parameters and law */
    body: (p: Numbers) => number[];
    /** time derivatives of the variables y, into out */
    rates: (y: Numbers, b: Numbers, out: Float64Array) => void;
    /** the variables at the start, of sin(theta), cos(theta), and the initial numbers d */
    start: (sine: number, z: number, d: Numbers, b: Numbers) => number[];
    /** a usual size of each variable */
    weights: (b: Numbers) => number[];
    /** axes 1 and 3, then the channels of a sample from omega on, into out */
    seen: (y: Numbers, b: Numbers, out: Float64Array) => void;
    /** offset along the axis and radius of the ball that touches the plane, weight, half axes of the ellipsoid */
    sizes: (b: Numbers) => number[];
    thresholds: (b: Numbers) => { name: string; unit: string; words: string; value: number }[];
    potential: ((z: number, first: number, second: number, b: Numbers) => number) | null;
  }
>;

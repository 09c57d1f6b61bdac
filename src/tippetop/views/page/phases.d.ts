/** Formulas of a tippe top in all phases of its contact, written by Python when the playground is made. */

type Numbers = ArrayLike<number>;

export const facts: {
  variables: string[];
  /** how many of the variables control the step; the others are integrals of them */
  moving: number;
  parameters: string[];
  initial: string[];
  /** the numbers of each friction law, which follow the parameters */
  laws: Record<string, string[]>;
  /** the name of each law in a scenario */
  keys: Record<string, string>;
  /** laws under which the contact sticks */
  exact: string[];
  /** the coefficients of each law that Painleve's bound limits */
  bounded: Record<string, string[]>;
  /** how close to upright or inverted counts as such [rad] */
  near: number;
};

/** The formulas under each friction law, SI units; y is the state, b the body seen from one of its balls. */
export const formulas: Record<
  string,
  {
    /** m, R, c, I1, I3, g and the numbers of the law, of parameters and law */
    body: (p: Numbers) => number[];
    /** the state at the start, of sin(theta), cos(theta), and the initial numbers d */
    start: (sine: number, z: number, d: Numbers, b: Numbers) => number[];
    /** time derivatives in flight, into out */
    rates: (y: Numbers, b: Numbers, out: Float64Array) => void;
    /** velocity of the lowest point, and the square of the speed of the edge of the disc */
    point: (y: Numbers, b: Numbers) => number[];
    /** force and torque of a contact that slides, per normal force, in each region of the law */
    frictions: ((y: Numbers, b: Numbers) => number[])[];
    /** the normal force, with force and torque per normal force */
    normal: (y: Numbers, per: Numbers, b: Numbers) => number;
    /** rate of L by a force and a torque at the contact */
    turn: (y: Numbers, by: Numbers, b: Numbers) => number[];
    /** the force on a contact point that stays at rest */
    held: (y: Numbers, b: Numbers) => number[];
    /** the impulse that adds this to the velocity of the lowest point */
    pinned: (y: Numbers, change: Numbers, b: Numbers) => number[];
    /** axes 1 and 3, then the channels of a sample from omega on, into out */
    seen: (y: Numbers, force: Numbers, b: Numbers, out: Float64Array) => void;
    sizes: (b: Numbers) => number[];
    thresholds: (b: Numbers) => { name: string; unit: string; words: string; value: number }[];
    potential: (z: number, first: number, second: number, b: Numbers) => number;
  }
>;

/** Rotations, written down from tippetop.mechanics.rotation when a page is made. */
import type { Quaternion, Vector } from "./vector.js";

/** The three axes of the body in space. */
export const axes: (q: Quaternion) => [Vector, Vector, Vector];

/** 4 q q^t of the body whose axes 1 and 3 are these: each row is its quaternion times a number. */
export const outer: (first: Vector, third: Vector) => Quaternion[];

/** The attitude at the fraction s of an interval of length h between two with their angular velocities. */
export const between: (p: Quaternion, wp: Vector, q: Quaternion, wq: Vector, h: number, s: number) => Quaternion;

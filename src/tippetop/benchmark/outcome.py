"""The outcome of a motion: what a spectator sees."""

import math

import numpy as np

from ..problem import Problem
from .truth import Truth, axis_of, theta_of


TOUCH = 0.01
"""Largest gap of a ball that touches, in radii; a body that lifts off rises by more."""

STICKS = 0.02
"""Sliding speed of a contact that sticks, in sqrt(g R)."""


def outcome(problem: Problem, motion: Truth) -> dict[str, bool]:
    """Return whether a motion turns over, lifts off, sticks at its end and stands on its stem.

    What its columns do not contain is left out.
    """
    theta = theta_of(motion.quaternion)
    result = {"turns over": bool(theta[0] < math.pi / 2 < theta.max())}
    rules, body = problem.contact, problem.body()
    if rules is None or not np.isfinite(motion.position).all():
        return result
    balls = [(body.c, body.R)] + ([(body.c + rules.h, rules.r)] if rules.stem else [])
    axis = axis_of(motion.quaternion)
    gaps = np.array([motion.position[:, 2] + c * axis[:, 2] - R for c, R in balls])
    gap, lowest = gaps.min(axis=0), gaps.argmin(axis=0)
    least, touches = np.minimum.accumulate(gap), gap < TOUCH * body.R
    near = least < 10 * TOUCH * body.R
    result["lifts off"] = bool((gap - least)[near].max(initial=0.0) > TOUCH * body.R)
    if rules.stem:
        result["lands on the stem"] = bool((touches & (lowest == 1)).any())
    moves = np.isfinite(motion.velocity).all() and np.isfinite(motion.omega).all()
    if problem.law.set_valued and moves:
        offset, radius = np.array(balls)[lowest[-1]]
        arm = offset * axis[-1] - [0.0, 0.0, radius]
        slip = motion.velocity[-1] + np.cross(motion.omega[-1], arm)
        slow = math.hypot(slip[0], slip[1]) < STICKS * math.sqrt(body.g * body.R)
        result["sticks"] = bool(touches[-1] and slow)
    return result

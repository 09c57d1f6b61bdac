"""The outcome of a motion, as a spectator would describe it.

A motion goes in, of an engine or the reference; words by which `score` compares both come out.
"""

import math

import numpy as np

from ..exchange.motion import axis_of, theta_of
from ..mechanics.contact.body import size
from ..problem import Problem
from ..runs.shape import lowest
from .truth import Truth


TOUCH = 0.01
"""Largest gap of a ball that touches, in radii; a body that lifts off rises by more."""

RISES = 2.0
"""Largest ratio of the rises of a result and its reference, or its inverse."""

ROUNDED = 1e-6
"""Angle [rad] below pi/2 at which a body that turns over starts: an attitude is rounded."""

STICKS = 0.02
"""Sliding speed of a contact that sticks, in sqrt(g R)."""


def rise(problem: Problem, motion: Truth) -> float:
    """Return the largest rise [m] of the lowest ball after it was on the plane.

    It was there from a gap below ten times TOUCH on: rows may miss the moment of a contact.
    """
    gap = _gaps(motion, _arms(problem, motion)).min(axis=0)
    least = np.minimum.accumulate(gap)
    near = least < 10 * TOUCH * size(problem.body())
    return float((gap - least)[near].max(initial=0.0))


def _arms(problem: Problem, motion: Truth) -> np.ndarray:
    """Return the lowest point of the body, and of its stem, from the centre of mass [m].

    (1 or 2, rows, 3).
    """
    arms = [lowest(motion.quaternion, problem.body())]
    if problem.contact is not None and problem.contact.stem:
        stem = problem.balls["stem"]
        arms.append(stem.c * axis_of(motion.quaternion) - [0.0, 0.0, stem.R])
    return np.array(arms)


def _gaps(motion: Truth, arms: np.ndarray) -> np.ndarray:
    """Return the height of each lowest point above the plane, (1 or 2, rows) [m]; see `_arms`."""
    return motion.position[:, 2] + arms[:, :, 2]


def outcome(problem: Problem, motion: Truth) -> dict[str, bool]:
    """Return whether a motion turns over, lifts off, sticks at its end and stands on its stem.

    Outcomes that need columns which the motion lacks are left out. `case_files.README` has the
    limits TOUCH, RISES and STICKS in words: a change of one is a change of both. The keys are those
    of `case.json` and of its README; `score` compares them with those of the reference.
    """
    theta = theta_of(motion.quaternion)
    result = {"turns over": bool(theta[0] < math.pi / 2 - ROUNDED < math.pi / 2 < theta.max())}
    rules = problem.contact
    body = problem.body()
    if rules is None or not np.isfinite(motion.position).all():
        return result
    arms = _arms(problem, motion)
    gaps = _gaps(motion, arms)
    nearest = gaps.argmin(axis=0)
    touches = gaps.min(axis=0) < TOUCH * size(body)
    result["lifts off"] = bool(rise(problem, motion) > TOUCH * size(body))
    if rules.stem:
        result["lands on the stem"] = bool((touches & (nearest == 1)).any())
    moves = np.isfinite(motion.velocity).all() and np.isfinite(motion.omega).all()
    if problem.law.set_valued and moves:
        # v_A of the ball that is lowest in the last row
        slip = motion.velocity[-1] + np.cross(motion.omega[-1], arms[nearest[-1], -1])
        slow = math.hypot(slip[0], slip[1]) < STICKS * math.sqrt(body.g * size(body))
        result["sticks"] = bool(touches[-1] and slow)
    return result

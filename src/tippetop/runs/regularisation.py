"""How much the regularisation of a Coulomb law decides: the time of inversion against eps."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..engine.status import Status
from ..problem import Problem
from ..sampling import ListedTimes
from .reporting import RunProgress
from .run import solve


MOST_STEPS = 1 << 18  # that each of three runs may make, together some two seconds; a small eps makes steps short


class _EnoughError(Exception):
    """A run has shown what it was made for, or has taken its steps."""


def inversion_sensitivity(problem: Problem, factor: float = 2.0) -> dict[str, Any]:
    """How the time of inversion depends on eps, from three runs in doubles.

    Parameters
    ----------
    problem
        The run.
    factor
        Between two values of eps.

    Returns
    -------
    dict
        `inversion_time`: first theta = pi/2 [s] by eps [m/s], for eps/factor, eps and eps*factor; None where it is not
        within `until`. `lifted_at`: when a liftoff ended the run before that [s], or None. `unknown`: those eps for
        which MOST_STEPS (to a slice) did not suffice, or whose run has no end; they have no time. `exponent`:
        d log t / d log eps; None where a time is missing. Empty for a law without eps.
    """
    if "eps" not in problem.friction._fields:
        return {}
    times: dict[float, float | None] = {}
    lifted: dict[float, float | None] = {}
    unknown = []
    for eps in (problem.friction.eps / factor, problem.friction.eps, problem.friction.eps * factor):
        time, end = _first_equator(replace(problem, friction=problem.friction._replace(eps=eps)))
        if time is math.nan:
            unknown.append(eps)
        else:
            times[eps], lifted[eps] = time, end
    low, high = times.get(problem.friction.eps / factor), times.get(problem.friction.eps * factor)
    exponent = math.log(high / low) / (2 * math.log(factor)) if low and high else None
    return {"inversion_time": times, "lifted_at": lifted, "unknown": unknown, "exponent": exponent}


def _first_equator(problem: Problem) -> tuple[float | None, float | None]:
    """First theta = pi/2 [s]; None if it is not within the run, nan if that was not found out; and when a liftoff ended
    the run [s], or None."""
    reached: list[float | None] = []

    def watch(progress: RunProgress) -> None:
        reached[:] = [progress.events.kept().get("first_equator")]
        if reached[0] is not None or progress.steps >= MOST_STEPS:
            raise _EnoughError

    lean = replace(problem, times=ListedTimes(np.array([0.0])), precision="double", tolerance=0.0)
    try:
        solution = solve(lean, watch, keep=False)
    except _EnoughError:
        return (math.nan if reached[0] is None else reached[0]), None
    equator = solution.report["inversion"]["first_equator"]
    lost = equator is None and solution.status in (Status.NON_FINITE, Status.STALLED)
    lifted = solution.report["t_end"] if solution.status is Status.LIFTOFF else None
    return (math.nan if lost else equator), lifted

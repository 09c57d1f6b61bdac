"""How much the regularisation of a Coulomb law decides: the time of inversion against eps."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..problem import Problem
from ..sampling import ListedTimes
from .run import solve


def inversion_sensitivity(problem: Problem, factor: float = 2.0) -> dict[str, Any]:
    """First theta = pi/2 for eps/factor, eps and eps*factor [s] (None: not within `until`), and the exponent
    d log t / d log eps, None where a time is missing. Empty for a law that has no eps."""
    if "eps" not in problem.friction._fields:
        return {}
    times: dict[float, float | None] = {}
    for eps in (problem.friction.eps / factor, problem.friction.eps, problem.friction.eps * factor):
        changed = replace(problem, friction=problem.friction._replace(eps=eps), times=ListedTimes(np.array([0.0])))
        times[eps] = solve(changed, keep=False).report["inversion"]["first_equator"]
    low, _, high = times.values()
    exponent = math.log(high / low) / (2 * math.log(factor)) if low and high else None
    return {"inversion_time": times, "exponent": exponent}

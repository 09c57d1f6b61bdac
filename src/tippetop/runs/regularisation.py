"""How much the regularisation of a Coulomb law decides: the time of inversion against eps."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..engine.driver import STEPS_PER_SLICE
from ..engine.status import Status
from ..mechanics.friction import is_frictionless
from ..problem import Problem
from ..sampling import ListedTimes
from .integration import Integration
from .sinks import Memory


MOST_STEPS = (
    1 << 18
)  # that each of three runs may make, together some two seconds; a small eps makes steps short
AFFORDABLE = 1.0  # seconds: `check` runs a Coulomb top thrice only if that is quick


def regularisation(problem: Problem, expected: dict[str, float]) -> dict[str, Any]:
    """Return what eps decides, as part of a report: the time of inversion for half, whole and twice
    eps.
    """
    friction = problem.friction
    if not problem.system.inverts or "eps" not in friction._fields or is_frictionless(friction):
        return {}
    result: dict[str, Any] = {
        "regularisation": "eps decides when a top with Coulomb friction inverts"
    }
    if expected["seconds"] < AFFORDABLE:
        sensitivity = inversion_sensitivity(problem)
        times, unknown = sensitivity["inversion_time"], sensitivity["unknown"]
        eps = sorted([*times, *unknown])
        if times.keys() >= set(eps[:2]):
            result["regularisation"] += _converged(times[eps[0]], times[eps[1]])
        if unknown:
            result["regularisation"] += f", but {_not_found_out(unknown)}"
        if times:
            result["inversion_by_eps"] = {
                "eps": {"value": list(times), "unit": "m s-1"},
                "first_equator": {"value": list(times.values()), "unit": "s"},
                "lifted_at": {"value": list(sensitivity["lifted_at"].values()), "unit": "s"},
                "exponent": {"value": sensitivity["exponent"], "unit": "1"},
            }
    return result


def _not_found_out(unknown: list[float]) -> str:
    """That the time of inversion is not known for these eps [m/s], and why."""
    values = ", ".join(f"{1e3 * eps:g}" for eps in unknown)
    return (
        f"when it does for eps = {values} mm/s was not found out: the steps are too short, "
        "the equations too stiff"
    )


# relative change of the time of inversion when eps is halved: less, and eps decides nothing
CONVERGED = 0.01


def _converged(half: float | None, whole: float | None) -> str:
    """What to add about eps, from the times of inversion for half of it and for itself; nothing if
    it is small.
    """
    if half is None and whole is None:
        return ""
    if half is None or whole is None:
        return ", and this eps has not converged: half of it decides whether it inverts in time"
    change = abs(half - whole) / whole
    if change <= CONVERGED:
        return ""
    return f", and this eps has not converged: half of it changes that time by {100 * change:.2g} %"


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
        `inversion_time`: first theta = pi/2 [s] by eps [m/s], for eps/factor, eps and eps*factor;
        None where it is not within `until`. `lifted_at`: when a liftoff ended the run before that
        [s], or None. `unknown`: those eps for which MOST_STEPS (to a slice) did not suffice, or
        whose run has no end; they have no time. `exponent`: d log t / d log eps; None where a time
        is missing. Empty for a law without eps.
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
    """Return the first theta = pi/2 [s], None if the run has none, NaN if that is not known; and
    its liftoff [s].
    """
    rows = ListedTimes(np.array([0.0]))
    integration = Integration(
        replace(problem, times=rows, precision="double", tolerance=0.0, orientation=False)
    )

    def reached() -> float | None:
        return integration.log.summary().kept().get("first_equator")

    def more() -> bool:
        return reached() is None and integration.monitor.steps < MOST_STEPS

    integration.part(Memory(keeps_rows=False), STEPS_PER_SLICE, more)
    time, status = reached(), integration.status
    if time is None and status in (None, Status.NON_FINITE, Status.STALLED):
        time = math.nan
    return time, integration.t_end if status is Status.LIFTOFF else None

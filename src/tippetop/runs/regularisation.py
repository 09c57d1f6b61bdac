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
from .sinks import Sink


# Steps of each of two runs, together at most some two seconds; a small eps makes steps short.
MOST_STEPS = 1 << 18
# Expected seconds of a run from which its time of inversion is not computed.
AFFORDABLE = 1.0
# Relative change of that time when eps is halved, below which eps decides nothing.
CONVERGED = 0.01


def regularisation(problem: Problem, expected: dict[str, float]) -> dict[str, Any]:
    """Return what eps decides, as part of a report: the time of inversion for half and whole eps.

    Parameters
    ----------
    problem
        The run.
    expected
        Its estimated cost: an expensive one is described without times.
    """
    friction = problem.friction
    if not problem.system.inverts or "eps" not in friction._fields or is_frictionless(friction):
        return {}
    text = "eps decides when a top with Coulomb friction inverts"
    if expected["seconds"] >= AFFORDABLE:
        return {"regularisation": text}
    values = [friction.eps / 2, friction.eps]
    times = [
        _first_equator(replace(problem, friction=friction._replace(eps=eps))) for eps in values
    ]
    if math.nan in times:
        why = "the steps are too short, the equations too stiff"
        return {"regularisation": f"{text}, but when it does was not found out: {why}"}
    half, whole = times
    has_not, change = ", and this eps has not converged: half of it", 0.0
    if half and whole:
        change = abs(half - whole) / whole
    elif half or whole:
        text += f"{has_not} decides whether it inverts in time"
    if change > CONVERGED:
        text += f"{has_not} changes that time by {100 * change:.2g} %"
    by_eps = {
        "eps": {"value": values, "unit": "m s-1"},
        "first_equator": {"value": times, "unit": "s"},
    }
    return {"regularisation": text, "inversion_by_eps": by_eps}


def _first_equator(problem: Problem) -> float | None:
    """Return the first theta = pi/2 [s]; None if the run has none, `math.nan` if it is unknown."""
    rows = ListedTimes(np.array([0.0]))
    integration = Integration(
        replace(problem, times=rows, precision="double", tolerance=0.0, orientation=False)
    )

    def reached() -> float | None:
        return integration.log.summary().kept().get("first_equator")

    integration.part(
        Sink(),
        STEPS_PER_SLICE,
        lambda: reached() is None and integration.monitor.steps < MOST_STEPS,
    )
    unknown = integration.status in (None, Status.NON_FINITE, Status.STALLED)
    return math.nan if reached() is None and unknown else reached()

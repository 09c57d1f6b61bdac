"""The error of a reference, and the time up to which results are compared with it."""

import dataclasses
from typing import Any

import numpy as np

from ..engine.derivatives.growth import growth
from ..errors import InputError
from ..problem import Problem
from .truth import Truth, differences, length_of, sample_times, truth


APART = 1e-12
"""Change of the start of a second run, by which the growth of small errors is found."""

BLIND = 1e7
"""Growth of an error of the start beyond which results say nothing about an engine."""


def certificate(problem: Problem) -> dict[str, Any]:
    """Return the error, the horizon and the growth of small errors of a reference.

    The error is the largest difference between the runs in double and in 80-bit numbers. At the
    horizon an error of 1e-10 of the start has grown to 1e-3: by the variational equations, or,
    where the contact may open, by a second run whose start differs by 1e-12.

    Raises InputError if the run ends before `run.until`.
    """
    times = sample_times(problem)
    (double, run), (exact, _) = truth(problem, times), truth(problem, times, "longdouble")
    if len(double.t) < len(times):
        raise InputError(f"a case must reach `run.until`, but its run ends before: {run.reason}.")
    by, factor = _growth(problem, double)
    beyond = np.flatnonzero(factor > BLIND)
    rows = int(beyond[0]) if len(beyond) else len(times)
    off = {key: float(curve[:rows].max()) for key, curve in differences(double, exact).items()}
    error = max(off["attitude [rad]"], off["position [m]"] / length_of(problem))
    return {
        "error": float(f"{error:.1e}"),
        "against": "the run in 80-bit numbers, which is exported",
        "errors": {key: float(f"{value:.1e}") for key, value in off.items()},
        "horizon": float(f"{times[rows - 1]:.6g}"),
        "horizon_by": by,
        "growth": float(f"{factor[:rows].max():.2g}"),
    }


def _growth(problem: Problem, double: Truth) -> tuple[str, np.ndarray]:
    """Return how the growth of small errors was found, and the growth at each row."""
    if problem.contact is None:
        return "variational equations (lyapunov)", growth(problem, double.t).factor
    moved = dict(problem.initial)
    theta = moved.get("theta", 0.0)
    moved["theta"] = theta + (APART if theta < 3 else -APART)  # pi is the last angle
    if moved.get("omega3"):
        moved["omega3"] *= 1 + APART
    near, _ = truth(dataclasses.replace(problem, initial=moved, origin=None), double.t)
    apart = differences(near, double)
    size = np.maximum(apart["attitude [rad]"], apart["position [m]"] / length_of(problem))
    return "two runs started 1e-12 apart", size / APART

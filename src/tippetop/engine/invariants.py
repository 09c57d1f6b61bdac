"""Conserved quantities of a motion, and what their drift is relative to."""

from typing import Any

import numpy as np

from ..problem import Problem
from .expressions import component, integrated, integrates_axis


def invariants(problem: Problem, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What a run must keep, of all that its states say.

    Parameters
    ----------
    problem
        The run, or what runs have in common.
    values
        Arrays (k,) by name, internal units.

    Returns
    -------
    dict
        The conserved quantities of the system; energy_balance = energy + work of friction; axis_norm = |3hat| in forms
        that integrate the axis. Internal units, (k,) each.
    """
    integrals = {name: _since_taken(values, name) for name in problem.system.integrals}
    integrals["energy_balance"] = values["energy"] + values.get("work", 0.0)
    if integrates_axis(problem.system, problem.form):
        axis = problem.system.vectors["axis"]
        x, y, z = (values.get(integrated(name), values[component(name)]) for name in axis)
        integrals["axis_norm"] = np.sqrt(x**2 + y**2 + z**2)
    return integrals


def _since_taken(values: dict[str, np.ndarray], name: str) -> np.ndarray:
    """An integral; of a contact whose ball may change, relative to what it was when its ball was taken."""
    taken = values.get(f"{name}_taken")
    if taken is None:
        return values[name]
    return 1 + (values[name] - taken) / size(taken)


def size(start: Any) -> Any:
    """What the drift of an invariant is relative to: its start; an invariant that is zero, to internal units.

    Parameters
    ----------
    start
        The invariant at t = 0, internal units, (k,).

    Returns
    -------
    array
        (k,), internal units.
    """
    return np.where(np.abs(start) > 1e-6, np.abs(start), 1.0)

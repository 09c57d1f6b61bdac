"""Conserved quantities of a motion, and the scales of their drifts.

Values of rows by name go in, as `observables.values_of` returns them; out come the quantities that
a run must conserve. `runs.drift` and `ensembles.outcomes` compare them with those of the start.
"""

import numpy as np

from ..columns import Arrays
from ..mechanics.units import ANGULAR_MOMENTUM, JELLETT
from ..problem import Problem
from ..problem.row_columns import component
from .expressions import integrated, integrates_axis


def invariants(problem: Problem, values: Arrays) -> Arrays:
    """Return the quantities that a run must conserve.

    Parameters
    ----------
    problem
        The run, or the base of several.
    values
        Arrays (k,) by name, internal units.

    Returns
    -------
    dict
        The conserved quantities of the system; if the ball in contact has changed, their change
        since then; energy_balance = energy + work of friction; axis_norm = |3hat| in forms that
        integrate the axis. Internal units, (k,) each. Stores have the drift of each by this name.
    """
    integrals = {
        name: values[name] + values.get(f"{name}_lost", 0.0) - values.get(reference_of(name), 0.0)
        for name in problem.system.integrals
    }
    # jumps may take energy that is not counted
    if "work" in values or not problem.system.is_hybrid:
        integrals["energy_balance"] = values["energy"] + values.get("work", 0.0)
    if integrates_axis(problem.system, problem.form):
        axis = problem.system.vectors["axis"]
        x, y, z = (values.get(integrated(name), values[component(name)]) for name in axis)
        integrals["axis_norm"] = np.sqrt(x**2 + y**2 + z**2)
    return integrals


def reference_of(name: str) -> str:
    """Return the name of an integral's value where the present contact began: `jellett_taken`.

    `mechanics.contact.rows` makes these values; `jellett_lost` is an integral of the run.
    """
    return f"{name}_taken"


CANCELS = 0.1  # of its parts: a smaller invariant is small because its parts cancel


def sizes(problem: Problem, values: Arrays) -> Arrays:
    """Return the scales of the drifts of the invariants: their values at the start.

    Rounding does not become less where the parts of an invariant cancel at the start: it is then
    compared with a tenth of them, that is of the internal unit (m g R) or, for a momentum, of the
    angular momentum |L| if that is more.

    Parameters
    ----------
    problem
        The run, or the base of several.
    values
        Arrays (k,) by name at the start, internal units.

    Returns
    -------
    dict
        (k,) each, internal units.
    """
    parts = [values[component(name)] for name in problem.system.vectors.get("L", ())]
    momentum = np.maximum(1.0, np.sqrt(sum(part**2 for part in parts)))
    momenta = {q.name for q in problem.system.quantities if q.unit in (ANGULAR_MOMENTUM, JELLETT)}
    return {
        name: np.maximum(
            np.abs(values.get(reference_of(name), start)),
            CANCELS * (momentum if name in momenta else 1.0),
        )
        for name, start in invariants(problem, values).items()
    }

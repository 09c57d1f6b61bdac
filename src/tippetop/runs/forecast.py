"""Predict a run from its start: invariants, regime, fate, cost.

A checked problem goes in; out come plain data for `tippetop check`, made by the theory of its
system and by `cost`. Nothing is integrated.
"""

from dataclasses import replace

import numpy as np

from ..arguments import PlainData
from ..engine.observables import Observables
from ..engine.taylor import driver_of
from ..problem import Problem
from ..scenario.doubts import contact_start, starts_at_pole
from .cost import estimate


ROUNDING = 2.0**-52
"""Relative change of each number of a state; a quantity that it changes by its size is 0."""


def assessment(problem: Problem) -> PlainData:
    """Return the quantities at the start (SI, with units), predictions, and the expected cost."""
    start = at_start(problem)
    quantities = {
        q.name: {
            "value": q.meanings[int(start[q.name])] if q.meanings else start[q.name],
            "unit": q.unit.symbol,
        }
        for q in problem.system.quantities
        if q.is_column
    }
    predictions = {"contact_point": contact_start(problem), **_outlook(problem, start)}
    return {
        "at_start": quantities,
        **{name: part for name, part in predictions.items() if part},
        "expected": estimate(problem),
    }


def at_start(problem: Problem) -> dict[str, float]:
    """Return the quantities at the start by name, SI; 0 where rounding of the state hides them.

    A quantity is hidden if it is smaller than its range over the start and 15 neighbours of it.
    """
    first = problem.start()[None, :]
    if problem.contact is not None:  # its phase decides the reaction
        problem = replace(problem, precision="double", tolerance=0.0)
        first = driver_of(problem).first
    signs = np.random.default_rng(0).choice([-1, 1], (16, first.size))
    signs[0] = 0  # the start itself
    values = Observables(problem).evaluate(first * (1 + ROUNDING * signs))
    start = {}
    for q in problem.system.quantities:
        numbers = values[q.name] * problem.unit(q.unit)
        start[q.name] = 0.0 if abs(numbers[0]) <= np.ptp(numbers) else float(numbers[0])
    given = {name: problem.initial.get(name, 0.0) for name in ("theta", "phi_dot")}
    return start | {"at_pole": float(starts_at_pole(problem)), **given}


def comments(problem: Problem) -> PlainData:
    """Return the part of a report that follows from theory: the name of the motion."""
    motion = problem.system.motion
    return {} if motion is None else {"motion": motion(problem.body(), at_start(problem))}


def _outlook(problem: Problem, start: dict[str, float]) -> PlainData:
    """Return thresholds, regime and predicted fate, as far as the theory of the system goes.

    They are the fields of the `Outlook` that the system makes, each threshold as plain data.
    """
    if problem.system.outlook is None:
        return {}
    # the outlook of a system whose contact opens takes its `ContactLaw` too
    law = () if problem.contact is None else (problem.contact,)
    outlook = problem.system.outlook(problem.body(), start, *law)
    limits = {
        name: {"value": t.value, "unit": t.unit.symbol, "meaning": t.long_name}
        for name, t in outlook.thresholds.items()
    }
    return {"thresholds": limits, "regime": outlook.regime, "fate": outlook.fate}

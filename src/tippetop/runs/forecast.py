"""Facts about a scenario before it is run: invariants, regime, fate."""

from dataclasses import replace
from typing import Any

from ..engine.observables import Observables
from ..engine.taylor import driver_of
from ..problem import Problem
from ..scenario.doubts import contact_start, starts_at_pole
from .cost import estimate


def assessment(problem: Problem) -> dict[str, Any]:
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
    """Return the quantities at the start by name, SI."""
    first = problem.start()[None, :]
    if problem.contact is not None:  # its phase decides the reaction
        problem = replace(problem, precision="double", tolerance=0.0)
        first = driver_of(problem).first
    values = Observables(problem).evaluate(first)
    start = {
        q.name: float(values[q.name][0]) * float(problem.scales.of(q.unit))
        for q in problem.system.quantities
    }
    given = {name: problem.initial.get(name, 0.0) for name in ("theta", "phi_dot")}
    return start | {"at_pole": float(starts_at_pole(problem)), **given}


def comments(problem: Problem) -> dict[str, Any]:
    """Return the part of a report that follows from theory: the name of the motion."""
    motion = problem.system.motion
    return {} if motion is None else {"motion": motion(problem.body(), at_start(problem))}


def _outlook(problem: Problem, start: dict[str, float]) -> dict[str, Any]:
    """Return thresholds, regime and predicted fate, as far as the theory of the system goes."""
    if problem.system.outlook is None:
        return {}
    law = () if problem.contact is None else (problem.contact,)
    outlook = problem.system.outlook(problem.body(), start, *law)
    limits = {
        name: {"value": t.value, "unit": t.unit.symbol, "meaning": t.long_name}
        for name, t in outlook.thresholds.items()
    }
    return {"thresholds": limits, "regime": outlook.regime, "fate": outlook.fate}

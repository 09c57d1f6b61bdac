"""What is known of a scenario before it is run: its invariants, its regime, its fate."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..engine.observables import Observables
from ..engine.taylor import driver_of
from ..mechanics.friction import is_frictionless
from ..problem import Problem
from ..sampling import ListedTimes
from . import cost
from .regularisation import regularisation


LONG = 1e5  # seconds after which the vector form of a rolling top has changed E by 1e-12


def assessment(problem: Problem) -> dict[str, Any]:
    """What is at the start (name -> value in SI, unit), what theory predicts of it, and what the
    run will take.
    """
    start, expected = at_start(problem), cost.estimate(problem)
    columns = [q for q in problem.system.quantities if q.is_column]
    quantities = {
        q.name: {"value": _in_words(q, start[q.name]), "unit": q.unit.symbol} for q in columns
    }
    predicted = _outlook(problem, start) | regularisation(problem, expected) | _advice(problem)
    facts = {"auto_form": problem.auto_form, "at_start": quantities}
    return {**facts, **predicted, "expected": expected}


def at_start(problem: Problem) -> dict[str, float]:
    """The quantities at the start by name, SI."""
    first = problem.start()[None, :]
    if problem.contact is not None:  # its phase decides the reaction
        problem = replace(problem, precision="double", tolerance=0.0)
        first = driver_of(problem).first
    values = Observables(problem).evaluate(first)
    start = {
        q.name: float(values[q.name][0]) * float(problem.scales.of(q.unit))
        for q in problem.system.quantities
    }
    moving = ("theta_dot",) if is_frictionless(problem.friction) else ("theta_dot", "nu_x", "nu_y")
    at_rest = not any(problem.initial.get(name) for name in moving)
    theta = problem.initial.get("theta", 0.0)
    return start | {"at_pole": float(at_rest and theta in (0.0, math.pi)), "theta": theta}


def _in_words(quantity: Any, value: float) -> float | str:
    """A quantity at the start; of a number that stands for a word, the word."""
    return quantity.meanings[int(value)] if quantity.meanings else value


def comments(problem: Problem) -> dict[str, Any]:
    """What theory adds to the report of a finished run: the name of its motion, what
    eps decides.
    """
    result = regularisation(problem, cost.estimate(problem))
    if problem.system.motion is not None:
        result["motion"] = problem.system.motion(problem.body(), at_start(problem))
    return result


def _outlook(problem: Problem, start: dict[str, float]) -> dict[str, Any]:
    """Thresholds, regime and predicted fate, as far as the theory of the system goes; nothing if it
    has none.
    """
    if problem.system.outlook is None:
        return {}
    law = () if problem.contact is None else (problem.contact,)
    outlook = problem.system.outlook(problem.body(), start, *law)
    limits = {
        name: {"value": t.value, "unit": t.unit.symbol} for name, t in outlook.thresholds.items()
    }
    sentences = {"regime": outlook.regime, "fate": outlook.fate}
    return {
        **({"thresholds": limits} if limits else {}),
        **{key: text for key, text in sentences.items() if text},
    }


TRIED = 1.0  # seconds that a try may take, by the expected cost


def tried(problem: Problem) -> dict[str, Any]:
    """What a short run shows: how it ends, the least normal force on the way.

    Where the whole run would take more than a second, its first part.
    """
    from .run import solve

    expected = cost.estimate(problem)["seconds"]
    until = problem.until * min(1.0, TRIED / expected) if expected > 0 else problem.until
    short = replace(problem, until=until, times=ListedTimes(np.array([0.0])), output="times")
    short_run = solve(short, keep=False)
    force = short_run.report.get("normal_force")
    least = (
        {}
        if force is None
        else {
            "normal_force_min": {"value": force["min"], "unit": "N"},
            "weight": {"value": force["weight"], "unit": "N"},
        }
    )
    return {
        "until": {"value": until, "unit": "s"},
        "status": short_run.status.value,
        "reason": short_run.reason,
        **({"outcome": short_run.report["outcome"]} if "outcome" in short_run.report else {}),
        **least,
    }


def _advice(problem: Problem) -> dict[str, str]:
    """A better form for a run so long that rounding would break the contract."""
    better = problem.system.long_form
    if not better or problem.tolerance or problem.precision != "double" or problem.until < LONG:
        return {}
    if problem.form.name == better:
        return {
            "advice": "truncation changes E by some 4.6e-17 a second: tolerance = 1e-18 keeps it"
        }
    return {
        "advice": f'rounding changes E by some 1.5e-17 a second: form = "{better}" with '
        "tolerance = 1e-18 keeps it"
    }

"""What the functions of a system answer: they are called once, with numbers that may be given, as
the engine does.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import friction
from ..number import Number
from ..operand import leaves
from ..system import Form, Phase, System


def allowed(rule: Number) -> float:
    """A number that a parameter may be."""
    if rule.default is not None:
        return rule.default
    low = [bound for bound in (rule.above, rule.least) if bound is not None]
    high = [bound for bound in (rule.below, rule.most) if bound is not None]
    if low and high:
        middle = (max(low) + min(high)) / 2
        return (middle + min(high)) / 2 if rule.nonzero and not middle else middle
    return max(1.0, 2 * max(low)) if low else min(1.0, min(high) - 1.0) if high else 1.0


def wrong_answers(system: System) -> list[str]:
    """What is wrong with the functions of a system, in one sentence at most."""
    law = next(iter(system.laws.values()), friction.LAWS["none"])
    numbers = {name: allowed(rule) for name, rule in system.parameters.items()}
    names = ", ".join(system.parameters) or "none"
    took = f"`body`, `body_units`, `scales` of `{system.name}` must take its parameters ({names})"
    results: dict[str, Any] = {}

    def bodies() -> None:
        results["body"] = system.body_of(numbers, law._make(map(allowed, law.parameters.values())))
        results["units"] = system.body_units(law.units())
        results["scales"] = system.scales(results["body"])

    if fault := _failure(bodies):
        return [f"{took}, but fail: {fault}."]
    body, scales = results["body"], results["scales"]
    if not hasattr(body, "_fields") or type(results["units"]) is not type(body):
        return [
            f"`body` and `body_units` of `{system.name}` must give NamedTuples of one type, but "
            "do not."
        ]
    if (
        not isinstance(scales, tuple)
        or len(scales) != 2
        or not all(_positive(scale) for scale in scales)
    ):
        return [
            f"`scales` of `{system.name}` must give a mass and a length, finite and greater "
            "than 0, but gives "
            f"{scales!r:.60}."
        ]
    return (
        _of_checks(system, numbers)
        or _of_start(system, body)
        or _of_phases(system, body)
        or _of_poles(system, body)
    )


def _of_checks(system: System, numbers: dict[str, float]) -> list[str]:
    sentences: list[Any] = []
    if fault := _failure(lambda: sentences.append(system.checks(numbers))):
        return [f"`checks` of `{system.name}` must give a list of sentences, but fails: {fault}."]
    if isinstance(sentences[0], list | tuple) and all(
        isinstance(sentence, str) for sentence in sentences[0]
    ):
        return []
    return [
        f"`checks` of `{system.name}` must give a list of sentences, but gives "
        f"{sentences[0]!r:.60}."
    ]


def _of_start(system: System, body: Any) -> list[str]:
    says_again = {alternative.name for alternative in system.alternatives}
    data = {name: allowed(rule) for name, rule in system.initial.items() if name not in says_again}
    theta, angles = data.get("theta", 0.0), []
    if fault := _failure(
        lambda: angles.append(system.start(data, math.sin(theta), math.cos(theta), body))
    ):
        return [
            f"`start` of `{system.name}` must give a record as `angles` is, but fails: {fault}."
        ]
    if getattr(angles[0], "_fields", None) == system.angles._fields:
        return []
    return [
        f"`start` of `{system.name}` must give a record as `angles` is, but gives "
        f"{angles[0]!r:.60}."
    ]


KEEPS = 1e-9
"""Relative error with which a phase must keep the common state."""


def _of_phases(system: System, body: Any) -> list[str]:
    """Return a sentence on each phase that changes the common state: leave(enter(x)) must be x."""
    faults = []
    for name, phase in system.phases.items():
        states: list[Any] = []

        def enter_and_leave(phase: Phase = phase, states: list[Any] = states) -> None:
            b = phase.parameters(body)
            states.append(phase.leave(_state(phase.form), b))
            states.append(phase.leave(phase.enter(states[0], b), b))

        def leave_rows(phase: Phase = phase) -> None:
            units = phase.form.units
            phase.leave(
                type(units)(*(np.full(2, 0.5 + k / 64) for k in range(len(units)))),
                phase.parameters(body),
            )

        must = (
            f"`enter` and `leave` of phase `{name}` of `{system.name}` must keep the common "
            "state, but"
        )
        if fault := _failure(enter_and_leave):
            faults.append(f"{must} fail: {fault}.")
        elif not all(
            math.isclose(*pair, rel_tol=KEEPS) for pair in zip(*map(leaves, states), strict=True)
        ):
            faults.append(f"{must} {states[0]!r:.60} becomes {states[1]!r:.60}.")
        elif fault := _failure(leave_rows):
            faults.append(
                f"`leave` of phase `{name}` of `{system.name}` must take arrays, of rows, but "
                f"fails: {fault}."
            )
    return faults


def _of_poles(system: System, body: Any) -> list[str]:
    """Return a sentence on each form whose scalars lack what rows at a pole read."""
    faults = []
    for form in system.forms.values() if system.undefined_at_poles else ():
        results: list[Any] = []

        def scalars(form: Form = form, results: list[Any] = results) -> None:
            results.append(form.scalars(_state(form), body))

        must = (
            f"`scalars` of the form `{form.name}` of `{system.name}` must have `s2` and "
            "`axis_speed2`, which the"
        )
        if fault := _failure(scalars):
            faults.append(f"{must} angles of `undefined_at_poles` need, but fail: {fault}.")
        elif lacking := [
            f"`{name}`" for name in ("s2", "axis_speed2") if not hasattr(results[0], name)
        ]:
            faults.append(
                f"{must} angles of `undefined_at_poles` need, but lack {' and '.join(lacking)}."
            )
    return faults


def _state(form: Form) -> Any:
    """Return a state without poles or zeros."""
    return type(form.units)(*(0.5 + k / 64 for k in range(len(form.units))))


def _failure(call: Callable[[], Any]) -> str:
    """What a call raises, in words; empty if it raises nothing."""
    try:
        call()
    except Exception as error:  # the functions are the user's
        return f"{type(error).__name__}: {error}"
    return ""


def _positive(value: Any) -> bool:
    try:
        return bool(0 < float(value) < math.inf)
    except (TypeError, ValueError):
        return False

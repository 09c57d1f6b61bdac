"""Checks of a user-defined system that call its functions, once, with numbers that are allowed."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ...errors import InputError
from .. import friction
from ..number import Number
from ..operand import leaves
from ..system import Form, Phase, System


KEEPS = 1e-9
"""Relative error with which a phase must keep the common state."""


def allowed(rule: Number) -> float:
    """Return a number that a parameter may be."""
    if rule.default is not None:
        return rule.default
    low = [bound for bound in (rule.above, rule.least) if bound is not None]
    high = [bound for bound in (rule.below, rule.most) if bound is not None]
    if low and high:
        middle = (max(low) + min(high)) / 2
        return (middle + min(high)) / 2 if rule.nonzero and not middle else middle
    return max(1.0, 2 * max(low)) if low else min(1.0, min(high) - 1.0) if high else 1.0


@contextmanager
def _calling(must: str, fails: str = "fails") -> Iterator[None]:
    """Name the requirement of a function of the user that raises."""
    try:
        yield
    except Exception as error:
        raise InputError([f"{must}, but {fails}: {type(error).__name__}: {error}."]) from None


def _require(holds: bool, must: str, found: str) -> None:
    if not holds:
        raise InputError([f"{must}, but {found}."])


def check_answers(system: System) -> None:
    """Raise InputError for a system whose functions fail or return wrong results."""
    of, names = f"of `{system.name}`", ", ".join(system.parameters) or "none"
    law = next(iter(system.laws.values()), friction.LAWS["none"])
    numbers = {name: allowed(rule) for name, rule in system.parameters.items()}
    must = f"`body`, `body_units`, `scales` {of} must take its parameters ({names})"
    with _calling(must, "fail"):
        body = system.body_of(numbers, law._make(map(allowed, law.parameters.values())))
        units, scales = system.body_units(law.units()), system.scales(body)
    must = f"`body` and `body_units` {of} must give NamedTuples of one type"
    _require(hasattr(body, "_fields") and type(units) is type(body), must, "do not")
    must = f"`scales` {of} must give a mass and a length, finite and greater than 0"
    positive = isinstance(scales, tuple) and len(scales) == 2
    with _calling(must):
        positive = positive and all(0 < float(scale) < math.inf for scale in scales)
    _require(positive, must, f"gives {scales!r:.60}")

    must = f"`checks` {of} must give a list of sentences"
    with _calling(must):
        faults: Any = system.checks(numbers)
    listed = isinstance(faults, list | tuple) and all(isinstance(fault, str) for fault in faults)
    _require(listed, must, f"gives {faults!r:.60}")

    flags = {alternative.name for alternative in system.alternatives}
    data = {name: allowed(rule) for name, rule in system.initial.items() if name not in flags}
    theta = data.get("theta", 0.0)
    must = f"`start` {of} must give a record as `angles` is"
    with _calling(must):
        angles = system.start(data, math.sin(theta), math.cos(theta), body)
    fields = getattr(angles, "_fields", None)
    _require(fields == system.angles._fields, must, f"gives {angles!r:.60}")

    for name, phase in system.phases.items():
        _check_phase(phase, f"phase `{name}` {of}", body)
    for form in system.forms.values() if system.undefined_at_poles else ():
        must = f"`scalars` of the form `{form.name}` {of} must have `s2` and `axis_speed2`, which "
        must += "the angles of `undefined_at_poles` need"
        with _calling(must, "fail"):
            scalars = form.scalars(_state(form), body)
        lacking = [f"`{name}`" for name in ("s2", "axis_speed2") if not hasattr(scalars, name)]
        _require(not lacking, must, f"lack {' and '.join(lacking)}")


def _check_phase(phase: Phase, where: str, body: Any) -> None:
    """Check that a phase keeps the common state: leave(enter(x)) must be x."""
    must = f"`enter` and `leave` of {where} must keep the common state"
    with _calling(must, "fail"):
        b = phase.parameters(body)
        x = phase.leave(_state(phase.form), b)
        again = phase.leave(phase.enter(x, b), b)
        pairs = zip(leaves(x), leaves(again), strict=True)
        kept = all(math.isclose(*pair, rel_tol=KEEPS) for pair in pairs)
    _require(kept, must, f"{x!r:.60} becomes {again!r:.60}")
    with _calling(f"`leave` of {where} must take arrays, of rows"):
        phase.leave(_state(phase.form, np.ones(2)), b)


def _state(form: Form, one: Any = 1.0) -> Any:
    """Return a state without poles or zeros."""
    return type(form.units)(*(one * (0.5 + k / 64) for k in range(len(form.units))))

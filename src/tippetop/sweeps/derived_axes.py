"""Dimensionless numbers of theory as axes of a sweep, which set numbers of the scenario.

Numbers of axes such as `sigma` go in; numbers of the scenario, (n,) by dotted key, come out.

Symbols
    base      the scenario, a `Problem`; columns: the other varied numbers of tops, (n,) by key
    gamma, sigma   I1/I3, m R^2/I3; lambda: Jellett's integral, lambda_s: see `theory.thresholds`
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.systems import SYSTEMS
from ..mechanics.theory import thresholds
from ..mechanics.units import JELLETT
from ..problem import Problem, Problems


Numbers = dict[str, np.ndarray]


class Derived(NamedTuple):
    """A derived number of a tippe top.

    `numbers(base, columns, values)` returns the keys `sets`, (n,) each, SI, at which the number has
    these values (n,); `columns` are the other numbers of the tops.
    """

    long_name: str
    sets: tuple[str, ...]  # keys of the scenario
    numbers: Callable[[Problem, Numbers, np.ndarray], Numbers]


def body(base: Problem, columns: Numbers) -> Any:
    """Return the body `b` of tops with other numbers than the base, SI.

    Fields that vary are (n,), the others may be numbers.
    """
    return Problems(base, columns).body(lambda value: value)


def jellett(base: Problem, columns: Numbers) -> np.ndarray:
    """Return Jellett's integral of tops at their start [kg m^3/s], (n,)."""
    tops = Problems(base, columns)
    formula = next(q.formula for q in base.system.quantities if q.name == "jellett")
    start = base.form.scalars(tops.variables.split(tops.start)[0], tops.internal_body)
    return formula(start, tops.internal_body) * tops.unit(JELLETT)


def _by_sigma(base: Problem, columns: Numbers, sigma: np.ndarray) -> Numbers:
    """Return I3 and I1 at which sigma = m R^2/I3 has these values (n,), with gamma as it is.

    Like its neighbours it is `Derived.numbers`: the result is (n,) by dotted key, SI.
    """
    b = body(base, columns)
    now = thresholds.shape(b)
    I3 = b.I3 * now.sigma / sigma
    return {"parameters.I3": I3, "parameters.I1": I3 * now.gamma}


def _by_gamma(base: Problem, columns: Numbers, gamma: np.ndarray) -> Numbers:
    """Return I1 at which gamma = I1/I3 has these values (n,); see `Derived.numbers`."""
    b = body(base, columns)
    return {"parameters.I1": b.I1 * gamma / thresholds.shape(b).gamma}


def _by_lambda(base: Problem, columns: Numbers, ratio: np.ndarray) -> Numbers:
    """Return the initial omega3 at which lambda/lambda_s is `ratio`; see `Derived.numbers`."""
    still, turning = (
        jellett(base, {**columns, "initial.omega3": np.full(len(ratio), w)}) for w in (0.0, 1.0)
    )
    wanted = ratio * thresholds.lambda_s(body(base, columns))
    return {"initial.omega3": (wanted - still) / (turning - still)}  # lambda is linear in omega3


# in the order in which they are applied: each uses the numbers that those before it set
DERIVED = {
    "sigma": Derived(
        "sigma = m R^2/I3, set by I3 at the same gamma",
        ("parameters.I3", "parameters.I1"),
        _by_sigma,
    ),
    "gamma": Derived("gamma = I1/I3, set by I1", ("parameters.I1",), _by_gamma),
    "lambda": Derived(
        "lambda of the start over lambda_s, set by omega3", ("initial.omega3",), _by_lambda
    ),
}


def resolved(base: Problem, numbers: Numbers) -> Numbers:
    """Return the numbers of tops with derived ones replaced by the keys that they set."""
    columns = {key: values for key, values in numbers.items() if key not in DERIVED}
    with np.errstate(all="ignore"):  # impossible tops get numbers that validation refuses
        for name, rule in DERIVED.items():
            if name in numbers:
                columns |= rule.numbers(base, columns, numbers[name])
    return columns


def faults(base: Problem, keys: list[str]) -> list[str]:
    """Return a sentence for each reason why these keys may not vary together; [] if they may."""
    sentences = []
    system = base.system
    known = [name for name, s in SYSTEMS.items() if {"R", "I1"} <= s.parameters.keys()]
    for name in sorted(DERIVED.keys() & keys):
        if system.name not in known:
            sentences.append(
                f"`{name}` must be an axis of {', '.join(known)}, but the system is {system.name}."
            )
        rivals = {*DERIVED[name].sets}
        for key in DERIVED[name].sets:
            rivals |= {f"initial.{rival}" for rival in system.rivals(key.removeprefix("initial."))}
        sentences += [
            f"`{name}` must vary alone, but `{key}` varies too." for key in keys if key in rivals
        ]
    return sentences

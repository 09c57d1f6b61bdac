"""Numbers without unit by which theory sorts tippe tops; a sweep that varies one sets numbers of
the scenario by it.
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
    """What it means, the keys that it sets, what it sets them to, and the parameters
    that it needs.
    """

    long_name: str
    sets: tuple[str, ...]
    numbers: Callable[[Problem, Numbers, np.ndarray], Numbers]
    needs: tuple[str, ...]
    inverts: bool = False  # only of systems that can invert, which have a lambda_s


def body(base: Problem, columns: Numbers) -> Any:
    """The bodies of tops with other numbers than the base, SI."""
    return Problems(base, columns).body(lambda value: value)


def jellett(base: Problem, columns: Numbers) -> np.ndarray:
    """Jellett's integral of tops at their start [kg m^3/s], (n,)."""
    tops = Problems(base, columns)
    formula = next(q.formula for q in base.system.quantities if q.name == "jellett")
    return formula(
        base.form.scalars(tops.record(tops.start), tops.internal_body), tops.internal_body
    ) * tops.unit(JELLETT)


def _by_sigma(base: Problem, columns: Numbers, sigma: np.ndarray) -> Numbers:
    b = body(base, columns)
    now = thresholds.shape(b)
    I3 = b.I3 * now.sigma / sigma
    return {"parameters.I3": I3, "parameters.I1": I3 * now.gamma}


def _by_gamma(base: Problem, columns: Numbers, gamma: np.ndarray) -> Numbers:
    b = body(base, columns)
    return {"parameters.I1": b.I1 * gamma / thresholds.shape(b).gamma}


def _by_lambda(base: Problem, columns: Numbers, ratio: np.ndarray) -> Numbers:
    still, turning = (
        jellett(base, {**columns, "initial.omega3": np.full(len(ratio), w)}) for w in (0.0, 1.0)
    )
    wanted = ratio * thresholds.lambda_s(body(base, columns))
    return {"initial.omega3": (wanted - still) / (turning - still)}  # lambda is linear in omega3


DERIVED = {
    "sigma": Derived(
        "sigma = m R^2/I3, set by I3 at the same gamma",
        ("parameters.I3", "parameters.I1"),
        _by_sigma,
        ("m", "R", "I1", "I3"),
    ),
    "gamma": Derived("gamma = I1/I3, set by I1", ("parameters.I1",), _by_gamma, ("R", "I1", "I3")),
    "lambda": Derived(
        "lambda of the start over lambda_s, set by omega3",
        ("initial.omega3",),
        _by_lambda,
        (),
        inverts=True,
    ),
}
"""In the order in which they are applied: each takes what those before it have set."""


def resolved(base: Problem, numbers: Numbers) -> Numbers:
    """The numbers of tops under keys of a scenario only: what is derived replaced by
    what it sets.
    """
    columns = {key: values for key, values in numbers.items() if key not in DERIVED}
    with np.errstate(all="ignore"):  # what cannot be becomes a number that validation refuses
        for name, rule in DERIVED.items():
            if name in numbers:
                columns |= rule.numbers(base, columns, numbers[name])
    return columns


def faults(base: Problem, keys: list[str]) -> list[str]:
    """What is wrong with varying these keys together."""
    sentences = []
    for name, rule in DERIVED.items():
        if name not in keys:
            continue
        if rule.inverts and not base.system.inverts:
            known = ", ".join(system.name for system in SYSTEMS.values() if system.inverts)
            sentences.append(
                f"`{name}` must be an axis of {known}, but the system is {base.system.name}."
            )
        missing = [p for p in rule.needs if p not in base.parameters]
        if missing:
            sentences.append(
                f"`{name}` must have {', '.join(rule.needs)}, but {base.system.name} has no "
                f"{missing[0]}."
            )
        initial = [key.partition(".")[2] for key in rule.sets if key.startswith("initial.")]
        rivals = {
            *rule.sets,
            *(f"initial.{rival}" for name in initial for rival in base.system.rivals(name)),
        }
        sentences += [
            f"`{name}` must stand alone, but `{key}` varies too." for key in keys if key in rivals
        ]
    return sentences

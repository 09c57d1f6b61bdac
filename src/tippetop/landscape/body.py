"""The body whose potential is evaluated: parameters in SI become coefficients of V, rounded once."""

import decimal
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..mechanics.contact import body as contact
from ..mechanics.friction import Frictionless
from ..mechanics.operand import refill
from ..mechanics.potential import PotentialCoefficients, rounded
from ..mechanics.system import Landscape, Parameter, System
from ..mechanics.systems import SYSTEMS, find


DIGITS = 50  # of the constants before they are rounded: the marked lines cancel


@dataclass(frozen=True)
class Top:
    """A body as the kernels take it."""

    system: System
    landscape: Landscape
    parameters: dict[str, float]  # SI
    coefficients: PotentialCoefficients
    body: contact.Body  # SI
    two_wells: bool  # V can have two minima

    @property
    def momenta(self) -> tuple[str, str]:
        """The symbols of the two momenta."""
        return self.landscape.symbols

    @property
    def upright(self) -> int:
        """z = cos(theta) at q = 0."""
        return self.landscape.upright


def landscape_of(system: str | System) -> tuple[System, Landscape]:
    """A system, by name or itself, and its landscape. Raises ValueError where there is none."""
    record = find(system) if isinstance(system, str) else system
    if record is None or record.landscape is None:
        known = ", ".join(name for name, s in SYSTEMS.items() if s.landscape is not None)
        name = system if isinstance(system, str) else system.name
        raise ValueError(f"Argument `system` must be one of {known}, but is {name!r}.")
    return record, record.landscape


def top(parameters: Mapping[str, float], system: str | System = "tippe-top") -> Top:
    """The body of a system with its parameters; its constants are taken with 50 digits, then rounded once.

    Parameters
    ----------
    parameters
        The numbers of the system, SI, by name.
    system
        A system that has a landscape, or its name.

    Raises
    ------
    ValueError
        For a system without landscape, and a parameter that is missing, not finite, or outside its interval.
    """
    record, landscape = landscape_of(system)
    given = {}
    for name, value in parameters.items():
        given[name] = float(value)
        if not np.isfinite(given[name]):
            raise ValueError(f"Argument `parameters.{name}` must be finite, but is {value}.")
    for name, parameter in record.parameters.items():
        if name not in given:
            raise ValueError(f"Argument `parameters` must have {name!r}, but has {', '.join(given)}.")
        if not _allowed(given[name], parameter):
            raise ValueError(f"Argument `parameters.{name}` must be {_interval(parameter)}, but is {given[name]}.")
    with decimal.localcontext(prec=DIGITS):
        exact = record.body({name: decimal.Decimal(x) for name, x in given.items()}, Frictionless())
        coefficients = rounded(landscape.coefficients(exact))
        two_wells = landscape.two_wells is not None and bool(landscape.two_wells(exact) < 0)
    return Top(record, landscape, given, coefficients, refill(exact, (float(x) for x in exact[:-1])), two_wells)


def _allowed(value: float, p: Parameter) -> bool:
    """Whether a number lies in the interval of its parameter."""
    low = (p.above is None or value > p.above) and (p.least is None or value >= p.least)
    return low and (p.below is None or value < p.below) and (p.most is None or value <= p.most)


def _interval(p: Parameter) -> str:
    """The interval of a parameter, in words."""
    if (p.above, p.least, p.below, p.most) == (0, None, None, None):
        return "positive"
    bounds: list[tuple[str, Any]] = [
        ("greater than", p.above),
        ("at least", p.least),
        ("less than", p.below),
        ("at most", p.most),
    ]
    return " and ".join(f"{words} {bound:g}" for words, bound in bounds if bound is not None)

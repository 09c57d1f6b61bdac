"""Friction that drills: Coulomb's law at each point of a contact disc under Hertz's pressure. [contact 5]

A disc of radius a that slides with w and turns with Omega_z about its normal: x = w/U, U = a |Omega_z|. The force is
-mu N f(x) v/w, the torque about the normal -mu N a m(x) sgn(Omega_z). Three regions of x have a formula each.
"""

import math
from typing import NamedTuple

from ..operand import Operand, atan2, formula, sqrt


class Shares(NamedTuple):
    """f(x)/x, and m(x): of the friction that would be without turning, and without sliding."""

    slide: Operand
    drill: Operand


@formula
def inner(x2):
    """x <= 1, by x^2: regular where nothing slides, F = -(3 pi/8)(mu N/U) v."""
    return Shares(3 * math.pi / 8 * (1 - x2 / 4), 3 * math.pi / 16 * (1 - x2 + 3 * x2**2 / 8))


@formula
def outer(x2):
    """x >= 1, by x^2."""
    y = sqrt(x2 - 1)
    A = atan2(1 + 0 * y, y)  # arcsin(1/x)
    return Shares(
        3 * ((1 - x2 / 4) * A + (x2 + 2) * y / (4 * x2)) / 4,
        3 * ((1 - x2 + 3 * x2**2 / 8) * A + 3 * (2 - x2) * y / 8) / 8,
    )


@formula
def far(x2):
    """x > 30, by x^2: what is left where `outer` cancels, to 4e-17."""
    t, x = 1 / x2, sqrt(x2)
    return Shares(
        (1 - t * (1 / 10 + t * (3 / 280 + t * (1 / 336 + t * 5 / 4224)))) / x,
        (1 / 5 + t * (1 / 70 + t * (1 / 280 + t * 5 / 3696))) / x,
    )


EDGE, FAR = 1 + 1e-6, 30.0
"""Where `outer` takes over from `inner`, which is then wrong by 1e-15: its slope has a root at x = 1; and `far`."""

REGIONS = {"inner": inner, "outer": outer, "far": far}


def region(x: float) -> str:
    """The name of the formula for x."""
    return "inner" if x < EDGE else "outer" if x < FAR else "far"


def shares(x: float) -> Shares:
    """f(x)/x and m(x) of a number."""
    return REGIONS[region(float(x))](float(x) ** 2)

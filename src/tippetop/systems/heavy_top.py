"""Heavy symmetric tops: mass m, distance l from the tip to the centre of mass, I1 and I3 about the latter. [T ch. 2, 5]

Both are gliding bodies with R = 0, c = -l (see gliding.Body): one stands on a plane, the other has its tip fixed.
"""

from typing import NamedTuple

from ..operand import Operand, formula
from .gliding import Body


class HeavyTop(NamedTuple):
    """m [kg], l [m], I1 and I3 about the centre of mass [kg m^2], g [m/s^2]."""

    m: Operand
    l: Operand
    I1: Operand
    I3: Operand
    g: Operand


def body(parameters, friction) -> Body:
    """The body of a heavy top: R = 0, c = -l."""
    m, l, I1, I3, g = (parameters[name] for name in HeavyTop._fields)
    return Body(m, 0 * l, -l, I1, I3, g, friction)


@formula
def tip_inertia(b):
    """I1* = I1 + m l^2, transverse moment of inertia about the tip [kg m^2]."""
    return b.I1 + b.m * b.c**2


@formula
def potential(z, Lz, L3, b):
    """Effective potential V(z, L_z, L_3) [J] of both heavy tops; L_z, L_3 about the tip. [T 2.38, 5.26]"""
    return L3**2 / (2 * b.I3) + (Lz - L3 * z) ** 2 / (2 * tip_inertia(b) * ((1 - z) * (1 + z))) - b.m * b.g * b.c * z

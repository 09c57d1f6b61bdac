"""The common state of a body whose contact may open, and what the plane does to it.

A jump from one phase to another takes and gives a `Moving`.
"""

from typing import Any, NamedTuple

from ..operand import Operand, Vector
from ..units import METRE_PER_SECOND


BALLS = ("body", "stem")
"""Parts that touch the plane; the position of a name is its number in a store."""

VELOCITY = dict.fromkeys(("rx_dot", "ry_dot", "rz_dot"), METRE_PER_SECOND)


class Moving(NamedTuple):
    """The common state: how a body lies and moves."""

    u: Vector  # 3hat
    L: Vector  # about the centre of mass
    velocity: Vector  # of the centre of mass
    height: Operand  # of the centre of mass
    carried: Any = ()  # the record of the integrals of the run


class Reaction(NamedTuple):
    """Force and torque of the plane on a body."""

    force: Vector
    drilled: Operand = 0  # power that torques of the contact take


def gained(x: Moving, **integrals: Any) -> Moving:
    """Return the state with more of some integrals."""
    more = {name: getattr(x.carried, name) + value for name, value in integrals.items()}
    return x._replace(carried=x.carried._replace(**more))

"""Ellipsoids with three moments of inertia: rattlebacks, and balls without an axis of symmetry.

`Ellipsoid` takes the numbers of the user; ELLIPSOID and ROLLING_ELLIPSOID are the `System`s, whose
formulas are those of `contact.framed`. `friction` is the record of a law.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

from ..contact import body as contact
from ..contact import framed
from ..contact.body import Top
from ..contact.frame import Asymmetric
from ..contact.frame import Ellipsoid as Outline
from ..number import Number, number, reuse
from ..operand import Vector, cos, sin
from ..units import INERTIA, METRE, RADIAN
from . import outlook
from .revolution import pair
from .tippe_top import TippeTop


CENTRE = "position of the centre along axis {} from the centre of mass"


OFF = ("delta", "x", "y", "h")
"""Numbers that are 0 in a uniform body."""


class Ellipsoid(Top):
    """An ellipsoid with half axes a, b, c, whose axes of inertia are turned against it by delta.

    Axes 1, 2 and 3 are the principal axes of inertia; half axis c lies along axis 3, and half axis
    a at the angle delta from axis 1. A rattleback is one, and so is a ball with three moments of
    inertia or with its centre of mass off the axis. Each number may be a text: with a unit, "5 g",
    or arithmetic of the others. By default the body is uniform.

    >>> import tippetop as tt
    >>> tt.Ellipsoid(m=1, a=0.2, b=0.03, c=0.02).I3
    0.00818
    >>> boat = tt.Ellipsoid(m=1, a=0.2, b=0.03, c=0.02, delta=0.01, h=0.01,
    ...                     I1=2e-4, I2=1.6e-3, I3=1.7e-3)
    """

    gliding = "ellipsoid"
    resting = "rolling-ellipsoid"

    m: Number = reuse(TippeTop.parameters["m"])
    a: Number = number(METRE, "half axis, at delta from axis 1", symbol="a", above=0)
    b: Number = number(METRE, "half axis, at delta from axis 2", symbol="b", above=0)
    c: Number = number(METRE, "half axis along axis 3", symbol="c", above=0)
    delta: Number = number(
        RADIAN,
        "angle of half axes a and b from axes 1 and 2, about axis 3",
        symbol=r"\delta",
        default=0.0,
    )
    x: Number = number(METRE, CENTRE.format(1), default=0.0)
    y: Number = number(METRE, CENTRE.format(2), default=0.0)
    h: Number = number(METRE, CENTRE.format(3), default=0.0)
    I1: Number = number(
        INERTIA,
        "moment of inertia about axis 1",
        symbol="I_1",
        above=0,
        default="m*(b^2 + c^2)/5",
        where_zero=OFF,
    )
    I2: Number = reuse(
        I1, long_name="moment of inertia about axis 2", symbol="I_2", default="m*(a^2 + c^2)/5"
    )
    I3: Number = reuse(
        I1, long_name="moment of inertia about axis 3", symbol="I_3", default="m*(a^2 + b^2)/5"
    )
    g: Number = reuse(TippeTop.parameters["g"], default=9.81)

    def seen(self, friction: Any) -> Asymmetric:
        """Return the body as the `b` of formulas, an `Asymmetric`, with the record of a law.

        `squares` are a11, a12, a22 and a33 of its outline, in this order: diag(a^2, b^2, c^2),
        turned by delta.
        """
        k, s = cos(self.delta), sin(self.delta)
        a2, b2 = self.a**2, self.b**2
        squares = a2 * k**2 + b2 * s**2, (a2 - b2) * k * s, a2 * s**2 + b2 * k**2, self.c**2
        shape = Outline(self.a, self.b, self.c, k, s, self.x, self.y, self.h, *squares)
        return Asymmetric(self.m, self.I1, self.I2, self.I3, self.g, friction, shape)

    @staticmethod
    def faults(parameters: Mapping[str, float]) -> list[str]:
        """Return sentences on moments of inertia, and on a centre of mass outside of the body.

        No moment exceeds the sum of the others. It is `System.checks`; `parameters` are in SI.
        """
        shape = Ellipsoid.body_of(parameters, ()).outline
        along = shape.half_axes(Vector(shape.x, shape.y, shape.z))
        halves = zip(along, shape[:3], strict=True)
        faults = contact.outside_faults(*(float(x) / float(half) for x, half in halves))
        return faults + contact.inertia_faults(parameters)


ELLIPSOID, ROLLING_ELLIPSOID = pair(
    Ellipsoid,
    "ellipsoid",
    framed.OF_SYSTEM | {"outlook": outlook.without_axis},
    framed.ROLLING | {"outlook": partial(outlook.without_axis, rolls=True)},
    source="Kane, T. R., Levinson, D. A.: Realistic mathematical modeling of the rattleback. "
    "Int. J. Non-Linear Mechanics 17, 175 (1982)",
)

"""Outlines of bodies of revolution, by the height of the centre of mass on the plane.

f(z) is that height at the inclination z = cos(theta). The body touches the plane as a ball, a
different one at each inclination: its radius is R = f - z f', its centre lies c = -f' along 3hat,
and f = R - c z. Positions, velocities, mobility and impulses are those of this ball; accelerations
depend also on its bend c'(z), which is zero for a sphere.
"""

from collections import namedtuple
from collections.abc import Callable, Iterable
from functools import reduce
from operator import mul
from typing import Any, NamedTuple, cast

import numpy as np

from ..operand import Operand, sqrt


class Series(namedtuple("Derivatives", "value first second third")):
    """A number and its first three derivatives by z, for + - * /, whole powers and roots."""

    __slots__ = ()

    def __add__(self, other: Operand) -> "Series":
        if not isinstance(other, Series):
            return self._replace(value=self.value + other)
        return Series(*(a + b for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: Operand) -> "Series":
        return self + other * -1

    def __mul__(self, other: Operand) -> "Series":
        if not isinstance(other, Series):
            return Series(*(a * other for a in self))
        (a, a1, a2, a3), (b, b1, b2, b3) = self, other
        return Series(
            a * b,
            a1 * b + a * b1,
            a2 * b + 2 * (a1 * b1) + a * b2,
            a3 * b + 3 * (a2 * b1 + a1 * b2) + a * b3,
        )

    def __truediv__(self, other: Operand) -> "Series":
        if not isinstance(other, Series):
            return Series(*(a / other for a in self))
        (a, a1, a2, a3), (b, b1, b2, b3) = self, other
        q = a / b
        q1 = (a1 - q * b1) / b
        q2 = (a2 - 2 * (q1 * b1) - q * b2) / b
        return Series(q, q1, q2, (a3 - 3 * (q2 * b1 + q1 * b2) - q * b3) / b)

    def __pow__(self, power: int) -> "Series":
        return reduce(mul, [self] * power)

    def __neg__(self) -> "Series":
        return self * -1

    def __rsub__(self, other: Operand) -> "Series":
        return self * -1 + other

    def __rtruediv__(self, other: Operand) -> "Series":
        return Series(other, 0, 0, 0) / self

    __radd__ = __add__
    __rmul__ = __mul__
    __array_ufunc__ = None  # arrays leave their arithmetic to it


def root(x: Series) -> Series:
    """Return the square root."""
    r = sqrt(x.value)
    first = x.first / (2 * r)
    second = (x.second - 2 * (first * first)) / (2 * r)
    return Series(r, first, second, (x.third - 6 * (first * second)) / (2 * r))


class Ball(NamedTuple):
    """The outline of a sphere, whose R and c are numbers of the body."""


class Bent(NamedTuple):
    """The outline of a body where it touches, and how its ball changes there."""

    shape: Any
    bend: Operand  # c'(z)
    twist: Operand  # c''(z)
    height: Operand  # R - c z, which cancels where a disc is nearly flat


class Spheroid(NamedTuple):
    """Half length a along the axis, half width b; the centre at c along 3hat."""

    a: Operand
    b: Operand
    c: Operand

    @property
    def size(self) -> Operand:
        """Return the size [m]."""
        return self.a + self.b

    def height(self, z: Series, s2: Series) -> Series:
        """Return the height of the centre of mass, by z and sin(theta)^2."""
        return root(z * z * self.a**2 + s2 * self.b**2) - z * self.c


class Rim(NamedTuple):
    """A circle of radius `ring` about the axis, rounded by `tube`; its centre at c along 3hat."""

    ring: Operand
    tube: Operand
    c: Operand

    @property
    def size(self) -> Operand:
        """Return the size [m]."""
        return self.ring + self.tube

    def height(self, z: Series, s2: Series) -> Series:
        """Return the height of the centre of mass, by z and sin(theta)^2."""
        return root(s2) * self.ring + self.tube - z * self.c


def at(z: Operand, s2: Operand, height: Callable) -> Series:
    """Return the height(z, s2) of an outline with its derivatives."""
    return height(Series(z, 1, 0, 0), Series(s2, -2 * z, -2, 0))


def shape_by(height: Callable, names: Iterable[str]) -> Any:
    """Return the type of the outlines of a height(z, s2, numbers), by the names of its numbers."""
    record: Any = cast(Any, namedtuple)("Numbers", names)

    class Shape(record):
        """A user-defined outline."""

        __slots__ = ()

        def height(self, z: Series, s2: Series) -> Series:
            """Return the height of the centre of mass, by z and sin(theta)^2."""
            return height(z, s2, record._make(self))

        @property
        def size(self) -> Operand:
            """Return the size [m]: half the width and half the length."""
            with np.errstate(all="ignore"):  # an outline that is not smooth is refused later
                places = np.array([0.0, 1.0, -1.0])
                across, up, down = (at(z, 1 - z * z, self.height).value for z in places)
            return across + (up + down) / 2

    return Shape

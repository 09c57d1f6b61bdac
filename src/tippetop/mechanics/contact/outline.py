"""Outlines of bodies of revolution, by the height of the centre of mass on the plane.

f(z) is that height at the inclination z = cos(theta). The body touches the plane as a ball, a
different one at each inclination: its radius is R = f - z f', its centre lies c = -f' along 3hat,
and f = R - c z. Positions, velocities, mobility and impulses are those of this ball; accelerations
depend also on its bend c'(z), which is zero for a sphere.
"""

from collections import namedtuple
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, cast

from ..dual import Dual
from ..operand import Operand, sqrt


class Series(Dual):
    """A number and its first three derivatives by z."""

    __slots__ = ()
    level = 2


def root(x: Series) -> Series:
    """Return the square root, for the height of an outline; `tippetop.extending` offers it.

    Parameters
    ----------
    x : Series
        Arithmetic of z and s2, greater than 0.

    Returns
    -------
    Series
    """
    return sqrt(x)


class Spheroid(NamedTuple):
    """Half length a along the axis, half width b; the centre at c along 3hat, all [m]."""

    a: Operand
    b: Operand
    c: Operand

    @property
    def size(self) -> Operand:
        """Return a length [m] by which small distances are measured."""
        return self.a + self.b

    def height(self, z: Series, s2: Series) -> Series:
        """Return the height of the centre of mass on the plane [m].

        z is cos(theta), s2 sin(theta)^2.
        """
        return root(z * z * self.a**2 + s2 * self.b**2) - z * self.c


class Rim(NamedTuple):
    """A circle of radius `ring` about the axis, rounded by `tube`; centre at c 3hat, all [m]."""

    ring: Operand
    tube: Operand
    c: Operand

    @property
    def size(self) -> Operand:
        """Return a length [m] by which small distances are measured."""
        return self.ring + self.tube

    def height(self, z: Series, s2: Series) -> Series:
        """Return the height of the centre of mass on the plane [m].

        z is cos(theta), s2 sin(theta)^2.
        """
        return root(s2) * self.ring + self.tube - z * self.c


def at(z: Operand, s2: Operand, height: Callable) -> Series:
    """Return height(z, s2) of an outline [m], as a Series with its derivatives by z.

    s2 is 1 - z^2, passed because the difference would lose digits near the poles. `height` gets
    both as Series, so it consists of their arithmetic and `root`.
    """
    return height(Series(z, 1, 0, 0), Series(s2, -2 * z, -2, 0))


def shape_by(height: Callable, names: Iterable[str]) -> Any:
    """Return the type of the outlines of a height(z, s2, numbers), by the names of its numbers.

    Their order is that in which `user_outline.body_by_height` fills an outline.
    """
    record: Any = cast(Any, namedtuple)("Numbers", names)

    class Shape(record):
        """A user-defined outline."""

        __slots__ = ()

        def height(self, z: Any, s2: Any) -> Any:
            """Return the height of the centre of mass [m], by z and s2 = sin(theta)^2."""
            return height(z, s2, record._make(self))

        @property
        def size(self) -> Operand:
            """Return the size [m]: half the width, the height if the axis is horizontal."""
            return self.height(0.0, 1.0)

    return Shape

"""Units as powers of mass, length and time, and the units in which a system is integrated.

`Scales.of(unit)` converts between SI and internal units; `problem.batch` makes the `Scales`.
"""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from ..errors import InputError
from .described import Described


POWERS = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "J": (1, 2, -2),
    "W": (1, 2, -3),
    "Pa": (1, -1, -2),
}
"""Powers of kg, m and s in the symbols of units."""
FACTOR = re.compile(rf"({'|'.join(POWERS)})(-?\d+)?")


@dataclass(frozen=True)
class Unit(metaclass=Described):
    """A unit by its symbol. Arithmetic and functions of units give the unit of the result.

    Parameters
    ----------
    symbol
        Product of powers of kg, m, s, rad, Hz, N, J, W and Pa, such as "kg m2 s-1"; "1" for none.
    """

    symbol: str

    def __post_init__(self) -> None:
        self.powers  # noqa: B018 - raises InputError if there are none

    @cached_property
    def powers(self) -> tuple[int, int, int]:
        """Return the exponents of kg, m and s. Raises InputError if the symbol is no unit."""
        matches = [FACTOR.fullmatch(part) for part in str(self.symbol).split()]
        factors = [(POWERS[m[1]], int(m[2] or 1)) for m in matches if m]
        if not matches or None in matches:
            raise InputError(
                f'`symbol` of a Unit must be powers of {", ".join(POWERS)}, such as "kg m2 s-1", '
                f"but is {self.symbol!r:.60}."
            )
        mass, length, time = (sum(n * powers[k] for powers, n in factors) for k in range(3))
        return mass, length, time

    def __mul__(self, other: Any) -> "Unit":
        """Return the unit of a product with a unit or a number."""
        return Unit(f"{self.symbol} {getattr(other, 'symbol', 1)}")

    def __pow__(self, power: int) -> "Unit":
        """Return the unit of a power, in kg, m and s."""
        return Unit("kg{} m{} s{}".format(*(power * n for n in self.powers)))

    def _same(self, *others: Any) -> "Unit":
        """Return this unit: +, -, and what NumPy's cos and sin call have no other.

        So formulas, called with units instead of numbers, return the unit of their result.
        """
        return self

    __rmul__ = __mul__
    __add__ = __sub__ = __neg__ = cos = sin = _same

    def arctan2(self, other: Any) -> "Unit":
        """Return the unit of an angle, for NumPy's arctan2."""
        return RADIAN


ONE = Unit("1")
RADIAN = Unit("rad")
RADIAN_PER_SECOND = Unit("rad s-1")
PER_SECOND = Unit("s-1")
PER_SECOND2 = Unit("s-2")
PER_METRE_SECOND = Unit("m-1 s-1")
SECOND = Unit("s")
SECOND_PER_METRE = Unit("s m-1")
KILOGRAM = Unit("kg")
METRE = Unit("m")
METRE_PER_SECOND = Unit("m s-1")
METRE_PER_SECOND2 = Unit("m s-2")
INERTIA = Unit("kg m2")
ANGULAR_MOMENTUM = Unit("kg m2 s-1")
JELLETT = Unit("kg m3 s-1")
JOULE = Unit("J")
WATT = Unit("W")
NEWTON = Unit("N")
NEWTON_SECOND = Unit("N s")


class Scales(NamedTuple):
    """The units of mass [kg], length [m] and time [s] in which a system is integrated."""

    mass: Any
    length: Any
    time: Any

    def of(self, unit: Unit) -> Any:
        """Return how many SI units one internal unit of `unit` is.

        Parameters
        ----------
        unit
            The unit that is converted.

        Returns
        -------
        number or array
            mass^a length^b time^c with the powers of the unit, of the shape of the scales.
        """
        mass, length, time = unit.powers
        return self.mass**mass * self.length**length * self.time**time

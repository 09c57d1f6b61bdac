"""Units as powers of mass, length and time, and the units in which a system is integrated."""

import re
from dataclasses import dataclass
from functools import reduce
from operator import mul
from typing import Any, NamedTuple

from ..errors import InputError


@dataclass(frozen=True)
class Unit:
    """A unit as powers of mass, length and time, with the SI symbol that people read.

    Parameters
    ----------
    mass, length, time
        The powers, as of kg, m and s.
    symbol
        What people read, such as "kg m2 s-1".
    """

    mass: int
    length: int
    time: int
    symbol: str

    def __post_init__(self) -> None:
        powers = (self.mass, self.length, self.time)
        if not all(isinstance(power, int) and not isinstance(power, bool) for power in powers):
            raise InputError(
                [
                    "the powers of a Unit must be whole numbers, but are "
                    f"{', '.join(map(repr, powers))}."
                ]
            )
        if not isinstance(self.symbol, str) or not self.symbol.strip():
            raise InputError([f"`symbol` of a Unit must be a text, but is {self.symbol!r:.60}."])
        if (meant := _powers(self.symbol)) not in (None, powers):
            raise InputError(
                [f'the powers of a Unit "{self.symbol}" must be {meant}, but are {powers}.']
            )


KNOWN = {
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
"""Powers of kg, m and s in the symbols that this package knows."""


def _powers(symbol: str) -> tuple[int, int, int] | None:
    """Return the powers of kg, m and s in a symbol such as "kg m2 s-1".

    None of one that has parts which are not known.
    """
    powers = [0, 0, 0]
    for part in symbol.split():
        match = re.fullmatch(r"([A-Za-z]+|1)(-?\d+)?", part)
        if match is None or match[1] not in KNOWN:
            return None
        powers = [
            total + int(match[2] or 1) * each
            for total, each in zip(powers, KNOWN[match[1]], strict=True)
        ]
    return powers[0], powers[1], powers[2]


ONE = Unit(0, 0, 0, "1")
RADIAN = Unit(0, 0, 0, "rad")
RADIAN_PER_SECOND = Unit(0, 0, -1, "rad s-1")
PER_SECOND = Unit(0, 0, -1, "s-1")
PER_METRE_SECOND = Unit(0, -1, -1, "m-1 s-1")
SECOND = Unit(0, 0, 1, "s")
SECOND_PER_METRE = Unit(0, -1, 1, "s m-1")
KILOGRAM = Unit(1, 0, 0, "kg")
METRE = Unit(0, 1, 0, "m")
METRE_PER_SECOND = Unit(0, 1, -1, "m s-1")
METRE_PER_SECOND2 = Unit(0, 1, -2, "m s-2")
INERTIA = Unit(1, 2, 0, "kg m2")
ANGULAR_MOMENTUM = Unit(1, 2, -1, "kg m2 s-1")
JELLETT = Unit(1, 3, -1, "kg m3 s-1")
JOULE = Unit(1, 2, -2, "J")
WATT = Unit(1, 2, -3, "W")
NEWTON = Unit(1, 1, -2, "N")
NEWTON_SECOND = Unit(1, 1, -1, "N s")


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
        powers = zip(self, (unit.mass, unit.length, unit.time), strict=True)
        factors = [scale if power == 1 else scale**power for scale, power in powers if power]
        return reduce(mul, factors) if factors else self.mass**0

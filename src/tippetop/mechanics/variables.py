"""Variables of an integrator: the state that moves, then the integrals, scaled.

A form goes in; `split` and `join` convert between the flat list of variables, which integrators and
stores have, and the records q and carried, which formulas take. Only this module depends on the
scale of integrals.

Symbols
    q         the record of the state of a form; carried: that of its integrals
    b         the body; s, z: sin(theta), cos(theta) at the start
"""

from collections import namedtuple
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .caching import cached_property
from .system import Form, Integral
from .units import Scales, Unit


INTEGRAL_SCALE = 2.0**-32
"""Factor on integrals among the variables: too small to control the step; a power of two, so that
it costs no bit.
"""


@dataclass(frozen=True)
class Variables:
    """The variables of an integrator: the state of a form, then its integrals times INTEGRAL_SCALE.

    Parameters
    ----------
    form
        The form that is integrated.
    orientation
        Whether what the orientation of the body needs is integrated too; it comes last.
    """

    form: Form
    orientation: bool = True

    @cached_property
    def integrals(self) -> tuple[Integral, ...]:
        """Return the integrals that are integrated with the state, those of the orientation last.

        Their order is that of stored states.
        """
        turning = (
            self.form.orientation.integrals if self.orientation and self.form.orientation else ()
        )
        return (*self.form.integrals, *turning)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """Return the unit of each variable, by name, in order."""
        return {
            **self.form.units._asdict(),
            **{integral.name: integral.unit for integral in self.integrals},
        }

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the names of the variables, in order."""
        return tuple(self.units)

    @property
    def moving(self) -> int:
        """Return the number of variables of the state q; they come first, before the integrals."""
        return len(self.form.units)

    @cached_property
    def carried(self) -> Any:
        """Return the type of the record of the integrals."""
        return _record(tuple(integral.name for integral in self.integrals))

    def split(self, values: Any) -> tuple[Any, Any]:
        """Split variables into the records of the state and of the integrals.

        Parameters
        ----------
        values
            A sequence or an array whose first axis is the variables, perhaps with others behind:
            numbers, arrays or expressions.
        """
        n = self.moving
        return type(self.form.units)(*values[:n]), self.carried(
            *(v / INTEGRAL_SCALE for v in values[n : len(self.names)])
        )

    def join(self, q: Sequence, carried: Sequence) -> list:
        """Join state and integrals, or their rates, to variables: the inverse of `split`."""
        return [*q, *(INTEGRAL_SCALE * v for v in carried)]

    def rates(self, q: Any, carried: Any, b: Any) -> list:
        """Return the time derivatives of the variables, in their order."""
        return self.join(
            self.form.rates(q, b), [integral.rate(q, carried, b) for integral in self.integrals]
        )

    def start(self, data: dict[str, Any], angles: Any, s: Any, z: Any, b: Any) -> tuple[Any, Any]:
        """Return the records q and carried at the start, in the units of the initial `data`."""
        carried = [
            integral.start(data, s, z) if integral.start else getattr(angles, integral.name, 0 * z)
            for integral in self.integrals
        ]
        return self.form.of_angles(angles, s, z, b), self.carried(*carried)

    def weights(self, scales: Scales) -> list:
        """Return the SI value of one internal unit of each variable."""
        units = [scales.of(unit) for unit in self.units.values()]
        # of the type of the units: a float and a number in quad precision cannot be combined
        small = np.asarray(units[0]).dtype.type(INTEGRAL_SCALE)
        return [*units[: self.moving], *(unit / small for unit in units[self.moving :])]

    def coefficients(self, name: str, coefficients: Any) -> Any:
        """Return the Taylor coefficients (n, order + 1) of an integral.

        `coefficients` are those of all variables, (n, variables, order + 1).
        """
        with np.errstate(over="ignore"):  # wider numbers, where a motion ends in a singularity
            return coefficients[:, self.names.index(name)].astype(float) / INTEGRAL_SCALE


variables_of = lru_cache(maxsize=256)(Variables)
"""Returns the same `Variables` for the same form: their names and units are derived once."""


@lru_cache
def _record(names: tuple[str, ...]) -> Any:
    """Return a record with these fields: the same type for the same names."""
    return namedtuple("Carried", names)

"""The body of a landscape: parameters in SI become coefficients of V, rounded once.

`top` is the entrance; all functions of the landscape take its result, as `t`.
"""

import decimal
from collections.abc import Mapping
from dataclasses import dataclass

from ..errors import InputError
from ..mechanics.contact import body as contact
from ..mechanics.friction import Frictionless
from ..mechanics.operand import refill
from ..mechanics.potential_coefficients import PotentialCoefficients, rounded
from ..mechanics.system import Landscape, System
from ..mechanics.systems import SYSTEMS, find


SPINNING = ("D", "lambda")  # the momenta over which spinning states are lines
DIGITS = 50  # of the constants before they are rounded: the marked lines cancel


@dataclass(frozen=True)
class Top:
    """A body with the numbers from which the kernels compute its potential: `t` of other modules.

    `top` makes it from the parameters of a system.
    """

    system: System
    landscape: Landscape
    parameters: dict[str, float]  # SI
    coefficients: PotentialCoefficients
    body: contact.Touch  # SI
    two_wells: bool  # V can have two minima

    @property
    def momenta(self) -> tuple[str, str]:
        """Return the symbols of the two momenta: ("D", "lambda") or ("L3", "Lz")."""
        return self.landscape.symbols

    def require_spinning(self) -> None:
        """Raise InputError unless the momenta are D and lambda, which marked lines require."""
        if self.momenta != SPINNING:
            raise InputError(
                f"D and lambda belong to tippe tops only; this is `{self.system.name}`."
            )

    @property
    def bottom_z(self) -> int:
        """Return z = cos(theta) where the centre of mass is lowest: exactly 1 (c > 0) or -1.

        It is the pole q = 0 of the variable q of `formulas`; c is the offset of the ball's centre
        from the centre of mass along the axis (negative for heavy tops and pegs). Callers use it as
        a sign, an exponent and a slice step, so it must be the integer 1 or -1.
        """
        return 1 if self.body.c > 0 else -1


def top(parameters: Mapping[str, float], system: str | System = "tippe-top") -> Top:
    """Return the body of a system, its constants taken with 50 digits, then rounded once.

    Parameters
    ----------
    parameters
        The numbers of the system, SI, by name.
    system
        A system that has a landscape, or its name.

    Raises
    ------
    InputError
        For a system without landscape, and for parameters that its record does not allow.
    """
    record = find(system) if isinstance(system, str) else system
    if record is not None and record.contact is not None:
        record = find(record.name)  # a system whose contact may open has no landscape itself
    if record is None or record.landscape is None:
        known = ", ".join(name for name, s in SYSTEMS.items() if s.landscape is not None)
        name = system if isinstance(system, str) else system.name
        raise InputError(
            f"the system must be one of {known}, which have a landscape, but is {name}."
        )
    landscape = record.landscape
    given = {name: float(value) for name, value in parameters.items()}
    if faults := record.faults(given):
        raise InputError(faults)
    with decimal.localcontext(prec=DIGITS):
        exact = record.body_of(given, Frictionless(), decimal.Decimal)
        coefficients = rounded(landscape.coefficients(exact))
    body = refill(exact, map(float, exact[:-1]))  # the last field is the friction law
    two_wells = landscape.two_wells is not None and bool(landscape.two_wells(body))
    return Top(record, landscape, given, coefficients, body, two_wells)

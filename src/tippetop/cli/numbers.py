"""Numbers of the command line: whole ones, and texts with units.

cyclopts would round a fraction that is given for a whole number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

from ..errors import InputError
from ..mechanics.units import ANGULAR_MOMENTUM, JELLETT, SECOND, Unit


def number_in(text: str, option: str, unit: Unit) -> float:
    """Return a number, arithmetic, or a number with a unit, in SI units. Raises InputError."""
    try:
        return float(text)
    except ValueError:
        from ..mechanics.quantity import number_of

        try:
            return number_of(text, option, unit)
        except InputError as error:
            raise InputError([s.replace(f"`{option}`", option) for s in error.sentences]) from None


def _whole(_: Any, tokens: Sequence[Token]) -> int:
    """Return the whole number that is written. Raises InputError."""
    text, option = tokens[0].value, tokens[0].keyword
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{option} must be a whole number, but is `{text}`.") from None


def _in(unit: Unit) -> Callable[[Any, Sequence[Token]], float]:
    """Return a converter to a unit."""
    return lambda _, tokens: number_in(tokens[0].value, str(tokens[0].keyword), unit)


Whole = Annotated[int, Parameter(converter=_whole)]
Seconds = Annotated[float, Parameter(converter=_in(SECOND))]
Routh = Annotated[float, Parameter(converter=_in(ANGULAR_MOMENTUM), allow_leading_hyphen=True)]
Jellett = Annotated[float, Parameter(converter=_in(JELLETT), allow_leading_hyphen=True)]

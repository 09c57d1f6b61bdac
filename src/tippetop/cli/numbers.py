"""Numbers of the command line: whole ones (a fraction is refused, where cyclopts would round it), and times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

from ..errors import InputError


def _whole(_: Any, tokens: Sequence[Token]) -> int:
    """The number that is written. Raises InputError."""
    text, option = tokens[0].value, tokens[0].keyword
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{option} must be a whole number, but is `{text}`.") from None


def _seconds(_: Any, tokens: Sequence[Token]) -> float:
    """The time that is written [s]: a number, arithmetic, or a number with a unit. Raises InputError."""
    text, option = tokens[0].value, str(tokens[0].keyword)
    try:
        return float(text)
    except ValueError:
        from ..mechanics.quantity import number_of
        from ..mechanics.units import SECOND

        try:
            return number_of(text, option, SECOND)
        except InputError as error:
            raise InputError([s.replace(f"`{option}`", option) for s in error.sentences]) from None


Whole = Annotated[int, Parameter(converter=_whole)]
Seconds = Annotated[float, Parameter(converter=_seconds)]

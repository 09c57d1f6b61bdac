"""Types of arguments: whole numbers, quantities with units, and paths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter, Token

from ..arguments import measured, path_of, positive_integer
from ..errors import InputError
from ..mechanics.units import ANGULAR_MOMENTUM, JELLETT, ONE, SECOND, Unit


def _read(read: Callable[[str, str], Any], hyphen: bool = True) -> Parameter:
    """Declare an argument of the command line that read(name, text) turns into its value.

    `hyphen`: whether the text may begin with a hyphen, as a negative number does.
    """

    def convert(_: Any, tokens: Sequence[Token]) -> Any:
        """Return the value of an argument of the command line."""
        return read(tokens[0].keyword or "the argument", tokens[0].value)

    return Parameter(converter=convert, allow_leading_hyphen=hyphen)


def _in(unit: Unit) -> Parameter:
    """Declare a quantity in a unit; it may be negative."""
    return _read(lambda name, text: measured(name, text, unit))


def sides(text: str, example: str) -> tuple[float, float]:
    """Return width and height of WxH, such as the example. Raises InputError."""
    try:
        width, height = map(float, text.lower().split("x"))
    except ValueError:
        raise InputError(
            f"--size must be width x height, such as {example}, but is `{text}`."
        ) from None
    return width, height


Whole = Annotated[int, _read(lambda name, text: positive_integer(name, measured(name, text, ONE)))]
Seconds = Annotated[float, _in(SECOND)]
Routh = Annotated[float, _in(ANGULAR_MOMENTUM)]
Jellett = Annotated[float, _in(JELLETT)]
Place = Annotated[Path, _read(path_of, hyphen=False)]

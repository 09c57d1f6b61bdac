"""Whole numbers of the command line: a fraction is refused, where cyclopts would round it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

from ..errors import InputError


def _converted(_: Any, tokens: Sequence[Token]) -> int:
    """The number that is written. Raises InputError."""
    text, option = tokens[0].value, tokens[0].keyword
    try:
        return int(text)
    except ValueError:
        raise InputError([f"{option} must be a whole number, but is `{text}`."]) from None


Whole = Annotated[int, Parameter(converter=_converted)]

"""Arguments of the library, checked one by one: a fault is one sentence that names the argument."""

import math
import os
from pathlib import Path
from typing import Any

from .errors import InputError


def finite(name: str, value: Any) -> float:
    """The argument as a float. Raises InputError if it is no finite number."""
    try:
        number = math.nan if isinstance(value, str | bytes | bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError([f"`{name}` must be a finite number, but is {value!r:.60}."])
    return number


def whole(name: str, value: Any) -> int:
    """The argument as an int of at least 1. Raises InputError."""
    try:
        number = finite(name, value)
    except InputError:
        number = 0.0
    if number < 1 or not number.is_integer():
        raise InputError([f"`{name}` must be a whole number, at least 1, but is {value!r:.60}."])
    return int(number)


def path_of(name: str, value: Any) -> Path:
    """The argument as a path. Raises InputError if it is none."""
    if not isinstance(value, str | os.PathLike) or not str(value):
        raise InputError([f"`{name}` must be a path, but is {value!r:.60}."])
    return Path(value)


def instance(name: str, value: Any, kind: type, words: str) -> None:
    """Raises InputError if the argument is not of this kind; `words` say what it must be."""
    if not isinstance(value, kind):
        raise InputError([f"`{name}` must be {words}, but is {value!r:.60}."])

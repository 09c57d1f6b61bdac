"""Numbers as JSON keeps them without losing a bit: hexadecimal floats, wider ones as a sum of several."""

from typing import Any

import numpy as np


def packed(value: Any) -> Any:
    """A tree of dicts, lists, numbers and arrays of any precision as plain JSON data."""
    if isinstance(value, dict):
        return {key: packed(v) for key, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [packed(v) for v in value]
    if value is None or isinstance(value, bool | int | str | np.integer):
        return int(value) if isinstance(value, np.integer) else value
    return parts(value)


def parts(value: Any) -> str:
    """A float of any precision as hexadecimal doubles that add up to it exactly."""
    high = float(value)
    if not np.isfinite(high):
        return high.hex()
    pieces = [high]
    while (rest := float(value := value - high)) != 0.0:
        pieces.append(rest)
        high = rest
    return " ".join(piece.hex() for piece in pieces)


def number(text: str, kind: Any = float) -> Any:
    """The float that `parts` wrote."""
    pieces = [kind(float.fromhex(piece)) for piece in text.split()]
    total = pieces[0]
    for piece in pieces[1:]:
        total = total + piece
    return total


def unpacked(value: Any) -> Any:
    """What `packed` made, with strings of hexadecimal doubles as floats again."""
    if isinstance(value, dict):
        return {key: unpacked(v) for key, v in value.items()}
    if isinstance(value, list):
        return [unpacked(v) for v in value]
    if isinstance(value, str) and value.lstrip("-").startswith(("0x", "inf", "nan")):
        return number(value)
    return value

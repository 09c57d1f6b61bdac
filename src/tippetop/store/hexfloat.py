"""Numbers as JSON keeps them without losing a bit: hexadecimal floats, wider ones as a sum of
several.
"""

from typing import Any

import numpy as np


def encode(value: Any) -> Any:
    """A tree of dicts, lists, numbers and arrays of any precision as plain JSON data."""
    if isinstance(value, dict):
        return {key: encode(v) for key, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [encode(v) for v in value]
    if value is None or isinstance(value, bool | int | str | np.integer):
        return int(value) if isinstance(value, np.integer) else value
    return to_hex(value)


def to_hex(value: Any) -> str:
    """A float of any precision as hexadecimal doubles that add up to it exactly."""
    high = float(value)
    if not np.isfinite(high):
        return high.hex()
    pieces = [high]
    while (rest := float(value := value - high)) != 0.0:
        pieces.append(rest)
        high = rest
    return " ".join(piece.hex() for piece in pieces)


def from_hex(text: str, kind: Any = float) -> Any:
    """The float that `to_hex` wrote."""
    pieces = [kind(float.fromhex(piece)) for piece in text.split()]
    total = pieces[0]
    for piece in pieces[1:]:
        total = total + piece
    return total


def decode(value: Any) -> Any:
    """What `encode` made, with strings of hexadecimal doubles as floats again."""
    if isinstance(value, dict):
        return {key: decode(v) for key, v in value.items()}
    if isinstance(value, list):
        return [decode(v) for v in value]
    if isinstance(value, str) and value.lstrip("-").startswith(("0x", "inf", "nan")):
        return from_hex(value)
    return value

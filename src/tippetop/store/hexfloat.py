"""Encode numbers in JSON without loss: as hexadecimal doubles, wider ones as sums of them.

Snapshots of runs in a store use it, so that a resumed run has the same bits.
"""

import re
from typing import Any

import numpy as np


FLOAT = re.compile(r"-?(0x|inf$|nan$)")


def encode(value: Any) -> Any:
    """Return a tree of dicts, lists, numbers and arrays of any precision as plain JSON data.

    Floats become texts as of `to_hex`; integers, texts and None stay. `decode` reads it. Tails and
    ends of stored runs contain it, so old texts must stay readable.
    """
    if isinstance(value, dict):
        return {key: encode(v) for key, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [encode(v) for v in value]
    if value is None or isinstance(value, int | str | np.integer):
        return int(value) if isinstance(value, np.integer) else value
    return to_hex(value)


def to_hex(value: Any) -> str:
    """Return a float of any precision as text: hexadecimal doubles that add up to it exactly."""
    pieces = [float(value)]
    while np.isfinite(pieces[-1]) and (value := value - pieces[-1]) != 0.0:
        pieces.append(float(value))
    return " ".join(map(float.hex, pieces))


def from_hex(text: str, kind: Any = float) -> Any:
    """Return the float of type `kind`, such as numpy.longdouble, that `to_hex` wrote."""
    first, *rest = (kind(float.fromhex(piece)) for piece in text.split())
    return sum(rest, first)


def decode(value: Any) -> Any:
    """Return the data that `encode` wrote, with hexadecimal doubles as floats again.

    Numbers wider than doubles become doubles: for those call `from_hex`. Arrays become lists. Other
    texts, such as names of phases, are returned unchanged unless `FLOAT` matches them.
    """
    if isinstance(value, dict):
        return {key: decode(v) for key, v in value.items()}
    if isinstance(value, list):
        return [decode(v) for v in value]
    if isinstance(value, str) and FLOAT.match(value):
        return from_hex(value)
    return value

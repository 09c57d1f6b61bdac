"""Named columns in SI units, as the store and a Dataset keep them."""

from typing import Any, NamedTuple

import numpy as np

from .mechanics.units import Unit


class Column(NamedTuple):
    """An array with the names of its dimensions and its attributes (units, long_name, ...), as the store keeps it."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: dict[str, Any]


def column(values: np.ndarray, unit: Unit, long_name: str, dims: Any = ("time",), **extra: str) -> Column:
    return Column(dims, np.asarray(values, dtype=np.float64), {"units": unit.symbol, "long_name": long_name, **extra})


def flag_attributes(names: tuple[str, ...], text: str) -> dict[str, Any]:
    return {"flag_values": list(range(len(names))), "flag_meanings": " ".join(names), "long_name": text, "units": "1"}

"""How the landscape's arguments are checked and its results labelled: axes, units, long names, CF
flags.
"""

from collections.abc import Iterable
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from ..arguments import numbers
from ..errors import InputError
from ..mechanics.system import Momentum
from .body import Top


NAMES = {
    "z": ("1", "z = cos(theta)"),
    "theta": ("rad", "inclination theta of the axis"),
    "V": ("J", "effective potential V"),
    "F": ("J", "minimal surface F, infimum of V over z"),
}


def axis(name: str, values: Any) -> np.ndarray:
    """A grid axis, (n,): one-dimensional, not empty, ascending; NaN and infinities are let through,
    as points without answer. It is contiguous: for each way in which an array lies in memory,
    kernels would be compiled anew.

    Raises
    ------
    InputError
        With one sentence, if it is not.
    """
    x = np.ascontiguousarray(np.atleast_1d(numbers(name, values)))
    if x.ndim != 1 or x.size == 0:
        raise InputError(
            [f"`{name}` must be a number or a one-dimensional array that is not empty: {x.shape}."]
        )
    known = x[np.isfinite(x)]
    if np.any(np.diff(known) <= 0):
        raise InputError([f"`{name}` must ascend, but does not."])
    return x


def at_numbers(grid: xr.Dataset, arguments: Iterable[tuple[str, Any]]) -> xr.Dataset:
    """A grid over named axes, of which those that were given as numbers are no dimensions."""
    return grid.isel({name: 0 for name, value in arguments if np.ndim(value) == 0})


def attributes(t: Top, **more: Any) -> dict[str, Any]:
    """The attributes of a Dataset: the system, its parameters in SI, and more."""
    return {
        "system": t.system.name,
        **{f"parameter_{k}": v for k, v in t.parameters.items()},
        **more,
    }


def labelled(
    name: str, dims: Any, values: Any, units: str | None = None, long_name: str | None = None
) -> tuple:
    """A variable with its unit and meaning."""
    known = NAMES.get(name, ("1", name))
    return dims, values, {"units": units or known[0], "long_name": long_name or known[1]}


def of_momentum(m: Momentum, dims: Any, values: Any) -> tuple:
    """A variable that is one of the two momenta."""
    return labelled(m.symbol, dims, values, m.unit.symbol, m.long_name)


def flags(kind: type[IntEnum], long_name: str) -> dict[str, Any]:
    """The CF attributes of an enumeration."""
    return {
        "long_name": long_name,
        "flag_values": np.array([int(k) for k in kind], dtype=np.int8),
        "flag_meanings": " ".join(k.name.lower() for k in kind),
    }


def cosine(q: np.ndarray, upright: int) -> np.ndarray:
    """z = cos(theta) of q; an end of the range of q is the pole itself.

    Parameters
    ----------
    q
        tan(theta/2)^2 if upright is 1, its inverse if -1.
    upright
        z = cos(theta) at q = 0.

    Returns
    -------
    array
        Of the shape of q, in [-1, 1].
    """
    return upright * ((1 - q) / (1 + q))


def inclination(q: np.ndarray, upright: int) -> np.ndarray:
    """Theta of q [rad], with all digits near theta = 0 too.

    Parameters
    ----------
    q, upright
        As for `cosine`.

    Returns
    -------
    array
        Of the shape of q, in [0, pi].
    """
    return 2 * np.arctan(np.sqrt(q) if upright == 1 else 1 / np.sqrt(q))

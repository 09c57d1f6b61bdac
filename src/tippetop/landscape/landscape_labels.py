"""Check the arguments of the landscape and label its results: axes, units, long names, CF flags.

t is the body, a `landscape_body.Top`; variables are tuples (dimensions, values, attributes), of
which xarray makes Datasets.
"""

from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from ..arguments import numbers
from ..columns import flag_attributes
from ..errors import InputError
from .landscape_body import Top


def axis(name: str, values: Any) -> np.ndarray:
    """Return a grid axis, (n,): not empty, ascending. Raises InputError.

    NaN and infinities are passed on, as points without a result.
    The array is contiguous: kernels are compiled anew for every other memory layout.
    """
    x = np.ascontiguousarray(np.atleast_1d(numbers(name, values)))
    if x.ndim != 1 or x.size == 0:
        raise InputError(
            f"`{name}` must be a number or a one-dimensional array that is not empty: {x.shape}."
        )
    if np.any(np.diff(x[np.isfinite(x)]) <= 0):
        raise InputError(f"`{name}` must ascend, but does not.")
    return x


def labelled(dims: Any, values: Any, units: str, long_name: str) -> tuple:
    """Return a variable of a Dataset: (dims, values, attributes) with its unit and meaning."""
    return dims, values, {"units": units, "long_name": long_name}


def momenta(t: Top, *values: Any, dims: Any = None) -> dict[str, tuple]:
    """Return the values of the two momenta as labelled variables, by symbol.

    Each is an axis, along itself; with `dims`, the first one lies along these instead: D of
    `marked_lines`, which depends on lambda.
    """
    return {
        m.symbol: labelled(over or m.symbol, v, m.unit.symbol, m.long_name)
        for m, v, over in zip(t.landscape.momenta, values, (dims, None), strict=True)
    }


def attributes(t: Top) -> dict[str, Any]:
    """Return the attributes of a Dataset: `system`, and `parameter_NAME` for each number, SI."""
    return {
        "system": t.system.name,
        **{f"parameter_{name}": value for name, value in t.parameters.items()},
    }


def grid(t: Top, data: dict[str, Any], axes: dict[str, Any], given: tuple[Any, ...]) -> xr.Dataset:
    """Return data over axes as a Dataset without the dimensions of axes that are single numbers.

    `given` are the arguments of the user for the axes, in the order of `axes`, which may have
    further coordinates after them.
    """
    numbers = {name: 0 for name, value in zip(axes, given, strict=False) if np.ndim(value) == 0}
    return xr.Dataset(data, axes, attributes(t)).isel(numbers)


def flags(kind: type[IntEnum], long_name: str) -> dict[str, Any]:
    """Return the CF attributes of a variable whose values are those of an enumeration from 0 on."""
    return flag_attributes(tuple(k.name.lower() for k in kind), long_name)


def cosine(q: np.ndarray, bottom_z: int) -> np.ndarray:
    """Return cos(theta) of q, an array, by `Top.bottom_z`: z = cos(theta) at q = 0, 1 or -1.

    q is tan(theta/2)^2 if that is 1, and cot(theta/2)^2 if it is -1.
    """
    with np.errstate(invalid="ignore"):
        return bottom_z * np.where(np.isinf(q), -1.0, (1 - q) / (1 + q))


def inclination(q: np.ndarray, bottom_z: int) -> np.ndarray:
    """Return theta of q [rad], with all digits also near theta = 0; arguments as of `cosine`."""
    with np.errstate(divide="ignore"):
        return 2 * np.arctan(np.sqrt(q) if bottom_z == 1 else 1 / np.sqrt(q))

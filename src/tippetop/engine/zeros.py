"""Zeros of event functions: as the integrator finds them, and by bisection where it does not."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class Zero(NamedTuple):
    """A zero of an event function: internal time, kind, and the sign of the crossing (+1 rising)."""

    time: Any
    kind: str
    sign: int


def sign_changes(function: Callable[[np.ndarray], np.ndarray], grid: np.ndarray) -> list[tuple[float, int]]:
    """Where a function changes sign between neighbouring points of a grid, and the sign that it then has.

    Parameters
    ----------
    function
        Of an array (k,), with values (k,).
    grid
        Ascending, (n,).

    Returns
    -------
    list of (float, int)
        Place and sign, ascending.

    Notes
    -----
    Bisected until the two numbers are neighbours; the later one is given.
    """
    values, changes = function(grid), []
    for i in np.flatnonzero(values[1:] * values[:-1] < 0):
        low, high, sign = float(grid[i]), float(grid[i + 1]), int(np.sign(values[i + 1]))
        while (middle := (low + high) / 2) not in (low, high):
            beyond = function(np.array([middle]))[0] * sign > 0
            low, high = (low, middle) if beyond else (middle, high)
        changes.append((high, sign))
    return changes

"""The search of the compiled loop for zeros, extremes and bounds of polynomials, called with arrays."""

import ctypes

import numpy as np

from tippetop.engine.loop import TABLES, filled, library


_TABLES = filled(TABLES)


def crossings(p: np.ndarray, positive: bool, monotone: bool = False) -> tuple[np.ndarray, bool]:
    """Return the zeros of p on [0, 1) where it changes sign, and whether it is positive at the end."""
    zeros = np.empty(64)
    count = library().loop_crossings(_data(p), len(p), positive, monotone, ctypes.byref(_TABLES), _data(zeros))
    return zeros[:count], positive ^ bool(count % 2)


def extremes(p: np.ndarray, low: float, high: float, monotone: bool = False) -> tuple[float, ...]:
    """Return the least and the greatest of these values and those of p on [0, 1], and where p has them, else NaN."""
    found, real = np.empty(4), ctypes.c_double
    library().loop_extremes(_data(p), len(p), real(low), real(high), monotone, ctypes.byref(_TABLES), _data(found))
    return tuple(found.tolist())


def ranges(c: np.ndarray, shift: int, factors: np.ndarray) -> np.ndarray:
    """Return low, high and monotone of polynomials with coefficients c[k + shift]*factors[k], (3, lanes)."""
    lanes = c.shape[1]
    found, sums = np.empty((2, 3, lanes))
    c, factors = np.ascontiguousarray(c), np.ascontiguousarray(factors)
    library().loop_ranges(*map(ctypes.c_int64, (lanes, len(factors), shift)), *map(_data, (c, factors, sums, *found)))
    return found


def _data(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)

"""Long curves made short without loss of a peak.

Times and values of a curve go in; fewer of them come out.
"""

import numpy as np

from ..sampling import extremes


# More points cannot be seen
MOST_POINTS = 40_000
# Bins of a curve of worst values
BINS = 250


def thinned(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return at most MOST_POINTS points of a curve: the least and the greatest of each bin."""
    if len(t) <= MOST_POINTS:
        return t, values
    pick = extremes(values, -(-len(t) // (MOST_POINTS // 2)))
    return t[pick], values[pick]


def every(count: int) -> slice:
    """Return the slice that takes at most MOST_POINTS of this many rows."""
    return slice(None, None, max(1, -(-count // MOST_POINTS)))


def worst(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest value in each of BINS equal parts of the run, with times [s]."""
    edges = np.unique(np.linspace(0, len(t), min(BINS, len(t)) + 1).astype(int))[:-1]
    return t[edges], np.maximum.reduceat(values, edges)


def span(times: np.ndarray) -> tuple[float, float]:
    """Return the limits of an axis over these times, at least one."""
    first = float(times.min())
    last = float(times.max())
    return (first, last) if first < last else (-1.0, 1.0)

"""Long curves made short: no peak is lost, and no more points are drawn than can be seen."""

import numpy as np

from ..sampling import extremes


MOST_POINTS = (
    40_000  # more cannot be seen; beyond it the smallest and largest of each bin are drawn
)
BINS = 250  # of a curve that shows the worst of each


def thinned(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve with at most MOST_POINTS points: smallest and largest of each bin."""
    if len(t) <= MOST_POINTS:
        return t, values
    pick = extremes(values, -(-len(t) // (MOST_POINTS // 2)))
    return t[pick], values[pick]


def worst(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest value of each of BINS stretches of the run."""
    edges = np.unique(np.linspace(0, len(t), min(BINS, len(t)) + 1).astype(int))[:-1]
    return t[edges], np.maximum.reduceat(values, edges)


def span(t: np.ndarray) -> tuple[float, float]:
    """The limits of an axis over these times."""
    return (float(t[0]), float(t[-1])) if len(t) > 1 and t[-1] > t[0] else (-1.0, 1.0)

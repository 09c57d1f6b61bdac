"""How fast small errors of the start grow, top by top: finite-time Lyapunov exponents of an
ensemble.
"""

import numpy as np

from ..engine.derivatives.growth import growth
from ..problem import Problems
from .singly import problem_of


def exponents(tops: Problems, ends: np.ndarray) -> np.ndarray:
    """The exponent of each top up to its end [1/s], (n,), one top after the other: that of
    `growth`, bit by bit.

    Parameters
    ----------
    tops
        Whose errors grow.
    ends
        Of their runs [s], (n,); the exponent of a top that has none, or ends at its start, is NaN.
    """
    rates = np.full(tops.n, np.nan)
    going = np.flatnonzero(tops.valid & (ends > 0))
    for top in going.tolist():
        times = np.array([0.0, ends[top]])
        rates[top] = growth(problem_of(tops, top), times, uses=len(going)).exponents[-1]
    return rates

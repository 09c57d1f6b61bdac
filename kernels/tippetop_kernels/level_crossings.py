"""Crossings of a level by a function of q > 0 around its minimum, and the swing between.

Functions and records of a problem go in, as in `minimise`; `grid.turnings` calls the kernels at
each point.

Symbols
    q         > 0, the variable; at: (p, level), a point and a level
    r, b      records of all points, only passed on: the coefficients, and the body for `inertia`
"""

from enum import IntEnum

import numpy as np

from .compilation import kernel
from .minimise import LARGEST, SMALLEST, crossing


class Level(IntEnum):
    """Position of a level relative to a function with one minimum; Datasets contain the numbers."""

    ABOVE = 0  # two crossings
    TOUCHING = 1  # the minimum itself, to the rounding that was allowed for
    BELOW = 2  # none: NaN
    UNDEFINED = 3  # an input is not finite, or the minimum is not known: NaN


@kernel
def band_of(excess, q, maxima, well, at, allowance, r):
    """Return the crossings of a level around the minimum `well`, a Level, and the minima inside.

    `at` is a point and a level. The crossings are the two q where excess(q, at, r), a function less
    the level, is 0. The minima are the first and the last that no maximum above the level separates
    from `well`.

    q contains minima and `maxima` maxima in turn, as `minimise.extremes` fills it: minimum k is
    q[2 k], and the maximum after it q[2 k + 1]. A level less than `allowance` (relative) from the
    minimum touches it. An end of the range (SMALLEST, LARGEST) stands for a function that stays
    below the level up to there.
    """
    here = q[2 * well]
    level = at[1]
    depth = -excess(here, at, r)
    if not np.isfinite(depth):
        return np.nan, np.nan, Level.UNDEFINED, well, well
    if abs(depth) <= allowance * abs(level):
        return here, here, Level.TOUCHING, well, well
    if depth < 0:
        return np.nan, np.nan, Level.BELOW, well, well
    first = last = well
    while first > 0 and excess(q[2 * first - 1], at, r) <= 0:
        first -= 1
    while last < maxima and excess(q[2 * last + 1], at, r) <= 0:
        last += 1
    low_end = q[2 * first - 1] if first > 0 else SMALLEST
    high_end = q[2 * last + 1] if last < maxima else LARGEST
    low = crossing(excess, q[2 * first], low_end, at, r)
    high = crossing(excess, q[2 * last], high_end, at, r)
    return low, high, Level.ABOVE, first, last


@kernel
def swing(excess, inertia, low, high, at, r, b):
    """Return the period of the swing between the crossings low and high.

    It is 2 integral of sqrt(inertia/-excess) dtheta; inertia(z, b) takes z = (1 - q)/(1 + q).

    With y = q/(1 + q) = y_low cos^2 + y_high sin^2 of beta/2 the integrand is smooth and periodic:
    the midpoint rule converges geometrically. NaN where 4096 nodes do not settle to 1e-11 (next to
    a separatrix).
    """
    if not low < high:
        return np.nan
    y1 = low / (1 + low)
    y2 = high / (1 + high)
    c1 = 1 / (1 + low)
    c2 = 1 / (1 + high)
    # the difference of y without cancellation
    across = (high - low) * c1 * c2
    previous = np.inf
    n = 16
    while n <= 4096:
        total = 0.0
        for j in range(n):
            # c = 1 - y, so q = y/c, z = c - y, dtheta = dy/sqrt(y c), dy = across sqrt(s2 k2) dbeta
            half = (j + 0.5) * np.pi / (2 * n)
            s2 = np.sin(half) ** 2
            k2 = np.cos(half) ** 2
            y = y1 * k2 + y2 * s2
            c = c1 * k2 + c2 * s2
            total += np.sqrt(inertia(c - y, b) * s2 * k2 / (-y * c * excess(y / c, at, r)))
        total *= 2 * across * np.pi / n
        if abs(total - previous) <= 1e-11 * total:
            return total
        previous = total
        n = 2 * n
    return np.nan

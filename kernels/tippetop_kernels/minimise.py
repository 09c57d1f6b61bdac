"""The minimum of a function of q > 0: where its slope by ln(q) changes sign.

A problem is three functions of opaque records p (the point) and r (what all points share):

    guess(p, r)         a first q, good to a factor of a few; 0, inf or NaN if unknown
    slopes(q, p, r)     a common positive factor times the first three derivatives by ln(q)
    value(q, p, r)      the function itself

The slope is negative at small q and positive at large q, unless the infimum is approached at an
end.
"""

from enum import IntEnum

import numpy as np

from .compilation import inlined, kernel


SMALLEST, LARGEST = 1e-30, 1e30

# a step in ln(q) after which none is needed: the next one would be of the order of its cube
AT_REST = 1e-5


class Status(IntEnum):
    """Method that found the minimum at a point, or the reason for its absence."""

    ATTAINED = 0
    AT_LOWER_END = 1  # an infimum, approached at q -> 0
    AT_UPPER_END = 2  # an infimum, approached at q -> oo
    LOWER_OF_TWO = 3  # attained, and there is another, higher minimum
    UNSETTLED = 4  # the iteration did not come to rest
    UNDEFINED = 5  # an input is not finite


@inlined
def factor(g1, g2, g3):
    """Return Halley's step in ln(q) as a factor on q, between 1/8 and 8.

    The Pade form of exp keeps its third order.
    """
    n, m = g1 * g2, 2 * g2 * g2 - g1 * g3
    f = (m - n) / (m + n)
    f = f if f > 0.125 else 0.125
    return f if f < 8.0 else 8.0


@inlined
def clipped(q):
    """Return q within the range where nothing overflows; NaN becomes its lower end."""
    q = q if q > SMALLEST else SMALLEST
    return q if q < LARGEST else LARGEST


@kernel
def root_of_slope(slopes, low, high, p, r):
    """Return the q in (low, high) where the slope, of opposite signs at both, vanishes.

    By bisection of ln(q) to the last bit.
    """
    falling = slopes(low, p, r)[0] < 0
    while True:
        q = np.sqrt(low) * np.sqrt(high)
        if not low < q < high:
            return low
        if (slopes(q, p, r)[0] < 0) == falling:
            low = q
        else:
            high = q


@kernel
def minimise(slopes, guess, p, r):
    """Return the q of the only minimum: bracket it by ever longer steps, then close the bracket.

    SMALLEST or LARGEST if the slope has one sign down to (up to) there; NaN if it is not finite.
    """
    q = clipped(guess(p, r))
    g1 = slopes(q, p, r)[0]
    if not np.isfinite(g1):
        return np.nan
    step, other = 2.0, q
    while True:
        previous = other
        other = clipped(other / step if g1 > 0 else other * step)
        if slopes(other, p, r)[0] * g1 <= 0:
            return root_of_slope(slopes, min(other, previous), max(other, previous), p, r)
        if other in (SMALLEST, LARGEST):
            return other
        step *= step


MOST_EXTREMES = 7  # that `extremes` gives room for: two minima are the most that was ever seen


@kernel
def extremes(slopes, p, r, q):
    """Fill q with minima and maxima in turn, ascending; return their number.

    q (7,) gets minimum, maximum, minimum, ...

    Scans ln(q) in steps of one half, 280 slopes. A pair of minimum and maximum closer than the scan
    can escape the count; it is shallow, hence never the lowest. An end of the range counts as a
    minimum where the function falls towards it.
    """
    count, ratio = 0, 1.6487212707001282
    low, g_low = SMALLEST, slopes(SMALLEST, p, r)[0]
    if g_low >= 0:
        q[0], count = low, 1
    while low < LARGEST and count < q.size:
        high = clipped(low * ratio)
        g_high = slopes(high, p, r)[0]
        if (g_low < 0) != (g_high < 0):
            q[count] = root_of_slope(slopes, low, high, p, r)
            count += 1
        if high == LARGEST and g_high < 0 and count < q.size:
            q[count] = high
            count += 1
        low, g_low = high, g_high
    return count


@kernel
def lowest(value, turns, first, last, p, r):
    """Return the number of the lowest of the minima from `first` to `last`.

    `turns` contains minima and maxima in turn.
    """
    best, least = first, np.inf
    for k in range(first, last + 1):
        V = value(turns[2 * k], p, r)
        if least > V:
            best, least = k, V
    return best

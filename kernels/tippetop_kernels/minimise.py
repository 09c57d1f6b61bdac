"""The minimum of a function of one positive variable q, stepped in ln(q), where its slope changes
sign.

A problem is three functions of opaque records p (the point) and r (what all points share):

    guess(p, r)         a first q, good to a factor of a few; 0, inf or NaN if there is none
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
    """How the minimum at a point was reached, or that it was not."""

    ATTAINED = 0
    AT_LOWER_END = 1  # an infimum, approached at q -> 0
    AT_UPPER_END = 2  # an infimum, approached at q -> oo
    LOWER_OF_TWO = 3  # attained, and there is another, higher minimum
    UNSETTLED = 4  # the iteration did not come to rest
    UNDEFINED = 5  # an input is not finite


@inlined
def factor(g1, g2, g3):
    """Halley's step in ln(q) as a factor on q, between 1/8 and 8.

    The Pade form of exp keeps its third order.
    """
    n, m = g1 * g2, 2 * g2 * g2 - g1 * g3
    f = (m - n) / (m + n)
    f = f if f > 0.125 else 0.125
    return f if f < 8.0 else 8.0


@inlined
def clipped(q):
    """q within the range where nothing overflows; NaN becomes its lower end."""
    q = q if q > SMALLEST else SMALLEST
    return q if q < LARGEST else LARGEST


@kernel
def settled(slopes, q, p, r):
    """q after as many of Halley's steps as it takes, NaN if ten are not enough: for points next to
    their minimum.
    """
    for _ in range(10):
        g1, g2, g3 = slopes(q, p, r)
        f = factor(g1, g2, g3)
        q *= f
        if abs(f - 1) <= AT_REST:
            return q if g2 > 0 and SMALLEST < q < LARGEST else np.nan
    return np.nan


@kernel
def between(slopes, low, high, p, r):
    """The q in (low, high) where the slope, negative at low and positive at high, vanishes; NaN if
    unsettled.

    Halley's step where it stays inside the bracket, else the geometric mean: it cannot fail to
    close.
    """
    q = np.sqrt(low) * np.sqrt(high)
    for _ in range(200):
        g1, g2, g3 = slopes(q, p, r)
        if g1 < 0:
            low = q
        elif g1 > 0:
            high = q
        else:
            return q
        n, m = g1 * g2, 2 * g2 * g2 - g1 * g3
        trial = q * (m - n) / (m + n)
        if not (low < trial < high):
            trial = np.sqrt(low) * np.sqrt(high)
        if abs(trial - q) <= 4e-16 * q or high - low <= 4e-16 * low:
            return trial
        q = trial
    return np.nan


@kernel
def minimise(slopes, guess, p, r):
    """The only minimum, from any guess: brackets it by ever longer steps, then closes the bracket.

    Returns q; SMALLEST or LARGEST where the slope has one sign down to (up to) there; NaN if
    unsettled.
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
            return (
                between(slopes, other, previous, p, r)
                if g1 > 0
                else between(slopes, previous, other, p, r)
            )
        if other in (SMALLEST, LARGEST):
            return other
        step *= step


MOST_EXTREMES = 7  # that `extremes` gives room for: two minima are the most that was ever seen


@kernel
def extremes(slopes, p, r, q):
    """Minima and maxima in turn, ascending: fills q (7,) with minimum, maximum, minimum, ...; how
    many there are.

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
        if g_low < 0 <= g_high:
            q[count] = between(slopes, low, high, p, r)
            count += 1
        elif g_low >= 0 > g_high:
            q[count] = summit(slopes, low, high, p, r)
            count += 1
        if high == LARGEST and g_high < 0 and count < q.size:
            q[count] = high
            count += 1
        low, g_low = high, g_high
    return count


@kernel
def summit(slopes, low, high, p, r):
    """The q in (low, high) where the slope, positive at low and negative at high, vanishes: by
    bisection of ln(q).
    """
    for _ in range(80):
        q = np.sqrt(low) * np.sqrt(high)
        if not low < q < high:
            break
        if slopes(q, p, r)[0] >= 0:
            low = q
        else:
            high = q
    return low


@kernel
def lowest(value, turns, first, last, p, r):
    """Which of the minima from `first` to `last` among minima and maxima in turn is the lowest."""
    best, least = first, np.inf
    for k in range(first, last + 1):
        V = value(turns[2 * k], p, r)
        if least > V:
            best, least = k, V
    return best

"""The minimum of a function of q > 0: where its slope by ln(q) changes sign.

A problem is four functions of records p (the point) and r (what all points share), which are only
passed on; `landscape.kernels` has p = `formulas.Point`, and r the coefficients of a body:

    guess(p, r)         a first q, good to a factor of a few; 0, inf or NaN if unknown
    slopes(q, p, r)     a common positive factor times the first three derivatives by ln(q)
    slope(q, p, r)      the first of them
    value(q, p, r)      the function itself

The slope is negative at small q and positive at large q, unless the infimum is approached at an
end.
"""

from enum import IntEnum

import numpy as np

from .compilation import inlined, kernel


SMALLEST = 1e-30
LARGEST = 1e30
MOST_EXTREMES = 280  # one in every step of the scan of `extremes`; two minima are the most seen

# a step in ln(q) after which none is needed: the next one would be of the order of its cube
AT_REST = 1e-5


class Status(IntEnum):
    """Method that found the minimum at a point, or the reason for its absence.

    Stored surfaces contain the numbers.
    """

    ATTAINED = 0
    AT_LOWER_END = 1  # an infimum, approached at q -> 0
    AT_UPPER_END = 2  # an infimum, approached at q -> oo
    LOWER_OF_TWO = 3  # attained, and there is another, higher minimum
    UNSETTLED = 4  # the iteration did not come to rest
    UNDEFINED = 5  # an input is not finite


@inlined
def stepped(slopes, q, p, r):
    """Return q after a step of Halley in ln(q), and the relative length of the step.

    The Pade form of exp keeps its third order. The factor on q is between 1/8 and 8.
    """
    g1, g2, g3 = slopes(q, p, r)
    n = g1 * g2
    m = 2 * g2 * g2 - g1 * g3
    f = (m - n) / (m + n)
    # comparisons in this order, here and in `clipped`, turn NaN into the lower bound
    f = f if f > 0.125 else 0.125
    f = f if f < 8.0 else 8.0
    return q * f, abs(f - 1)


@inlined
def clipped(q):
    """Return q within the range where nothing overflows; NaN becomes its lower end."""
    q = q if q > SMALLEST else SMALLEST
    return q if q < LARGEST else LARGEST


@kernel
def crossing(function, inside, outside, p, r):
    """Return q between `inside`, where function(q, p, r) <= 0, and `outside`, where it is > 0.

    By bisection of ln(q) to the last bit. It is next to `outside` where the function is not > 0.
    `inside` may be the larger of the two.
    """
    while True:
        q = np.sqrt(inside) * np.sqrt(outside)
        if not min(inside, outside) < q < max(inside, outside):
            return inside
        if function(q, p, r) > 0:
            outside = q
        else:
            inside = q


@kernel
def extremes(slope, p, r, q):
    """Fill q with minima and maxima in turn, ascending; return the number of maxima.

    q (MOST_EXTREMES,) gets minimum, maximum, minimum, ..., minimum.

    Scans ln(q) in steps of one half, 280 slopes. A pair of minimum and maximum closer than the scan
    can escape the count; it is shallow, hence never the lowest. An end of the range counts as a
    minimum where the function falls towards it.
    """
    count = 0
    falling = True
    low = SMALLEST
    high = SMALLEST
    while low < LARGEST:
        # not falling at LARGEST: there a function that falls has its last minimum
        if (high < LARGEST and slope(high, p, r) < 0) != falling:
            inside, outside = (low, high) if falling else (high, low)
            q[count] = crossing(slope, inside, outside, p, r)
            count = count + 1
            falling = not falling
        low = high
        high = clipped(high * 1.6487212707001282)  # exp(1/2)
    return count // 2


@kernel
def lowest(value, q, first, last, p, r):
    """Return the number of the lowest of the minima from `first` to `last`.

    q contains minima and maxima in turn, as `extremes` fills it: minimum k is q[2 k].
    """
    best = first
    least = np.inf
    for k in range(first, last + 1):
        V = value(q[2 * k], p, r)
        if least > V:
            best = k
            least = V
    return best

"""Where a polynomial on [0, 1] changes sign, and how far it reaches: numbers, no physics.

A Taylor integrator gives every function of a step as such a polynomial (ascending coefficients, time in units of the
step), so that zeros and extremes are found after the step, and never change it.
"""

from math import comb

import numpy as np

from .jit import apart, inlined, kernel


DEPTH = 20  # an interval is halved so often at most: two zeros within 1e-6 of a step are none

HALVES = np.array([[comb(j, k) * 0.5**j for k in range(32)] for j in range(32)])
"""Row j: the coefficients of (1/2 + x/2)^j."""

NODES = np.array([[(i / 8) ** k for i in range(9)] for k in range(64)])
"""Row k: the k-th powers of nine points. A step holds about a radian: no dip can hide between them. The orders of
quadruple precision reach 46."""


@inlined
def value(p, x):
    """p(x) by Horner's rule."""
    total = 0.0
    for k in range(len(p) - 1, -1, -1):
        total = total * x + p[k]
    return total


@inlined
def total(p):
    """p(1), to the bit of `value`, in half the time."""
    end = 0.0
    for k in range(len(p) - 1, -1, -1):
        end += p[k]
    return end


@inlined
def reach(p):
    """How far p strays from p[0] on [0, 1] at most: sum of |p[k]|, k > 0."""
    even, odd = 0.0, 0.0  # two sums: the processor adds them side by side
    for k in range(1, len(p) - 1, 2):
        even += abs(p[k])
        odd += abs(p[k + 1])
    return even + odd if len(p) % 2 else even + odd + abs(p[-1])


@inlined
def ranges(c, shift, factors, low, high, monotone, work):
    """Bounds of many polynomials on [0, 1], (lanes,): coefficients c[k + shift]*factors[k], arrays (size, lanes).

    The Bernstein coefficients of the cubic part, give or take the sum of the other coefficients, bound a polynomial;
    those of its slope tell whether it is monotone (1 in `monotone`): then it lies between its ends. Lanes are the
    inner loop, for the processor's vectors; `work` is (3, lanes), of sums that begin with the fifth power.
    """
    rest, end, bend = work[0], work[1], work[2]
    if len(low) == 1:  # loops over one lane cost more than what is in them
        total, size, steep = 0.0, 0.0, 0.0
        for k in range(5, len(factors) - shift):
            a = c[k + shift, 0] * factors[k, 0]
            total += a
            size += abs(a)
            steep += k * abs(a)
        rest[0], end[0], bend[0] = size, total, steep
    else:
        for lane in range(len(low)):
            rest[lane] = end[lane] = bend[lane] = 0.0
        for k in range(5, len(factors) - shift):
            _summed(k, c[k + shift], factors[k], rest, end, bend)
    _bounded(c[shift : shift + 5], factors, rest, end, bend, low, high, monotone)


@apart
def _summed(k, c, factor, rest, end, bend):
    """Adds a power to the sums of `ranges`."""
    for lane in range(len(end)):
        a = c[lane] * factor[lane]
        end[lane] += a
        rest[lane] += abs(a)
        bend[lane] += k * abs(a)


@apart
def _bounded(c, factors, rest, end, bend, low, high, monotone):
    """What `ranges` gives, of the lowest powers and the sums of the others."""
    for lane in range(len(low)):
        p0, p1 = c[0, lane], c[1, lane] * factors[1, lane]
        p2, p3, p4 = c[2, lane] * factors[2, lane], c[3, lane] * factors[3, lane], c[4, lane] * factors[4, lane]
        b1, b2, b3 = p0 + p1 / 3, p0 + (2 * p1 + p2) / 3, p0 + p1 + p2 + p3
        s1, s2, s3 = p1 + 2 * p2 / 3, p1 + (4 * p2 + 3 * p3) / 3, p1 + 2 * p2 + 3 * p3 + 4 * p4
        least, most = min(min(p1, s1), min(s2, s3)), max(max(p1, s1), max(s2, s3))
        steady = (least > bend[lane]) | (most < -bend[lane])
        last, beyond = b3 + p4 + end[lane], abs(p4) + rest[lane]
        monotone[lane] = 1.0 if steady else 0.0
        low[lane] = min(p0, last) if steady else min(min(p0, b1), min(b2, b3)) - beyond
        high[lane] = max(p0, last) if steady else max(max(p0, b1), max(b2, b3)) + beyond


@kernel
def crossings(p, positive, zeros, work, monotone):
    """Sign changes of p on [0, 1), ascending, into `zeros`; how many there are, and whether p is positive at the end.

    `positive` is the sign that the steps before ended with: a zero that rounding puts between two steps counts once.
    `work` has the size of p. `monotone`: p is known to be.
    """
    if monotone:
        end = total(p)
        now = end > 0
        if now == positive:
            return 0, now
        zeros[0] = _zero(p, 0.0, 1.0, p[0], end)
        return 1, now
    radius = reach(p)
    if abs(p[0]) > radius or radius == 0:  # away from zero throughout, or zero throughout
        now = p[0] > 0 if p[0] != 0 else positive
        if now != positive:
            zeros[0] = 0.0
            return 1, now
        return 0, now
    count, at, level = 0, 0, 0  # the interval [at, at + 1]/2^level
    while True:
        radius = 0.5 / 2.0**level
        _shift(p, (2 * at + 1) * radius, radius, work)
        rest, bend, curl = 0.0, 0.0, 0.0
        for k in range(len(p) - 1, 2, -1):
            rest += abs(work[k])
            bend += k * abs(work[k])
            curl += k * (k - 1) * abs(work[k])
        rest += abs(work[1]) + abs(work[2])
        bend += 2 * abs(work[2])
        plain = abs(work[0]) > rest or abs(work[1]) > bend or level == DEPTH
        if plain or 2 * abs(work[2]) > curl:  # at most one zero, or at most one turn
            turn, low = -1.0 if plain else _turn(work, radius), -1.0
            for high in (turn, 1.0):
                if high > low:
                    end = value(work, high)
                    now = end > 0
                    if now != positive and count < len(zeros):
                        zeros[count] = (2 * at + 1 + _zero(work, low, high, value(work, low), end)) * radius
                        count += 1
                    positive, low = now, high
            at += 1
            while at % 2 == 0 and level > 0:  # up to the next interval
                at //= 2
                level -= 1
            if level == 0:
                return count, positive
        else:
            at *= 2
            level += 1


@inlined
def _shift(p, middle, radius, work):
    """Coefficients of p(middle + radius x)."""
    n = len(p)
    if radius == 0.5 and n <= 32:  # nearly always: as a product with a matrix, three times as fast
        for k in range(n):
            work[k] = 0.0
        for j in range(n):
            factor = p[j]
            for k in range(n):
                work[k] += HALVES[j, k] * factor
        return
    for k in range(n):
        work[k] = p[k]
    for i in range(n - 1):
        for k in range(n - 2, i - 1, -1):
            work[k] += middle * work[k + 1]
    power = 1.0
    for k in range(1, n):
        power *= radius
        work[k] *= power


@kernel
def _turn(p, radius):
    """Where p, with one turn on [-1, 1] at most, turns: -1 where it does not there, or goes less far beyond zero than
    two zeros that are as near as intervals are small."""
    x, low, high = 0.0, -1.0, 1.0
    for _ in range(60):
        f, slope, curve = jet(p, x)
        if (slope > 0) == (p[2] > 0):
            high = x
        else:
            low = x
        after = x - slope / (2 * curve)
        if not low <= after <= high:
            after = 0.5 * (low + high)
        if abs(after - x) <= 1e-9:
            x = after
            break
        x = after
    f, _, curve = jet(p, x)
    beyond = f * curve < 0 and abs(f) * radius * radius > abs(curve) * 0.25 / 4.0**DEPTH
    return x if beyond and -1.0 < x < 1.0 else -1.0


@kernel
def _zero(p, low, high, start, end):
    """The zero of a monotone p on [low, high], where it is `start` and `end`: Newton from the secant, kept between
    bounds. The lower end, if rounding hides the zero there."""
    rising = end > 0
    if (start > 0) == rising:
        return low
    x = low + (high - low) * (start / (start - end))
    for _ in range(60):
        f, slope, _ = jet(p, x)
        if f == 0:
            return x
        if (f > 0) == rising:
            high = x
        else:
            low = x
        after = x - f / slope if slope != 0 else 0.5 * (low + high)
        if not low <= after <= high:
            after = 0.5 * (low + high)
        if abs(after - x) <= 1e-9:  # the next correction is its square
            return after
        x = after
    return x


@inlined
def jet(p, x):
    """p(x), p'(x) and p''(x)/2: even and odd powers apart, so that the processor has chains to do side by side."""
    y = x * x
    even, even1, even2, odd, odd1, odd2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # in powers of y
    for k in range((len(p) - 1) // 2, -1, -1):
        even2 = even2 * y + even1
        even1 = even1 * y + even
        even = even * y + p[2 * k]
        odd2 = odd2 * y + odd1
        odd1 = odd1 * y + odd
        odd = odd * y + (p[2 * k + 1] if 2 * k + 1 < len(p) else 0.0)
    return (
        even + x * odd,
        2 * x * even1 + odd + 2 * y * odd1,
        even1 + 4 * y * even2 + x * (3 * odd1 + 4 * y * odd2),
    )


@kernel
def extremes(p, low, high, samples, monotone):
    """The smallest value of p on [0, 1] if it may lie below `low`, else `low`; likewise the greatest; and where they
    are, NaN where the value is the one that was given.

    `samples` has the size of a row of NODES. `monotone`: p is known to be.
    """
    at_low, at_high = np.nan, np.nan
    if monotone:
        start, end = p[0], total(p)
        if min(start, end) < low:
            low, at_low = (start, 0.0) if start <= end else (end, 1.0)
        if max(start, end) > high:
            high, at_high = (start, 0.0) if start >= end else (end, 1.0)
        return low, high, at_low, at_high
    nodes = len(samples)
    _sampled(p, samples)
    under, over = 0, 0
    for i in range(1, nodes):
        under = i if samples[i] < samples[under] else under
        over = i if samples[i] > samples[over] else over
    bend = 0.0
    for k in range(2, len(p)):
        bend += k * (k - 1) * abs(p[k])
    bend /= 8 * (nodes - 1) ** 2  # between two nodes p goes no further beyond them
    if samples[under] - bend < low:
        least, x = _polished(p, 1.0, under / (nodes - 1), samples[under])
        if least < low:
            low, at_low = least, x
    if samples[over] + bend > high:
        most, x = _polished(p, -1.0, over / (nodes - 1), -samples[over])
        if -most > high:
            high, at_high = -most, x
    return low, high, at_low, at_high


@inlined
def _sampled(p, samples):
    """p at the nodes: in registers, for a sum that goes to memory and back takes three times as long."""
    s1, s2, s3, s4, s5, s6, s7, s8 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(p)):
        factor = p[k]
        s1 += factor * NODES[k, 1]
        s2 += factor * NODES[k, 2]
        s3 += factor * NODES[k, 3]
        s4 += factor * NODES[k, 4]
        s5 += factor * NODES[k, 5]
        s6 += factor * NODES[k, 6]
        s7 += factor * NODES[k, 7]
        s8 += factor
    samples[0], samples[1], samples[2], samples[3], samples[4] = p[0], s1, s2, s3, s4
    samples[5], samples[6], samples[7], samples[8] = s5, s6, s7, s8


@kernel
def _polished(p, sign, x, best):
    """The smallest value of sign*p next to x, and where: Newton on the slope, kept in [0, 1]."""
    at = x
    for _ in range(6):
        f, slope, curve = jet(p, x)
        if sign * f < best:
            best, at = sign * f, x
        if not sign * curve > 0:
            return best, at
        after = min(1.0, max(0.0, x - slope / (2 * curve)))
        if abs(after - x) <= 1e-9:  # where the value is flat to 1e-18
            return best, at
        x = after
    last = sign * value(p, x)
    return (last, x) if last < best else (best, at)

"""When a flight ends: the first zero of the gap, which no step can pass over. [contact 3.1]

A step is taken only where a polynomial below the gap is positive all along it: the Taylor polynomial of degree three
less the greatest fourth derivative, shown positive by its Bernstein coefficients. The zero is accepted only where a
polynomial above the speed of the gap is negative, so that there is one. A root at the start, triple at a liftoff, is
divided out.
"""

import math
from collections.abc import Sequence
from math import comb
from typing import Any

import numpy as np

from .flight import Hop, gap_in_flight, gap_series


BERNSTEIN = tuple(tuple(tuple(comb(j, i) / comb(n, i) for i in range(j + 1)) for j in range(n + 1)) for n in range(5))
"""Of each degree n, the weights of a polynomial's coefficients in its n + 1 Bernstein coefficients."""


def landing_time(h: Hop) -> Any:
    """The first time after the start at which the gap vanishes, to rounding.

    Parameters
    ----------
    h
        The gap of a ball, `flight.hop`.

    Returns
    -------
    float or longdouble
        0 if the gap does not open at all.
    """
    amplitude = _root(h.even**2 + h.odd**2)
    highest = h.start + 2 * amplitude
    most = amplitude * h.Omega**4  # of the fourth derivative
    step = (h.rise + _root(h.rise**2 + 2 * h.g * highest)) / h.g * (1 + 1e-6)  # the gap is negative after it
    series = gap_series(h)[:4]
    rooted = next((i for i, c in enumerate(series) if c != 0), 4)
    if rooted == 4 or series[rooted] < 0:
        return 0 * h.Omega
    t, tiny = 0 * h.Omega, 4 * np.finfo(np.result_type(h.Omega)).eps
    while True:
        if _positive([*_scaled(series, step)[rooted:], -most * step**4 / 24]):
            t, step, rooted = t + step, 2 * step, 0
            series = gap_in_flight(h, t)
            if series[0] <= 0:  # rounding: the gap closes here
                return t
            continue
        if not rooted and _falls(h, t, step, series, most):
            return _bracketed(h, t, t + step)
        step = step / 2
        if step < tiny * t:  # it touches the plane without crossing it, to rounding
            return t


def _root(x: Any) -> Any:
    """sqrt(x) of a number: Python's own is the fastest for doubles."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


def first_landing(hops: Sequence[Hop]) -> tuple[int, Any]:
    """Which ball lands first, by its place in the sequence, and when."""
    times = [landing_time(h) for h in hops]
    first = min(range(len(times)), key=times.__getitem__)
    return first, times[first]


def _scaled(series: Sequence, step: Any) -> list:
    """The Taylor coefficients of the derivatives `series`, by the fraction of a step."""
    factors = (1, step, step**2 / 2, step**3 / 6)
    return [c * f for c, f in zip(series, factors, strict=False)]


def _positive(a: Sequence) -> bool:
    """Whether the Bernstein coefficients of the polynomial of coefficients a are positive on [0, 1]; then so is it."""
    for weights in BERNSTEIN[len(a) - 1]:
        total = 0 * a[0]
        for weight, coefficient in zip(weights, a, strict=False):
            total = total + weight * coefficient
        if not total > 0:
            return False
    return True


def _falls(h: Hop, t: Any, step: Any, series: Sequence, most: Any) -> bool:
    """Whether the gap falls all along the step, through zero."""
    slope = [-c for c in _scaled(series[1:], step)]
    return gap_in_flight(h, t + step)[0] <= 0 and _positive([*slope, -most * step**3 / 6])


def _bracketed(h: Hop, low: Any, high: Any) -> Any:
    """The zero of the gap, which falls from `low` to `high`: Newton, or halves where it leaves the bracket."""
    t = high
    for _ in range(200):
        gap, speed, *_ = gap_in_flight(h, t)
        low, high = (t, high) if gap > 0 else (low, t)
        newer = t - gap / speed
        if not low < newer < high:
            newer = low + (high - low) / 2 if gap != 0 else t
        if newer in (t, low, high):
            break
        t = newer
    return t

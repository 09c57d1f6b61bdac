"""When a flight ends: the first zero of the gap, which no step can pass over. [contact 3.1]

A step is taken only where a polynomial below the gap is positive all along it: the Taylor polynomial of degree three
less the greatest fourth derivative, shown positive by its Bernstein coefficients. The zero is accepted only where a
polynomial above the speed of the gap is negative, so that there is one. A root at the start, triple at a liftoff, is
divided out. Numbers of any kind, in Python; doubles in numba.
"""

from collections.abc import Sequence
from typing import Any

from ..operand import formula, rounding, sqrt
from .flight import Hop, gap_in_flight, gap_series


@formula
def landing_within(h: Hop, rounding: float) -> Any:
    """The first time after the start at which the gap vanishes, to rounding.

    Parameters
    ----------
    h
        The gap of a ball, `flight.hop`.
    rounding
        That of its numbers.

    Returns
    -------
    number
        0 if the gap does not open at all.
    """
    step = latest(h)
    gap, speed, bend, third, _, _ = gap_series(h)
    rooted = 0 if gap != 0 else 1 if speed != 0 else 2 if bend != 0 else 3 if third != 0 else 4
    opens = speed if rooted == 1 else bend if rooted == 2 else third if rooted == 3 else gap
    t = 0 * h.Omega
    if rooted == 4 or opens < 0:
        return t
    while True:
        if _positive(gap_below(h, gap, speed, bend, third, step), rooted, 4 - rooted):
            t, step, rooted = t + step, 2 * step, 0
            gap, speed, bend, third = gap_in_flight(h, t)
            if gap <= 0:  # rounding: the gap closes here
                return t
            continue
        falls = _positive(fall_below(h, speed, bend, third, step), 0, 3)
        if rooted == 0 and gap_in_flight(h, t + step)[0] <= 0 and falls:
            return _bracketed(h, t, t + step)
        step = step / 2
        if not step > 4 * rounding * t:  # it touches the plane without crossing it, to rounding
            return t


@formula
def latest(h: Hop) -> Any:
    """A time after which the gap is negative: a point falls so long from as high as the turning may lift it."""
    highest = h.start + 2 * sqrt(h.even * h.even + h.odd * h.odd)
    return (h.rise + sqrt(h.rise * h.rise + 2 * h.g * highest)) / h.g * (1 + 1e-6)


@formula
def greatest_fourth(h: Hop) -> Any:
    """What the fourth derivative of the gap never exceeds."""
    return sqrt(h.even * h.even + h.odd * h.odd) * h.Omega**4


@formula
def gap_below(h: Hop, gap: Any, speed: Any, bend: Any, third: Any, step: Any) -> tuple:
    """The coefficients of a polynomial that the gap exceeds: its time is 1 after `step`."""
    return gap, speed * step, bend * step**2 / 2, third * step**3 / 6, -greatest_fourth(h) * step**4 / 24


@formula
def fall_below(h: Hop, speed: Any, bend: Any, third: Any, step: Any) -> tuple:
    """Those of one that the speed at which the gap closes exceeds."""
    return -speed, -(bend * step), -(third * step**2 / 2), -greatest_fourth(h) * step**3 / 6, 0 * step


@formula
def _positive(a: tuple, first: int, degree: int) -> bool:
    """Whether the Bernstein coefficients of the polynomial of coefficients a, from `first` on, are positive on [0, 1];
    then so is it."""
    for j in range(degree + 1):
        total, above, below = 0 * a[0], 1, 1  # above/below: j over i by degree over i
        for i in range(j + 1):
            total = total + above / below * a[first + i]
            above, below = above * (j - i), below * (degree - i)
        if not total > 0:
            return False
    return True


@formula
def _bracketed(h: Hop, low: Any, high: Any) -> Any:
    """The zero of the gap, which falls from `low` to `high`: Newton, or halves where it leaves the bracket."""
    t = high
    for _ in range(200):
        gap, speed, _, _ = gap_in_flight(h, t)
        if gap > 0:
            low = t
        else:
            high = t
        newer = t - gap / speed
        if not low < newer < high:
            newer = low + (high - low) / 2 if gap != 0 else t
        if newer in (t, low, high):
            break
        t = newer
    return t


def landing_time(h: Hop) -> Any:
    """`landing_within` the rounding of a hop's numbers, float or longdouble."""
    return landing_within(h, rounding(h.Omega))


def first_landing(hops: Sequence[Hop]) -> tuple[int, Any]:
    """Which ball lands first, by its place in the sequence, and when."""
    times = [landing_time(h) for h in hops]
    first = min(range(len(times)), key=times.__getitem__)
    return first, times[first]

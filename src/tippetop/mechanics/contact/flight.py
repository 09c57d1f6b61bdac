"""The gap of a ball in free flight, in closed form: L stays, the axis turns about it, the centre falls. [contact 3.1]

Numbers, float or longdouble; the time may be an array of them.
"""

from typing import Any, NamedTuple

from ..operand import Vector, cross, dot, formula, sin, sqrt, times
from .body import Touch


class Hop(NamedTuple):
    """The gap of one ball: start + speed t + bend t^2/2 + even (cos x - 1 + x^2/2) - odd (x - sin x), x = Omega t.

    The same later, without cancellation there: start + rise t - g t^2/2 + even (cos x - 1) + odd sin x.
    """

    start: Any  # the gap at t = 0 [m]
    speed: Any  # v_n there [m/s]
    bend: Any  # its second derivative there [m/s^2]
    even: Any  # offset times the parts of 3hat that turn with cos and sin [m]
    odd: Any
    Omega: Any  # [rad/s]
    rise: Any  # V_z [m/s]
    g: Any  # [m/s^2]


@formula
def hop(u: Vector, L: Vector, V_z: Any, gap: Any, b: Touch, zeros: int = 0) -> Hop:
    """The gap of a ball in a flight that begins now.

    Parameters
    ----------
    u, L
        3hat, and the angular momentum about the centre of mass.
    V_z
        Vertical velocity of the centre of mass [m/s].
    gap
        The gap now [m].
    b
        The body, seen from the ball.
    zeros
        How many of gap, its speed and its bend are known to vanish now: 0 in the air, 1 after a bounce, 2 where the
        contact opens at once (b_z > 0), 3 at a liftoff (b_z = 0, rising). They are set to zero.
    """
    Omega = sqrt(dot(L, L)) / b.I1
    along = times(1 / sqrt(dot(L, L)), L) if Omega > 0 else L
    across = cross(along, u)
    even, odd = -b.c * cross(along, across).z, b.c * across.z
    start = gap if zeros < 1 else 0 * gap
    speed = V_z + odd * Omega if zeros < 2 else 0 * gap
    bend = -b.g - even * Omega**2 if zeros < 3 else 0 * gap
    return Hop(start, speed, bend, even, odd, Omega, V_z, b.g)


@formula
def gap_series(h: Hop) -> tuple:
    """The gap and its first five derivatives at the start."""
    third, fourth = -h.odd * h.Omega**3, h.even * h.Omega**4
    return h.start, h.speed, h.bend, third, fourth, h.odd * h.Omega**5


@formula
def gap_in_flight(h: Hop, t: Any) -> tuple:
    """The gap and its first three derivatives at the time t, a number; no digits are lost near a root at the start."""
    x = h.Omega * t
    sine, half = sin(x), sin(x / 2)
    versine = 2 * half * half
    if x > 2:
        gap = h.start + t * (h.rise - h.g * t / 2) - h.even * versine + h.odd * sine
        speed = h.rise - h.g * t + h.Omega * (h.odd * (1 - versine) - h.even * sine)
    else:
        late_sine, late_cosine = _late(x)
        gap = h.start + t * (h.speed + h.bend * t / 2) + h.even * late_cosine - h.odd * late_sine
        speed = h.speed + h.bend * t + h.Omega * (h.even * late_sine - h.odd * versine)
    bend = h.bend + h.Omega**2 * (h.even * versine - h.odd * sine)
    return gap, speed, bend, h.Omega**3 * (h.even * sine - h.odd * (1 - versine))


@formula
def _late(x: Any) -> tuple:
    """x - sin(x) and cos(x) - 1 + x^2/2 of a moderate x, by their series: without cancellation."""
    term, odd, even, before, n = x * x / 2, 0 * x, 0 * x, 0 * x, 2
    while n < 6 or odd != before:
        before = odd
        term = term * x / (n + 1)
        odd = odd + term
        term = term * x / (n + 2)
        even = even + term
        term, n = -term, n + 2
    return odd, even

"""Friction of a contact disc that slides and drills: the formulas of the law `contensou`.

Coulomb's law acts at each point under the pressure of Hertz. F = -mu N k v_A and the torque -mu N
patch^2 twist Omega_z zhat, with k = f(x)/w and twist = m(x)/U: functions of w^2 and U^2, regular
where slip stops (`inside`) and where drilling does (`outside`). f and m are elementary; there is
one formula for each region of x, right to rounding. `contact.contact_phases` makes a phase for each
region.

Symbols
    w, v      sliding speed |v_A| and velocity; U: patch |Omega_z|, the speed of the disc's edge
    x         w/U; w2, U2: squares
    N, mu     normal force, friction coefficient; patch: radius of the disc
    omega     angular velocity, Omega_z its vertical part; law: record of the law
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from .operand import Operand, Vector, atan2, formula, sqrt


class Drag(NamedTuple):
    """k = f/w and twist = m/U [s/m]; both positive."""

    k: Operand
    twist: Operand


OUTSIDE_FROM = 2.5
"""x = w/U beyond which the closed form loses digits to cancellation, and polynomials do not."""

TERMS_OUTSIDE = (
    (-0.0001515407435718281, 0.0001139569255616564),
    (-9.431106430390794e-05, 6.587114183299193e-05),
    (-0.0001951652740964004, 0.0001340139566904536),
    (-0.0003148266519838915, 0.00020362767546565997),
    (-0.000573695368669578, 0.0003442258064130908),
    (-0.001183709868870667, 0.0006373817132598247),
    (-0.002976190533894064, 0.00135281389731384),
    (-0.01071428571353753, 0.003571428570851513),
    (-0.10000000000000375, 0.01428571428571718),
    (1.0, 0.2),
)
"""Coefficients of f and x m in q = 1/x^2 by falling power: Chebyshev's approximations of the
hypergeometric functions 2F1(-1/2, 1/2; 5/2) and 2F1(1/2, 1/2; 7/2)/5 up to q = 0.165, to 4e-18.
"""


@formula
def inside(w2, U2):
    """Return the `Drag` for x <= 1: the patch turns about a point inside it."""
    U = sqrt(U2)
    x2 = w2 / U2
    return Drag(3 * math.pi / 8 * (1 - x2 / 4) / U, 3 * math.pi / 16 * (1 - x2 + 3 * x2**2 / 8) / U)


@formula
def between(w2, U2):
    """Return the `Drag` for 1 <= x <= 2.5."""
    U = sqrt(U2)
    x2 = w2 / U2
    y = sqrt(w2 - U2) / U
    A = atan2(U, sqrt(w2 - U2))  # arcsin(1/x)
    k = 3 * ((1 - x2 / 4) * A + (x2 + 2) * y / (4 * x2)) / (4 * U)
    return Drag(k, 3 * ((1 - x2 + 3 * x2**2 / 8) * A + 3 * (2 - x2) * y / 8) / (8 * U))


@formula
def outside(w2, U2):
    """Return the `Drag` for x >= 2.5."""
    w = sqrt(w2)
    q = U2 / w2
    f = 0.0
    m = 0.0
    for term_f, term_m in TERMS_OUTSIDE:
        f = f * q + term_f
        m = m * q + term_m
    return Drag(f / w, m / w)


@formula
def drag(w2, U2):
    """Return the `Drag` of two numbers, by the formula of its region; infinite where w = U = 0.

    The regions are those of REGIONS, which has the border EDGE in place of x = 1: a change of one
    is a change of both.
    """
    if w2 <= U2:
        return inside(w2, U2) if U2 > 0 else Drag(math.inf, math.inf)
    return between(w2, U2) if w2 < OUTSIDE_FROM**2 * U2 else outside(w2, U2)


# --- regions ------------------------------------------------------------------------------------


SLOW = 1e-6
"""Sliding speed, internal units, at which a step ends.

A longer step may pass the rest of a disc that hardly turns, which is short, and not see it."""

EDGE = 1 + 1e-5
"""x = w/U from which `between` holds: its slope has a root at 1.

Nearer to it Taylor coefficients overflow where U is least. `inside` is right there to 1e-13, and
for no longer than 1e-5 U takes.
"""


class Border(NamedTuple):
    """An end of a region."""

    event: str  # the event that ends the region
    beyond: Callable  # beyond(s, b), zero at the border; s.v2 = w^2 and s.U2 = U^2
    direction: int  # of the zero
    follows: str  # the next region; the same one if only the step must end
    back: str  # the event of the next region that leads back


class Region(NamedTuple):
    """Velocities for which one formula of a law is valid, and its boundary."""

    drag: Callable  # drag(w2, U2) -> Drag
    borders: tuple[Border, ...]


def _beyond(x: float) -> Callable:
    """Return the function beyond(s, b) of a border: s.v2 - x^2 s.U2, zero where w/U is x."""
    return formula(lambda s, b: s.v2 - x**2 * s.U2)


@formula
def _beyond_slow(s, b):
    """Return w^2 - SLOW^2 [m^2/s^2], the function of the border of slow sliding; s.v2 is w^2."""
    return s.v2 - SLOW**2


REGIONS = {
    "inside": Region(inside, (Border("faster", _beyond(EDGE), 1, "between", "slower"),)),
    "between": Region(
        between,
        (
            Border("slower", _beyond(EDGE), -1, "inside", "faster"),
            Border("faster", _beyond(OUTSIDE_FROM), 1, "outside", "slower"),
        ),
    ),
    "outside": Region(
        outside,
        (
            Border("slower", _beyond(OUTSIDE_FROM), -1, "between", "faster"),
            Border("slow", _beyond_slow, -1, "outside", "slow"),
        ),
    ),
}
"""The regions of a disc by name, by rising x."""


# --- force, torque, power -----------------------------------------------------------------------


@formula
def drilling_force(N, v, drag, mu):
    """Return the force of the plane on a disc, (3,) [N], under the normal force N."""
    return Vector(-(mu * N * drag.k * v.x), -(mu * N * drag.k * v.y), N)


STOPS_ROLLING = 1e-6
"""Angular velocity, internal units, below which the direction of rolling is smooth."""


@formula
def rolling(omega, law):
    """Return the torque of rolling resistance per normal force, (3,) [m].

    It is -mu_r omega_h/|omega_h|, smooth where omega_h = 0. The vertical part is left to the
    caller, who replaces z by a drilling torque.
    """
    k = -law.mu_r / sqrt(omega.x * omega.x + omega.y * omega.y + STOPS_ROLLING**2)
    return Vector(k * omega.x, k * omega.y, 0)


def torque(drag, omega, law):
    """Return the torque of drilling and of rolling resistance per normal force, (3,) [m].

    It is `FrictionLaw.torque` of the law `contensou`, hence its arguments.
    """
    drilling = -(law.mu * law.patch**2 * drag.twist * omega.z)
    return rolling(omega, law)._replace(z=drilling)

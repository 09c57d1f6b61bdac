"""An impact at one ball: friction followed through it in impulse space (Routh, Stronge).

[contact 3.2, 3.3]

The configuration is frozen; the normal impulse pi is the time, dv = K (zhat - mu n) dpi. With dpi =
w dsigma and the horizontal slip w (cos beta e + sin beta 2hat) nothing is singular where the slip
stops: w falls like an exponential.
"""

from typing import NamedTuple

from ..inlining import inlined
from ..operand import Operand, Vector, dot, formula, plus, sqrt
from .body import angular_velocity, contact_velocity
from .response import Mobility, jumps, mobility


# --- what arrives -------------------------------------------------------------------------------


class Arrival(NamedTuple):
    """A lowest point that meets the plane: its velocity, and what an impact is written in."""

    v: Vector
    e: Vector  # along the horizontal part of 3hat; along v where 3hat is vertical
    s: Operand  # sin(theta)
    along: Operand  # velocity along e
    sideways: Operand  # and along 2hat
    K: Mobility


@formula
@inlined
def meeting(u, L, velocity, b):
    """v_A, sin(theta), the speed of sliding, and the mobility."""
    v, s = contact_velocity(u, L, velocity, b), sqrt(u.x * u.x + u.y * u.y)
    return v, s, sqrt(v.x * v.x + v.y * v.y), mobility(s, u.z, b)


@formula
def arrival(u, L, velocity, b):
    """What arrives, of a body with this axis, momentum and velocity of the centre of mass."""
    v, s, w, K = meeting(u, L, velocity, b)
    none = 0 * s
    if s > 0:
        e = Vector(u.x / s, u.y / s, none)
    elif w > 0:
        e = Vector(v.x / w, v.y / w, none)
    else:
        e = Vector(none + 1, none, none)
    return Arrival(v, e, s, v.x * e.x + v.y * e.y, e.x * v.y - e.y * v.x, K)


class Struck(NamedTuple):
    """A body after an impact: impulses of force and torque, L, velocities of the centre of mass and
    of the contact point, energy gained.
    """

    p: Vector
    twist: Vector
    L: Vector
    velocity: Vector
    v: Vector
    gained: Operand


@formula
def from_frame(e, x):
    """A vector of space, by its components along e, 2hat, zhat."""
    return Vector(x.x * e.x - x.y * e.y, x.x * e.y + x.y * e.x, x.z)


@formula
def to_frame(e, x):
    """The components of a vector along e, 2hat, zhat."""
    return Vector(x.x * e.x + x.y * e.y, x.y * e.x - x.x * e.y, x.z)


@formula
@inlined
def after_impact(u, L, velocity, a, p, twist, b):
    """The body after an impulse at its contact and one of a torque, by components along e, 2hat,
    zhat.
    """
    p, twist = from_frame(a.e, p), from_frame(a.e, twist)
    pushed, turned = jumps(u, p, b)
    velocity, newer = plus(velocity, pushed), plus(plus(L, turned), twist)
    v = contact_velocity(u, newer, velocity, b)
    drilled = dot(twist, plus(angular_velocity(u, L, b), angular_velocity(u, newer, b)))
    return Struck(p, twist, newer, velocity, v, (dot(p, a.v) + dot(p, v) + drilled) / 2)

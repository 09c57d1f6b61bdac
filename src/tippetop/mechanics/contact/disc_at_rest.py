"""A contact disc at rest: what brings it there, what keeps it there, and whether friction that drills can.

At rest neither v_A nor Omega_z changes: a force F and a torque tau zhat see to that. With k = I^-1 zhat, t = k x a and
k_zz = k.zhat, tau is eliminated, and F is that of rolling with K - t t/k_zz instead of K. Friction gives every
(|F_h|/(mu N), |tau|/(mu N patch)) within the curve (f(x), m(x)), and no other.
"""

import math
from typing import Any, NamedTuple

from ..disc_friction import drag
from ..operand import Operand, Vector, cross, dot, formula, plus, sqrt, times
from .body import angular_velocity, arm, axis_rate, contact_velocity
from .response import bias_vector, other_mobility_inverse_times, spin_mobility, torque_acceleration


class Turning(NamedTuple):
    """What a torque about the vertical does."""

    turn: Vector  # k: angular acceleration per torque
    along: Vector  # t: acceleration of the contact point per torque; and Omega_z' per force
    own: Operand  # k_zz: Omega_z' per torque
    excess: Operand  # of K - t t/k_zz, as `other_mobility_inverse_times` takes it


class Held(NamedTuple):
    """The force at the contact and the torque about the vertical there; or their impulses."""

    force: Vector
    torque: Operand


@formula
def turning(u, b):
    """k, t, k_zz; t is along zhat x 3hat."""
    more = (1 / b.I3 - 1 / b.I1) * u.z
    own = spin_mobility(sqrt(u.x * u.x + u.y * u.y), u.z, b).about
    lever = spin_mobility(1, u.z, b).across
    turn = Vector(more * u.x, more * u.y, own)
    excess = b.R**2 * (1 / b.I3 - 1 / b.I1) - lever**2 / own
    return Turning(turn, Vector(-(lever * u.y), lever * u.x, 0 * u.z), own, excess)


@formula
def stopping(u, L, V, b):
    """The impulses that bring the contact point and the turning of the disc to rest, at one instant."""
    w, v, by = angular_velocity(u, L, b), contact_velocity(u, L, V, b), turning(u, b)
    p = other_mobility_inverse_times(u, plus(times(w.z / by.own, by.along), times(-1, v)), by.excess, b)
    return Held(p, -(w.z + dot(p, by.along)) / by.own)


@formula
def stopped(u, L, V, b):
    """L and the velocity of the centre of mass after them."""
    held = stopping(u, L, V, b)
    turn = cross(arm(u, b), held.force)
    return plus(L, Vector(turn.x, turn.y, turn.z + held.torque)), plus(V, times(1 / b.m, held.force))


@formula
def holding(u, L, rolling, body):
    """What keeps a disc at rest, of a body whose v_A and Omega_z are zero; `rolling`, (3,) [m], is the torque of
    rolling resistance per normal force."""
    by, excess = turning(u, body), (1 / body.I3 - 1 / body.I1) * dot(L, u)
    free = excess * axis_rate(u, L, body).z  # Omega_z' without them
    loaded = dot(by.turn, rolling)
    b = plus(bias_vector(u, L, body), times(-free / by.own, by.along))
    r = plus(torque_acceleration(u, rolling, body), times(-loaded / by.own, by.along))
    of_bias = other_mobility_inverse_times(u, b, by.excess, body)
    of_rolling = other_mobility_inverse_times(u, r, by.excess, body)
    N = -of_bias.z / (1 + of_rolling.z)
    F = times(-1, plus(of_bias, times(N, of_rolling)))
    return Held(F, -(free + dot(F, by.along) + N * loaded) / by.own)


HALVINGS = 60  # of the interval in which x = w/U lies


def is_within(force: float, torque: float) -> bool:
    """Whether friction of a disc at rest can give |F_h|/(mu N) and |tau|/(mu N patch)."""
    if not force < 1:
        return False
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):  # x/(1 + x)
        share = (low + high) / 2
        x = share / (1 - share) if share < 1 else 1e16
        low, high = (share, high) if drag(x * x, 1.0).k * x < force else (low, share)
    x = high / (1 - high) if high < 1 else 1e16
    return bool(torque <= drag(x * x, 1.0).twist)


def holds(held: Held, mu: Any, patch: Any) -> bool:
    """Whether friction can give what would keep a disc at rest."""
    F, N = held.force, float(mu * held.force.z)
    if not N > 0:
        return False
    return is_within(math.hypot(F.x, F.y) / N, abs(float(held.torque)) / (N * float(patch)))

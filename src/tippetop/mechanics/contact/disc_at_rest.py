"""A contact disc at rest: what brings it there, what keeps it there, and whether friction that
drills can.

At rest neither v_A nor Omega_z changes: a force F and a torque tau zhat see to that. With k = I^-1
zhat, t = k x a and k_zz = k.zhat, tau is eliminated, and F is that of rolling with K - t t/k_zz
instead of K. Friction gives every (|F_h|/(mu N), |tau|/(mu N patch)) within the curve (f(x), m(x)),
and no other.
"""

import math
from typing import Any, NamedTuple

from ..disc_friction import drag
from ..operand import Operand, Vector, dot, formula, plus, times
from .body import angular_velocity, axis_rate, contact_velocity
from .response import bias_vector, other_mobility_inverse_times, torque_acceleration


class Turning(NamedTuple):
    """Effect of a torque about the vertical."""

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
    """Return k, t, k_zz, and the excess of K; t is along zhat x 3hat."""
    more = 1 / b.I3 - 1 / b.I1
    own = (u.x * u.x + u.y * u.y) / b.I1 + u.z * u.z / b.I3  # regular at the poles
    lever = b.c / b.I1 + b.R * u.z * more
    turn = Vector(more * u.z * u.x, more * u.z * u.y, own)
    excess = b.R**2 * more - lever**2 / own
    return Turning(turn, Vector(-(lever * u.y), lever * u.x, 0 * u.z), own, excess)


@formula
def impulses(u, v, Omega_z, b):
    """Return the impulses that add v to the slip, and Omega_z to the turning of the disc."""
    by = turning(u, b)
    p = other_mobility_inverse_times(u, plus(times(-(Omega_z / by.own), by.along), v), by.excess, b)
    return Held(p, (Omega_z - dot(p, by.along)) / by.own)


@formula
def stopping(u, L, V, b):
    """Return the impulses that bring the contact point and the turning of the disc to rest."""
    return impulses(u, times(-1, contact_velocity(u, L, V, b)), -angular_velocity(u, L, b).z, b)


@formula
def holding(u, L, rolling, body):
    """Return the force and the torque that keep a disc at rest, whose v_A and Omega_z are 0.

    `rolling`, (3,) [m], is the torque of rolling resistance per normal force.
    """
    excess = (1 / body.I3 - 1 / body.I1) * dot(L, u)
    free = excess * axis_rate(u, L, body).z  # Omega_z' without them
    return held_disc(u, bias_vector(u, L, body), free, rolling, body)


@formula
def held_disc(u, bias, free, rolling, body):
    """Return the force and torque that keep a disc at rest.

    Without it, the acceleration of its contact point would be `bias`, and Omega_z' = `free`.
    """
    by = turning(u, body)
    loaded = dot(by.turn, rolling)
    b = plus(bias, times(-free / by.own, by.along))
    r = plus(torque_acceleration(u, rolling, body), times(-loaded / by.own, by.along))
    of_bias = other_mobility_inverse_times(u, b, by.excess, body)
    of_rolling = other_mobility_inverse_times(u, r, by.excess, body)
    N = -of_bias.z / (1 + of_rolling.z)
    F = times(-1, plus(of_bias, times(N, of_rolling)))
    return Held(F, -(free + dot(F, by.along) + N * loaded) / by.own)


HALVINGS = 60  # of the interval in which w/U lies


def sliding_at(force: float) -> float:
    """Return x = w/U at which friction gives |F_h|/(mu N), less than 1."""
    if force <= INSIDE:  # x - x^3/4 = 8 force/(3 pi)
        return 4 / math.sqrt(3) * math.sin(math.asin(2 * math.sqrt(3) / math.pi * force) / 3)
    low, high = 0.5, 1.0
    for _ in range(HALVINGS):  # x/(1 + x)
        share = (low + high) / 2
        x = share / (1 - share)
        low, high = (share, high) if drag(x * x, 1.0).k * x < force else (low, share)
    return low / (1 - low)


INSIDE = drag(1.0, 1.0).k  # |F_h|/(mu N) at x = 1


def margin(force: Any, torque: Any, law: Any) -> float:
    """Return by how much friction of a disc at rest can exceed a torque.

    The torque is about the vertical, per mu N patch.

    Negative where it cannot give the force and the torque together.

    Parameters
    ----------
    force
        On the disc, (3,).
    torque
        About the vertical.
    law
        The record of the law.
    """
    limit = float(law.mu * force.z)
    if not limit > 0:
        return -1.0
    push, torque = math.hypot(force.x, force.y) / limit, abs(float(torque))
    turn = max(torque - float(getattr(law, "mu_d", 0.0) * force.z), 0.0) / (
        limit * float(law.patch)
    )
    if not push < 1:
        return 1 - push - turn
    return float(drag(sliding_at(push) ** 2, 1.0).twist) - turn


MOST = 1 - 2.0**-40  # |F_h|/(mu N) of a disc that hardly turns


def direction(force: Any, torque: Any, law: Any) -> tuple[Vector, float]:
    """Return v_A and the velocity of the edge, of length 1 together.

    They are those of the slide in which friction is that of `margin` where its bound is reached.
    """
    push = math.hypot(force.x, force.y)
    x = sliding_at(min(push / float(law.mu * force.z), MOST))
    length = math.hypot(x, 1.0)
    along = -x / (length * push) if push else 0.0
    edge = -math.copysign(1 / length, torque) if torque else 0.0
    return Vector(along * force.x, along * force.y, 0 * force.z), edge

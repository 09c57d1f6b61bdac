"""Set-valued Coulomb friction at the contact of a ball: slip along a direction, rolling, and its
cone. [contact 2]

A slip direction n is a horizontal unit vector; F = N (zhat - mu n). Everything is singular only
where the contact jams (Painleve: K_zz - mu n_e K_ez = 0, which `uniqueness.painleve_bound`
excludes).
"""

from typing import Any, NamedTuple

from ..friction import load
from ..operand import Operand, Vector, cross, formula, plus, times
from .body import angular_velocity, arm, height
from .response import (
    bias_vector,
    contact_acceleration_vector,
    mobility_inverse_times,
    torque_acceleration,
)


# --- slip ---------------------------------------------------------------------------------------


@formula
def response(u, push, b):
    """zhat.K(zhat - push) [1/kg]: upward acceleration of the contact point for N = 1 and the
    horizontal force -push.
    """
    lever = b.c * (u.x * u.x + u.y * u.y) - height(u.z, b) * (u.x * push.x + u.y * push.y)
    return 1 / b.m + b.c * lever / b.I1


@formula
def loaded_normal_force(u, b, push, tau, body):
    """Return N [N] under the horizontal friction -N push and the torque N tau of a patch that
    drills.
    """
    return -b.z / (response(u, push, body) + torque_acceleration(u, tau, body).z)


@formula
def slip_normal_force_vector(u, b, n, body):
    """N of slip along n, a horizontal unit Vector [N]."""
    return -b.z / response(u, Vector(body.friction.mu * n.x, body.friction.mu * n.y, 0), body)


@formula
def slip_force_vector(u, b, n, body):
    """F of slip along n, a horizontal unit Vector, (3,) [N]."""
    N = slip_normal_force_vector(u, b, n, body)
    return Vector(-(body.friction.mu * N * n.x), -(body.friction.mu * N * n.y), N)


@formula
def along_and_across(G, n):
    """P = n.G, the rate of the slip speed w, and Q = (zhat x n).G, w times the turn of n in space;
    Vectors [m/s^2].
    """
    return n.x * G.x + n.y * G.y, n.x * G.y - n.y * G.x


class Slide(NamedTuple):
    """Slip along a horizontal unit vector n."""

    force: Vector  # (3,) [N]
    torque: Any  # of the contact (3,) [N m]; None: none acts
    turn: Vector  # L' (3,) [N m]
    P: Operand  # rate of w
    Q: Operand  # w times the turn of n


@formula
def slip_motion(u, L, n, body):
    """Slip along the horizontal unit Vector n, with the torque of the law's parts."""
    b, per_force = bias_vector(u, L, body), load(angular_velocity(u, L, body), body.friction)
    if per_force is None:
        F, torque = slip_force_vector(u, b, n, body), None
        G, turn = contact_acceleration_vector(u, b, F, body), cross(arm(u, body), F)
    else:
        push = Vector(body.friction.mu * n.x, body.friction.mu * n.y, 0 * u.z)
        N = loaded_normal_force(u, b, push, per_force, body)
        F, torque = Vector(-(N * push.x), -(N * push.y), N), times(N, per_force)
        G = plus(contact_acceleration_vector(u, b, F, body), torque_acceleration(u, torque, body))
        turn = plus(cross(arm(u, body), F), torque)
    return Slide(F, torque, turn, *along_and_across(G, n))


# --- rolling ------------------------------------------------------------------------------------


@formula
def reaction_of_rolling_vector(u, b, body):
    """F that keeps the contact point at rest, (3,) [N]: -K^-1 b."""
    F = mobility_inverse_times(u, b, body)
    return Vector(-F.x, -F.y, -F.z)


@formula
def sticking(u, L, body):
    """Force and torque (3,) on a body whose contact point stays at rest; the torque is None if the
    law has no parts.
    """
    b, per_force = bias_vector(u, L, body), load(angular_velocity(u, L, body), body.friction)
    if per_force is None:
        return reaction_of_rolling_vector(u, b, body), None
    return held_point(u, b, per_force, body)


@formula
def held_point(u, b, per_force, body):
    """Force and torque (3,) that cancel the acceleration b of the contact point, with this torque
    per normal force.
    """
    of_bias = mobility_inverse_times(u, b, body)
    of_torque = mobility_inverse_times(u, torque_acceleration(u, per_force, body), body)
    N = -of_bias.z / (1 + of_torque.z)
    return times(-1, plus(of_bias, times(N, of_torque))), times(N, per_force)


@formula
def cone(F_1, F_2, N, mu):
    """mu^2 N^2 - |F_h|^2 [N^2] of two horizontal components: falls through zero where
    rolling ends.
    """
    return mu**2 * N**2 - F_1**2 - F_2**2

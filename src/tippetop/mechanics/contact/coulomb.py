"""Set-valued Coulomb friction at the contact of a ball: slip along a direction, rolling, and its
cone. [contact 2]

A slip direction n is a horizontal unit vector; F = N (zhat - mu n). Everything is singular only
where the contact jams (Painleve: K_zz - mu n_e K_ez = 0, which `uniqueness.painleve_bound`
excludes).
"""

from ..friction import load
from ..operand import Vector, formula, plus, times
from .body import angular_velocity, height
from .response import bias_vector, mobility_inverse_times, mobility_times, torque_acceleration


# --- slip ---------------------------------------------------------------------------------------


@formula
def response(u, push, b):
    """Return zhat.K(zhat - push) [1/kg].

    It is the upward acceleration of the contact point for N = 1 and the horizontal force -push.
    """
    lever = b.c * (u.x * u.x + u.y * u.y) - height(u.z, b) * (u.x * push.x + u.y * push.y)
    return 1 / b.m + b.c * lever / b.I1


@formula
def sliding(u, L, push, per_force, body):
    """Return the force and torque (3,) on a body that slides.

    Its contact acts by the horizontal friction -N push and the torque N per_force.
    """
    b = bias_vector(u, L, body)
    N = -b.z / (response(u, push, body) + torque_acceleration(u, per_force, body).z)
    return Vector(-(N * push.x), -(N * push.y), N), times(N, per_force)


@formula
def sliding_along(u, L, n, body):
    """Return the force and torque of sliding along the horizontal unit Vector n."""
    push = Vector(body.friction.mu * n.x, body.friction.mu * n.y, 0 * u.z)
    return sliding(u, L, push, load(angular_velocity(u, L, body), body.friction), body)


@formula
def contact_acceleration(u, L, F, torque, body):
    """Return b + K F and that of a torque, (3,) [m/s^2]."""
    b = plus(bias_vector(u, L, body), mobility_times(u, F, body))
    return plus(b, torque_acceleration(u, torque, body))


@formula
def across_and_along(G, n):
    """Return Q = (zhat x n).G, w times the turn of n in space, and P = n.G.

    P is the rate of the slip speed w; G is a Vector [m/s^2].
    """
    return n.x * G.y - n.y * G.x, n.x * G.x + n.y * G.y


# --- rolling ------------------------------------------------------------------------------------


@formula
def sticking(u, L, body):
    """Return the force and torque (3,) on a body whose contact point stays at rest."""
    per_force = load(angular_velocity(u, L, body), body.friction)
    return held_point(u, bias_vector(u, L, body), per_force, body)


@formula
def held_point(u, b, per_force, body):
    """Return the force and torque (3,) that cancel the acceleration b of the contact point.

    The torque per normal force is given.
    """
    of_bias = mobility_inverse_times(u, b, body)
    of_torque = mobility_inverse_times(u, torque_acceleration(u, per_force, body), body)
    N = -of_bias.z / (1 + of_torque.z)
    return times(-1, plus(of_bias, times(N, of_torque))), times(N, per_force)


@formula
def cone(F, body):
    """Return mu^2 N^2 - |F_h|^2 [N^2]: falls through zero where rolling ends."""
    return (body.friction.mu * F.z) ** 2 - F.x * F.x - F.y * F.y

"""The response of a body to forces, torques and impulses at its contact."""

from typing import NamedTuple

from ..operand import Operand, Vector, cross, dot, formula, plus, times
from .body import angular_velocity, arm, arm2, axis_rate, contact_velocity


@formula
def torque_acceleration(u, tau, b):
    """Return (I^-1 tau) x a, (3,) [m/s^2].

    A torque about the centre of mass gives it to the contact point.
    """
    return cross(angular_velocity(u, tau, b), arm(u, b))


@formula
def mobility_times(u, x, b):
    """Return K x, (3,): x/m + (I^-1 (a x x)) x a.

    K is the acceleration of the contact point per force there, or velocity per impulse [1/kg].
    """
    return plus(times(1 / b.m, x), torque_acceleration(u, cross(arm(u, b), x), b))


@formula
def mobility_inverse_times(u, x, b):
    """Return K^-1 x, (3,): the force or impulse for x at the contact.

    K = kappa - a a/I1 + excess k k, k = zhat x 3hat.
    """
    return other_mobility_inverse_times(u, x, b.R**2 * (1 / b.I3 - 1 / b.I1), b)


@formula
def other_mobility_inverse_times(u, x, excess, b):
    """Return K^-1 x with another excess, which a torque about the vertical changes."""
    a = arm(u, b)
    kappa = 1 / b.m + arm2(u.z, b) / b.I1
    across = u.x * x.y - u.y * x.x  # k.x
    along_k = -(excess * across) / (kappa + excess * (u.x * u.x + u.y * u.y))
    along_a = b.m * dot(a, x) / b.I1
    return Vector(
        (x.x + along_a * a.x - along_k * u.y) / kappa,
        (x.y + along_a * a.y + along_k * u.x) / kappa,
        (x.z + along_a * a.z) / kappa,
    )


@formula
def bias_vector(u, L, b):
    """Return b, (3,) [m/s^2]: (1/I3 - 1/I1) L_3 3hat' x a + offset 3hat'' - g zhat.

    3hat'' is that of free rotation.
    """
    u_dot, L3 = axis_rate(u, L, b), dot(L, u)
    turn = cross(u_dot, arm(u, b))
    precession, swing = cross(u, u_dot), dot(u_dot, u_dot)
    spin, w3 = (1 / b.I3 - 1 / b.I1) * L3, L3 / b.I3
    return Vector(
        spin * turn.x + b.c * (w3 * precession.x - swing * u.x),
        spin * turn.y + b.c * (w3 * precession.y - swing * u.y),
        spin * turn.z + b.c * (w3 * precession.z - swing * u.z) - b.g,
    )


class Struck(NamedTuple):
    """A body after an impact.

    Impulses of force and torque, L, velocities of the centre of mass and of the contact point, and
    energy gained.
    """

    p: Vector
    twist: Vector
    L: Vector
    velocity: Vector
    v: Vector
    gained: Operand


@formula
def after_impact(u, L, velocity, p, twist, b):
    """Return the body after an impulse at its contact and one of a torque."""
    after, newer = plus(velocity, times(1 / b.m, p)), plus(plus(L, cross(arm(u, b), p)), twist)
    v = contact_velocity(u, newer, after, b)
    drilled = dot(twist, plus(angular_velocity(u, L, b), angular_velocity(u, newer, b)))
    worked = dot(p, contact_velocity(u, L, velocity, b)) + dot(p, v)
    return Struck(p, twist, newer, after, v, (worked + drilled) / 2)

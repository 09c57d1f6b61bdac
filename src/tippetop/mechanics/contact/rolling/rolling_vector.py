"""The rolling body in vector form: regular everywhere."""

from ...operand import Vector, dot, formula
from ..body import kinematics, moment, state
from ..gliding.gliding_vector import axis, axis_rate, momentum
from .reaction import completed, normal_force, reaction


# --- vector form: regular everywhere ------------------------------------------------------------


VECTOR_UNITS = state()
"""3hat, and L about the centre of mass. The velocity of the centre of mass is -omega x a."""

VectorState = type(VECTOR_UNITS)


@formula
def centre_velocity(u, u_dot, w3, b):
    """Return r' = -(omega x a), horizontal, (3,) [m/s], with omega = 3hat x 3hat' + w3 3hat.

    `body.centre_velocity`, which takes L instead, has another rounding.
    """
    q = b.c - b.R * u.z
    return Vector(
        -(q * u_dot.x) - b.R * (u.x * u_dot.z - w3 * u.y),
        -(q * u_dot.y) - b.R * (u.y * u_dot.z + w3 * u.x),
        0,
    )


@formula
def vector_scalars(q, b):
    """Return the scalars of a vector state."""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    s = kinematics(u, L, u_dot, b)
    return completed(s, centre_velocity(u, u_dot, s.L3 / b.I3, b), reaction(u, L, u_dot, s, b))


@formula
def vector_rates(q, b):
    """Return 3hat' = L x 3hat/I1, L' = a x F. [section 4]"""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    s = kinematics(u, L, u_dot, b)
    F = reaction(u, L, u_dot, s, b)
    return VectorState(*u_dot, *moment(u, F, b))


@formula
def spin(q, b):
    """Return omega_3 = L.3hat/I3 [rad/s].

    L is about the centre of mass or about a point of the axis.
    """
    return dot(momentum(q), axis(q)) / b.I3


@formula
def velocity(q, carried, b):
    """Return the velocity of the centre of mass, r' = -(omega x a), (3,) [m/s]."""
    u, u_dot = axis(q), axis_rate(q, b)
    return centre_velocity(u, u_dot, kinematics(u, momentum(q), u_dot, b).L3 / b.I3, b)


@formula
def vertical_force(q, carried, b):
    """Return the normal force F_z [N]."""
    return normal_force(kinematics(axis(q), momentum(q), axis_rate(q, b), b), b)

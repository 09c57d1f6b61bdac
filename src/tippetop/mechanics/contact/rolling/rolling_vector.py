"""The rolling body in vector form: regular everywhere."""

from ...operand import dot, formula, times
from ..body import arm_velocity, moment, state
from ..gliding.gliding_chart import angles_by, axis_and_momentum
from ..gliding.gliding_vector import axis, axis_rate, turning
from .reaction import reaction, scalars
from .rolling_euler import ANGLES


VECTOR_UNITS = state()
"""3hat, and L about the centre of mass. The velocity of the centre of mass is -omega x a."""

VectorState = type(VECTOR_UNITS)


@formula
def velocity(q, carried, b):
    """Return the velocity of the centre of mass, -(omega x a), (3,) [m/s]."""
    return times(-1, arm_velocity(turning(q), b))


@formula
def vector_scalars(q, b):
    """Return the scalars of a vector state."""
    return scalars(turning(q), axis_rate(q, b), velocity(q, None, b), b)


@formula
def force(q, b):
    """Return the reaction, (3,) [N]."""
    return reaction(turning(q), b)


@formula
def vector_rates(q, b):
    """Return 3hat' = L x 3hat/I1, L' = a x F. [section 4]"""
    return VectorState(*axis_rate(q, b), *moment(axis(q), force(q, b), b))


@formula
def spin(q, b):
    """Return omega_3 = L.3hat/I3 [rad/s].

    L is about the centre of mass or about a point of the axis.
    """
    x = turning(q)
    return dot(x.L, x.u) / b.I3


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(*u, *L)


angles_of_vector = angles_by(ANGLES, vector_scalars)

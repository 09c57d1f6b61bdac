"""The chart between Euler angles and vectors of a rolling body."""

from ...operand import cos, formula, sin
from ..gliding import chart as gliding_chart
from ..gliding.vector import axis
from .euler import Angles, EulerState
from .vector import VectorState, vector_scalars


# --- the chart between them ---------------------------------------------------------------------


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = gliding_chart.axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(*u, *L)


@formula
def angles_of_vector(q, carried, b):
    """Return the angles of a vector state; 0/0 exactly at a pole, where phi means nothing.

    [section 3.4]
    """
    c = vector_scalars(q, b)
    theta, theta_dot, phi_dot, phi = gliding_chart.axis_angles(c, axis(q))
    return Angles(
        theta, theta_dot, phi_dot, c.L3 / b.I3, phi, carried.x, carried.y, carried.impulse
    )


@formula
def euler_of_angles(e, s, z, b):
    """Return the Euler-angle state of the angles."""
    return EulerState(*e[:4])


@formula
def angles_of_euler(q, carried, b):
    """Return the same angles with theta in [0, pi] and phi in (-pi, pi].

    They are computed by way of the vector state.
    """
    e = Angles(*q[:4], carried.phi, carried.x, carried.y, carried.impulse)
    return angles_of_vector(vector_of_angles(e, sin(e.theta), cos(e.theta), b), carried, b)

"""The chart between Euler angles and vectors of a rolling body."""

from ...operand import cos, formula, sin
from ..gliding import chart as gliding_chart
from ..gliding.vector import axis
from .euler import EulerState
from .vector import VectorState, vector_scalars


# --- the chart between them -----------------------------------------------------------------------------------------


@formula
def vector_of_angles(e, s, z, b):
    """The vector state of an Euler-angle state; s, z are its sin(theta), cos(theta), exact at the poles. [section 1]"""
    u, L = gliding_chart.axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(u.x, u.y, u.z, L.x, L.y, L.z, e.x, e.y, e.impulse)


@formula
def angles_of_vector(q, b):
    """The Euler-angle state of a vector state; 0/0 exactly at a pole, where phi means nothing. [section 3.4]"""
    c = vector_scalars(q, b)
    theta, theta_dot, phi_dot, phi = gliding_chart.axis_angles(c, axis(q))
    return EulerState(theta, theta_dot, phi_dot, c.L3 / b.I3, phi, q.x, q.y, q.impulse)


@formula
def angles_of_euler(e, b):
    """The same angles with theta in [0, pi] and phi in (-pi, pi]: by way of the vector state."""
    return angles_of_vector(vector_of_angles(e, sin(e.theta), cos(e.theta), b), b)

"""The chart between Euler angles and vectors of a rolling body."""

from ...operand import formula
from ..gliding import gliding_chart
from .rolling_euler import ANGLES
from .rolling_vector import VectorState, vector_scalars


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = gliding_chart.axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(*u, *L)


angles_of_vector = gliding_chart.angles_by(ANGLES, vector_scalars)

"""The chart between Euler angles and vectors of a rolling body."""

from ...operand import formula
from ..gliding import chart as gliding_chart
from .euler import ANGLES
from .vector import VectorState, vector_scalars


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = gliding_chart.axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(*u, *L)


angles_of_vector = gliding_chart.angles_by(ANGLES, vector_scalars)

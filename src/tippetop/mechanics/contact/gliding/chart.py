"""The chart between Euler angles and vectors. [T 3.20-3.22; section 3.4 of the derivation]"""

from ...operand import Vector, atan2, cos, formula, sin, sqrt
from ..body import of_azimuth
from .euler import Angles, EulerState, centre_velocity
from .vector import VectorState, axis, vector_scalars


@formula
def axis_and_momentum(e, s, z, I1, I3):
    """Return 3hat and L of a body with the transverse moment I1 and the axial moment I3.

    [section 1]
    """
    ex, ey = cos(e.phi), sin(e.phi)
    L3, transverse, nodal = I3 * e.omega3, -(I1 * e.phi_dot * s), I1 * e.theta_dot
    lean = transverse * z + L3 * s  # L along e; 1hat = z e - s zhat
    return Vector(s * ex, s * ey, z), Vector(
        lean * ex - nodal * ey, lean * ey + nodal * ex, L3 * z - transverse * s
    )


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles; s, z are their sin(theta), cos(theta), exact at the poles.

    [section 1]
    """
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    along_e, along_2 = centre_velocity(e, s, z, b)
    velocity = of_azimuth(along_e, along_2, e.phi)
    return VectorState(*u, *L, b.I3 * e.omega3, *velocity)


@formula
def axis_angles(c, u):
    """Return theta, theta', phi', phi of the axis u with the scalars c.

    They are 0/0 exactly at a pole, where phi is undefined. theta is atan2(sin, cos): no digits are
    lost near the poles. [section 3.4]
    """
    s = sqrt(c.s2)
    return atan2(s, c.z), -c.z_dot / s, c.phi_dot_s2 / c.s2, atan2(u.y, u.x)


@formula
def gliding_angles(c, u, carried, b):
    """Return the angles of a gliding body with the axis u and the scalars c."""
    theta, theta_dot, phi_dot, phi = axis_angles(c, u)
    s = sqrt(c.s2)
    omega3, nu_x, nu_y = c.L3 / b.I3, c.v_u / s, c.v_n / s
    place_and_integrals = (carried.x, carried.y, carried.work, carried.impulse)
    return Angles(theta, theta_dot, phi_dot, omega3, nu_x, nu_y, phi, *place_and_integrals)


@formula
def angles_of_vector(q, carried, b):
    """Return the angles of a vector state."""
    return gliding_angles(vector_scalars(q, b), axis(q), carried, b)


@formula
def euler_of_angles(e, s, z, b):
    """Return the Euler-angle state of the angles."""
    return EulerState(*e[:6])


@formula
def angles_of_euler(q, carried, b):
    """Return the same angles with theta in [0, pi] and phi in (-pi, pi].

    They are computed by way of the vector state.
    """
    e = Angles(*q[:6], carried.phi, carried.x, carried.y, carried.work, carried.impulse)
    return angles_of_vector(vector_of_angles(e, sin(e.theta), cos(e.theta), b), carried, b)

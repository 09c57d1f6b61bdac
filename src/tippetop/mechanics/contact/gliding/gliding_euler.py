"""The gliding body in Euler angles: singular at the poles. [T 3.29-3.34, 5.14-5.18]"""

from ...friction import slip_coefficient
from ...operand import cos, formula, sin
from ...units import JOULE, METRE, METRE_PER_SECOND, NEWTON_SECOND, RADIAN, RADIAN_PER_SECOND
from ..body import (
    Scalars,
    filled,
    g_n,
    height,
    kinematics_of_angles,
    of_azimuth,
    push_across,
    push_along,
    rolling_velocity,
)


EULER_UNITS = filled(
    theta=RADIAN,
    theta_dot=RADIAN_PER_SECOND,
    phi_dot=RADIAN_PER_SECOND,
    omega3=RADIAN_PER_SECOND,
    nu_x=METRE_PER_SECOND,
    nu_y=METRE_PER_SECOND,
)
"""theta, theta', phi', omega_3, v_A = nu_x e + nu_y 2hat."""

ANGLES = filled(
    **EULER_UNITS._asdict(), phi=RADIAN, x=METRE, y=METRE, work=JOULE, impulse=NEWTON_SECOND
)
"""Public variables: the state, phi, and the integrals."""

EulerState, Angles = type(EULER_UNITS), type(ANGLES)


@formula
def centre_velocity(e, s, z, b):
    """Return the components of the velocity of the centre of mass along e and 2hat [m/s].

    [section 3.2]
    """
    along_e, along_2 = rolling_velocity(e.theta_dot, e.phi_dot, e.omega3, s, z, b)
    return e.nu_x + along_e, e.nu_y + along_2


@formula
def euler_scalars(e, b):
    """Return the scalars of an Euler-angle state."""
    s, z = sin(e.theta), cos(e.theta)
    along_e, along_2 = centre_velocity(e, s, z, b)
    speeds2 = e.nu_x**2 + e.nu_y**2, along_e**2 + along_2**2
    return Scalars(*kinematics_of_angles(e, s, z, b), e.nu_x * s, e.nu_y * s, *speeds2)


@formula
def euler_rates(e, b):
    """Return the solved equations in Euler angles.

    [T 3.29-3.34 with 3.32 and 3.34 corrected; 5.14-5.18]
    """
    s, z = sin(e.theta), cos(e.theta)
    c = euler_scalars(e, b)
    N, h, q = g_n(c, b), height(z, b), b.c - b.R * z
    k = slip_coefficient(c.v2, z, b.friction) * N
    Fx, Fy = -(k * e.nu_x), -(k * e.nu_y)  # along e and 2hat
    theta_dot2 = (
        s / b.I1 * (b.I1 * e.phi_dot**2 * z - b.I3 * e.omega3 * e.phi_dot - b.c * N) - h * Fx / b.I1
    )
    phi_dot2 = (b.I3 * e.theta_dot * e.omega3 - 2 * b.I1 * e.theta_dot * e.phi_dot * z + Fy * q) / (
        b.I1 * s
    )
    return EulerState(
        e.theta_dot,
        theta_dot2,
        phi_dot2,
        b.R * s * Fy / b.I3,
        push_along(e.omega3 * (e.phi_dot * s), s, Fx, N, c.axis_speed2, z, b) + e.phi_dot * e.nu_y,
        push_across(e.omega3 * e.theta_dot, Fy, s**2, z, b) - e.phi_dot * e.nu_x,
    )


@formula
def sine_and_cosine(q):
    """Return sin(theta), cos(theta)."""
    return sin(q.theta), cos(q.theta)


@formula
def psi_rate(q, carried, b):
    """Return psi' = omega_3 - phi' cos(theta) [rad/s]. [T 3.22]"""
    return q.omega3 - q.phi_dot * cos(q.theta)


@formula
def velocity(q, carried, b):
    """Return x', y' of the centre of mass [m/s]."""
    along_e, along_2 = centre_velocity(q, sin(q.theta), cos(q.theta), b)
    return of_azimuth(along_e, along_2, carried.phi)

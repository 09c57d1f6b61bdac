"""The rolling body in Euler angles: singular at the poles."""

from ...operand import cos, formula, sin
from ...units import METRE, NEWTON_SECOND, RADIAN, RADIAN_PER_SECOND
from .. import body as contact
from ..body import filled, kinematics_of_angles, of_azimuth
from .reaction import scalars_by_kinematics, spin_determinant


# --- Euler-angle form: singular at the poles ----------------------------------------------------


EULER_UNITS = filled(
    theta=RADIAN, theta_dot=RADIAN_PER_SECOND, phi_dot=RADIAN_PER_SECOND, omega3=RADIAN_PER_SECOND
)
"""Variables theta, theta', phi', omega_3."""

ANGLES = filled(**EULER_UNITS._asdict(), phi=RADIAN, x=METRE, y=METRE, impulse=NEWTON_SECOND)
"""Public variables: the state, phi, and the integrals."""

EulerState, Angles = type(EULER_UNITS), type(ANGLES)


@formula
def euler_accelerations(e, s, z, b):
    """Return theta'', phi'', omega_3' in Euler angles. [T 4.2-4.4]"""
    h, q = contact.height(z, b), b.c - b.R * z
    determinant = spin_determinant(z, b)
    theta_dot2 = (
        s
        * (
            e.phi_dot**2 * (b.I1 * z - b.m * q * h)
            - e.phi_dot * e.omega3 * (b.m * b.R * h + b.I3)
            - b.m * b.c * (b.R * e.theta_dot**2 + b.g)
        )
        / (b.I1 + b.m * contact.arm2(z, b))
    )
    phi_dot2 = (
        e.theta_dot
        / s
        * (e.omega3 * b.I3 * (b.I3 + b.m * b.R * h) / determinant - 2 * e.phi_dot * z)
    )
    omega3_dot = (
        -(b.m * b.R * (e.omega3 * e.theta_dot * s)) * (b.I1 * b.R * z + b.I3 * q) / determinant
    )
    return theta_dot2, phi_dot2, omega3_dot


@formula
def euler_scalars(e, b):
    """Return the scalars of an Euler-angle state."""
    s, z = sin(e.theta), cos(e.theta)
    return scalars_by_kinematics(kinematics_of_angles(e, s, z, b), b)


@formula
def euler_rates(e, b):
    """Return the equations in Euler angles. [T 4.2-4.4]"""
    s, z = sin(e.theta), cos(e.theta)
    return EulerState(e.theta_dot, *euler_accelerations(e, s, z, b))


@formula
def velocity(q, carried, b):
    """Return x', y' of the centre of mass [m/s]."""
    along_e, along_2 = contact.rolling_velocity(
        q.theta_dot, q.phi_dot, q.omega3, sin(q.theta), cos(q.theta), b
    )
    return of_azimuth(along_e, along_2, carried.phi)


@formula
def vertical_force(q, carried, b):
    """Return the normal force m (g + c (theta'' sin(theta) + theta'^2 cos(theta))) [N]."""
    s, z = sin(q.theta), cos(q.theta)
    theta_dot2, _, _ = euler_accelerations(q, s, z, b)
    return b.m * (b.g + b.c * (theta_dot2 * s + q.theta_dot**2 * z))

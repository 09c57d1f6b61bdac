"""A body of revolution whose contact point is at rest, v_A = 0: contact arm a = c*3hat - R*zhat as in `gliding`.

c = alpha*R is the rolling tippe top; R = 0, c = -l a top with its tip fixed. The reaction F = m s'' + m g zhat at the
contact follows from the motion, and is not vertical. Every formula takes its parameters as a `gliding.Body`.
"""

from typing import Any, NamedTuple

from ..operand import Operand, Vector, cos, cross, dot, formula, plus, sin, sqrt, times
from ..system import (
    ANGULAR_MOMENTUM,
    METRE,
    NEWTON,
    NEWTON_SECOND,
    ONE,
    RADIAN,
    RADIAN_PER_SECOND,
    Event,
    Form,
    Quantity,
)
from . import gliding
from .gliding import Body, axis, axis_rate, given_angles, momentum


class Scalars(NamedTuple):
    """Functions of the state that do not depend on the form; smooth at the poles. Names as in `gliding.Scalars`."""

    z: Operand  # cos(theta)
    s2: Operand  # sin(theta)^2
    z_dot: Operand  # -theta' sin(theta)
    fall: Operand  # z'' of the axis if no torque about the centre of mass acted
    precession: Operand  # phi' sin(theta)^2
    axis_speed2: Operand  # |3hat'|^2
    L3: Operand  # L.3hat
    Lz: Operand  # L.zhat, about the centre of mass
    speed2: Operand  # |r'|^2, horizontal velocity of the centre of mass
    grip2: Operand  # |F_h|^2, horizontal part of the reaction


# --- the reaction ---------------------------------------------------------------------------------------------------


@formula
def swing(s, b):
    """q |3hat'|^2 + R omega_3 phi' sin(theta)^2, q = c - R z: what v_A = 0 asks of F.3hat beyond z'' [m/s^2]."""
    return (b.c - b.R * s.z) * s.axis_speed2 + b.R * (s.L3 / b.I3) * s.precession


@formula
def z_dot2(s, b):
    """z'' [1/s^2], from v_A = 0. [equal to T 4.2]"""
    h = b.R - b.c * s.z
    drive = b.c * (b.g * s.s2) + h * swing(s, b)
    return (b.I1 * s.fall + b.m * drive) / (b.I1 + b.m * gliding.arm2(s.z, b))


@formula
def normal_force(s, b):
    """Normal force F_z = m (g - c z'') [N]."""
    return b.m * (b.g - b.c * z_dot2(s, b))


@formula
def push_along(s, b):
    """F_h.3hat [N]: horizontal reaction along the lean of the axis, times sin(theta)."""
    return b.m * (swing(s, b) - (b.R - b.c * s.z) * z_dot2(s, b))


@formula
def spin_rate(s, b):
    """omega_3' [1/s^2]. [T 4.4]"""
    q = b.c - b.R * s.z
    slope = b.I1 * (b.R * s.z) + b.I3 * q
    return b.m * b.R * (s.L3 / b.I3 * s.z_dot) * slope / spin_determinant(s.z, b)


@formula
def spin_determinant(z, b):
    """I3^2 d(z) = I1 I3 + m R^2 I1 sin(theta)^2 + m I3 (c - R z)^2 [kg^2 m^4]. [T 4.2]"""
    return b.I1 * b.I3 + b.m * (b.R**2 * b.I1 * ((1 - z) * (1 + z)) + b.I3 * (b.c - b.R * z) ** 2)


@formula
def horizontal_force(s, b):
    """Size of the horizontal part of the reaction, |F_h| [N]."""
    return sqrt(s.grip2)


@formula
def friction_needed(s, b):
    """Coulomb friction coefficient that pure rolling needs, |F_h|/F_z."""
    return sqrt(s.grip2) / normal_force(s, b)


# --- vector form: regular everywhere --------------------------------------------------------------------------------


class VectorState(NamedTuple):
    """3hat, and L about the centre of mass; then its place and the integral of the normal force. The velocity of the
    centre of mass is -omega x a."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    x: Operand
    y: Operand
    impulse: Operand


VECTOR_UNITS = VectorState._make((*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, METRE, METRE, NEWTON_SECOND))
QUADRATURES = ("x", "y", "impulse")


@formula
def free_scalars(u, L, u_dot, b):
    """The scalars of an axis u, its rate and the momentum L about the centre of mass, without speed2 and grip2."""
    return Scalars(
        z=u.z,
        s2=u.x * u.x + u.y * u.y,
        z_dot=u_dot.z,
        fall=(L.x * u_dot.y - L.y * u_dot.x) / b.I1,
        precession=u.x * u_dot.y - u.y * u_dot.x,
        axis_speed2=dot(u_dot, u_dot),
        L3=dot(L, u),
        Lz=L.z,
        speed2=0,
        grip2=0,
    )


@formula
def centre_velocity(u, u_dot, w3, b):
    """r' = -(omega x a), horizontal, (3,) [m/s], with omega = 3hat x 3hat' + w3 3hat."""
    q = b.c - b.R * u.z
    return Vector(
        -(q * u_dot.x) - b.R * (u.x * u_dot.z - w3 * u.y),
        -(q * u_dot.y) - b.R * (u.y * u_dot.z + w3 * u.x),
        0,
    )


@formula
def reaction(u, L, u_dot, s, b):
    """The reaction F = m s'' + m g zhat at a contact at rest, (3,), space frame [N]; s are the free scalars.

    From L' = a x F, 3hat'' = (L' x 3hat + L x 3hat')/I1 and s' = -omega x a; F.3hat and z'' are known in advance.
    """
    q, N, fall = b.c - b.R * u.z, normal_force(s, b), z_dot2(s, b)
    F3 = push_along(s, b) + N * u.z  # F.3hat
    free = plus(cross(L, u_dot), times(-(b.c * F3), u))  # I1 3hat'' without q F and its vertical part
    spin, w3, yielding = spin_rate(s, b), s.L3 / b.I3, 1 + b.m * q**2 / b.I1
    x = q / b.I1 * free.x + b.R * (fall * u.x - spin * u.y - w3 * u_dot.y)
    y = q / b.I1 * free.y + b.R * (fall * u.y + spin * u.x + w3 * u_dot.x)
    return Vector(-(b.m * x) / yielding, -(b.m * y) / yielding, N)


@formula
def completed(s, v, F):
    """Free scalars with the speed of the centre of mass and the horizontal force."""
    return Scalars(
        s.z, s.s2, s.z_dot, s.fall, s.precession, s.axis_speed2, s.L3, s.Lz, v.x**2 + v.y**2, F.x**2 + F.y**2
    )


@formula
def vector_scalars(q, b):
    """The scalars of a vector state."""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    s = free_scalars(u, L, u_dot, b)
    return completed(s, centre_velocity(u, u_dot, s.L3 / b.I3, b), reaction(u, L, u_dot, s, b))


@formula
def vector_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, r' = -(omega x a). [section 4]"""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    s = free_scalars(u, L, u_dot, b)
    v, F = centre_velocity(u, u_dot, s.L3 / b.I3, b), reaction(u, L, u_dot, s, b)
    h = b.R - b.c * u.z
    return VectorState(
        u_dot.x,
        u_dot.y,
        u_dot.z,
        b.c * (u.y * F.z) + h * F.y,
        -(b.c * (u.x * F.z)) - h * F.x,
        b.c * (u.x * F.y - u.y * F.x),
        v.x,
        v.y,
        F.z,
    )


# --- Euler-angle form: singular at the poles ------------------------------------------------------------------------


class EulerState(NamedTuple):
    """theta, theta', phi', omega_3; then what the equations do not read."""

    theta: Operand
    theta_dot: Operand
    phi_dot: Operand
    omega3: Operand
    phi: Operand
    x: Operand
    y: Operand
    impulse: Operand


EULER_UNITS = EulerState._make((RADIAN, *(RADIAN_PER_SECOND,) * 3, RADIAN, METRE, METRE, NEWTON_SECOND))


@formula
def euler_accelerations(e, s, z, b):
    """theta'', phi'', omega_3' in Euler angles. [T 4.2-4.4]"""
    h, q = b.R - b.c * z, b.c - b.R * z
    determinant = spin_determinant(z, b)
    theta_dot2 = (
        s
        * (
            e.phi_dot**2 * (b.I1 * z - b.m * q * h)
            - e.phi_dot * e.omega3 * (b.m * b.R * h + b.I3)
            - b.m * b.c * (b.R * e.theta_dot**2 + b.g)
        )
        / (b.I1 + b.m * gliding.arm2(z, b))
    )
    phi_dot2 = e.theta_dot / s * (e.omega3 * b.I3 * (b.I3 + b.m * b.R * h) / determinant - 2 * e.phi_dot * z)
    omega3_dot = -(b.m * b.R * (e.omega3 * e.theta_dot * s)) * (b.I1 * b.R * z + b.I3 * q) / determinant
    return theta_dot2, phi_dot2, omega3_dot


@formula
def general_accelerations(e, s, z, w_x, w_y, b):
    """theta'', phi'', omega_3' of any motion whose contact point accelerates by w_x e + w_y 2hat: the general system,
    of which rolling is w = 0. [T 3.36; section 12]"""
    theta_dot2, phi_dot2, omega3_dot = euler_accelerations(e, s, z, b)
    h, q, determinant = b.R - b.c * z, b.c - b.R * z, spin_determinant(z, b)
    return (
        theta_dot2 - b.m * (h * w_x) / (b.I1 + b.m * gliding.arm2(z, b)),
        phi_dot2 + b.m * b.I3 * (q * w_y) / (determinant * s),
        omega3_dot + b.m * b.R * b.I1 * (s * w_y) / determinant,
    )


@formula
def euler_scalars(e, b):
    """The scalars of an Euler-angle state."""
    s, z = sin(e.theta), cos(e.theta)
    h, q = b.R - b.c * z, b.c - b.R * z
    theta_dot2, phi_dot2, omega3_dot = euler_accelerations(e, s, z, b)
    turn = b.R * e.omega3 + e.phi_dot * q
    along_e, along_2 = gliding.rolling_velocity(e.theta_dot, e.phi_dot, e.omega3, s, z, b)
    push_e = theta_dot2 * h + b.c * (e.theta_dot**2 * s) - e.phi_dot * along_2
    push_2 = e.phi_dot * along_e - (
        e.theta_dot * z * turn + s * (b.R * omega3_dot + phi_dot2 * q + e.phi_dot * (b.R * e.theta_dot * s))
    )
    L3 = b.I3 * e.omega3
    precession = e.phi_dot * s**2
    axis_speed2 = e.theta_dot**2 + (e.phi_dot * s) ** 2
    return Scalars(
        z=z,
        s2=s**2,
        z_dot=-(e.theta_dot * s),
        fall=gliding.torque_free(L3, precession, axis_speed2, z, b),
        precession=precession,
        axis_speed2=axis_speed2,
        L3=L3,
        Lz=b.I1 * precession + L3 * z,
        speed2=along_e**2 + along_2**2,
        grip2=b.m**2 * (push_e**2 + push_2**2),
    )


@formula
def euler_rates(e, b):
    """The equations in Euler angles. [T 4.2-4.4]"""
    s, z = sin(e.theta), cos(e.theta)
    theta_dot2, phi_dot2, omega3_dot = euler_accelerations(e, s, z, b)
    along_e, along_2 = gliding.rolling_velocity(e.theta_dot, e.phi_dot, e.omega3, s, z, b)
    return EulerState(
        e.theta_dot,
        theta_dot2,
        phi_dot2,
        omega3_dot,
        e.phi_dot,
        along_e * cos(e.phi) - along_2 * sin(e.phi),
        along_e * sin(e.phi) + along_2 * cos(e.phi),
        b.m * (b.g + b.c * (theta_dot2 * s + e.theta_dot**2 * z)),
    )


# --- the chart between them -----------------------------------------------------------------------------------------


@formula
def vector_of_angles(e, s, z, b):
    """The vector state of an Euler-angle state; s, z are its sin(theta), cos(theta), exact at the poles. [section 1]"""
    u, L = gliding.axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(u.x, u.y, u.z, L.x, L.y, L.z, e.x, e.y, e.impulse)


@formula
def angles_of_vector(q, b):
    """The Euler-angle state of a vector state; 0/0 exactly at a pole, where phi means nothing. [section 3.4]"""
    c = vector_scalars(q, b)
    theta, theta_dot, phi_dot, phi = gliding.axis_angles(c, axis(q))
    return EulerState(theta, theta_dot, phi_dot, c.L3 / b.I3, phi, q.x, q.y, q.impulse)


@formula
def angles_of_euler(e, b):
    """The same angles with theta in [0, pi] and phi in (-pi, pi]: by way of the vector state."""
    return angles_of_vector(vector_of_angles(e, sin(e.theta), cos(e.theta), b), b)


# --- initial data, events, quantities -------------------------------------------------------------------------------

INITIAL = {name: p for name, p in gliding.INITIAL.items() if not name.startswith("nu_")}


def start(data: dict[str, Any], s: Any, z: Any, b: Body) -> EulerState:
    """The Euler record of what a person gave."""
    return given_angles(EulerState, data, z)


VECTOR = Form("vector", VECTOR_UNITS, vector_rates, vector_scalars, vector_of_angles, angles_of_vector, QUADRATURES)
EULER = Form(
    "euler",
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    gliding.euler_of_angles,
    angles_of_euler,
    ("phi", *QUADRATURES),
    (gliding.POLE,),
)
FORMS = {form.name: form for form in (VECTOR, EULER)}

LIFTOFF = Event(
    "liftoff", "normal force falls to zero: beyond it the model does not hold", normal_force, -1, stops=True
)
EVENTS = (gliding.TURNING, LIFTOFF, gliding.EQUATOR, gliding.INVERTED)

REACTION = (
    Quantity("normal_force", "F_z", NEWTON, "normal force", normal_force),
    Quantity("horizontal_force", "|F_h|", NEWTON, "horizontal part of the reaction", horizontal_force),
    Quantity("friction_needed", "|F_h|/F_z", ONE, "Coulomb friction coefficient that rolling needs", friction_needed),
)

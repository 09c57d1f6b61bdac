"""A body of revolution that rolls: its contact point is at rest, v_A = 0.

In go a `body.Touch` and a state; out come its rates, the reaction of the plane, events and columns.
c = alpha R is the rolling tippe top; R = 0, c = -l a top whose tip is fixed. The systems are made
of the constants at the end. The reaction F = m s'' + m g zhat follows from the motion. The vector
form is regular everywhere; Euler angles are singular at the poles.

Symbols
    b         the body, a `body.Touch`
    q         state of the vector form, 3hat and L; in a form of angles, its state
    e         `EulerState`: theta, theta', phi', omega_3; in `vector_of_angles`: record ANGLES
    carried   record of the integrals: phi, x, y, impulse
    x         a `body.Turning` (u, L); u, 3hat: unit vector of the axis
    s, z      sin(theta), cos(theta) in (e, s, z, b); s in (s, b): record of `Scalars` or Kinematics
    L, L3     angular momentum about the centre of mass, L.3hat; s'': acceleration of this point
    A, a      the contact point; the arm c 3hat - R zhat, from the centre of mass to A
    F         force of the plane at A: F_z its normal part, F_h its horizontal one
"""

from dataclasses import replace
from typing import Any

from ..operand import cos, dot, formula, sin, sqrt, times
from ..system import Form, Quantity
from ..units import METRE, NEWTON, NEWTON_SECOND, ONE, RADIAN, RADIAN_PER_SECOND
from . import body as contact
from . import gliding
from .body import arm_velocity, filled, kinematics_of_angles, moment, state
from .body_axes import carried_along
from .gliding import (
    angles_by,
    axis,
    axis_and_momentum,
    axis_rate,
    in_euler_angles,
    place_of_angles,
    spins,
    turning,
)
from .integrals import integral, place
from .response import reaction


FIELDS = (*contact.Kinematics._fields, "speed2", "friction_force2")
Scalars = type(contact.filled(**dict.fromkeys(FIELDS)))
"""The kinematics, speed2 = |r'|^2 of the horizontal velocity of the centre of mass [m^2/s^2], and
friction_force2 = |F_h|^2 of the horizontal part of the reaction [N^2].
"""


# --- the reaction -------------------------------------------------------------------------------


@formula
def motion_terms(s, b):
    """Return q |3hat'|^2 + R omega_3 phi' sin(theta)^2, where q = c - R z [m/s^2].

    The condition v_A = 0 requires 3hat.s'' = this - R z''.
    """
    return (b.c - b.R * s.z) * s.axis_speed2 + b.R * (s.L3 / b.I3) * s.phi_dot_s2


@formula
def z_dot2(s, b):
    """Return z'' = cos(theta)'' [1/s^2], from v_A = 0. [equal to T 4.2]"""
    h = contact.height(s.z, b)
    drive = b.c * (contact.pull(s.z_dot, b) * s.s2) + h * motion_terms(s, b)
    return (b.I1 * s.z_ddot_free + b.m * drive) / (b.I1 + b.m * contact.arm2(s.z, b))


@formula
def normal_force(s, b):
    """Return the normal force F_z = m (g - c z'') [N], with g of `body.pull`."""
    return b.m * (contact.pull(s.z_dot, b) - b.c * z_dot2(s, b))


@formula
def push_along(s, b):
    """Return F_h.3hat [N]: the horizontal force along the lean of the axis, times sin(theta)."""
    return b.m * (motion_terms(s, b) - contact.height(s.z, b) * z_dot2(s, b))


@formula
def push_across(s, b):
    """Return (3hat x F).zhat [N]: the horizontal force across the lean, times sin(theta).

    Like `normal_force` and `push_along`, it is a part of `response.reaction` by scalars.
    """
    return -(contact.bias_n(s, b) / contact.mobility_n(s, b))


@formula
def horizontal_force(s, b):
    """Return |F_h| [N], the size of the horizontal force of the plane; s are `Scalars`."""
    return sqrt(s.friction_force2)


@formula
def friction_needed(s, b):
    """Return |F_h|/F_z, the coefficient of Coulomb friction that rolling needs; s are `Scalars`."""
    return horizontal_force(s, b) / normal_force(s, b)


@formula
def scalars(x, u_dot, v, b):
    """Return the `Scalars` of a `Turning` x with 3hat' = u_dot.

    v: velocity of the centre of mass, (3,).
    """
    F = reaction(x, b)
    return Scalars(*contact.kinematics(x, u_dot, b), v.x**2 + v.y**2, F.x**2 + F.y**2)


@formula
def scalars_by_kinematics(s, b):
    """Return the `Scalars` of `Kinematics` s.

    They are 0/0 at a pole, as |F_h| is computed from its two parts; elsewhere they are equal to
    `scalars` of the same motion. `tippe_top_reduced` calls it too.
    """
    speed2 = contact.arm_speed2(s, b) - (b.c * s.z_dot) ** 2
    return Scalars(*s, speed2, (push_along(s, b) ** 2 + push_across(s, b) ** 2) / s.s2)


# --- Euler angles: singular at the poles ----------------------------------------------------------


EULER_UNITS = filled(
    theta=RADIAN, theta_dot=RADIAN_PER_SECOND, phi_dot=RADIAN_PER_SECOND, omega3=RADIAN_PER_SECOND
)
"""Variables theta, theta', phi', omega_3."""

ANGLES = filled(**EULER_UNITS._asdict(), phi=RADIAN, x=METRE, y=METRE, impulse=NEWTON_SECOND)
"""Public variables: the state, phi, and the integrals."""

EulerState = type(EULER_UNITS)


@formula
def euler_scalars(e, b):
    """Return the `Scalars` of a state e in Euler angles.

    They are singular at a pole; elsewhere equal to `vector_scalars` of the same motion.
    """
    s = sin(e.theta)
    z = cos(e.theta)
    return scalars_by_kinematics(kinematics_of_angles(e, s, z, b), b)


@formula
def euler_rates(e, b):
    """Return the rates of a state e in Euler angles. [equal to T 4.2-4.4]"""
    s = sin(e.theta)
    c = euler_scalars(e, b)
    theta_dot2 = -((z_dot2(c, b) + e.theta_dot**2 * c.z) / s)
    return EulerState(e.theta_dot, theta_dot2, *spins(e, push_across(c, b) / s, b))


@formula
def vertical_force(q, carried, b):
    """Return the normal force of a state q in Euler angles [N]: the rate of `impulse`."""
    return normal_force(euler_scalars(q, b), b)


# --- vector form: regular everywhere --------------------------------------------------------------


VECTOR_UNITS = state()
"""3hat, and L about the centre of mass. The velocity of the centre of mass is -omega x a."""

VectorState = type(VECTOR_UNITS)


@formula
def velocity(q, carried, b):
    """Return the velocity of the centre of mass of a vector state, -(omega x a), (3,) [m/s]."""
    return times(-1, arm_velocity(turning(q), b))


@formula
def vector_scalars(q, b):
    """Return the `Scalars` of a vector state."""
    return scalars(turning(q), axis_rate(q, b), velocity(q, None, b), b)


@formula
def force(q, b):
    """Return the force of the plane in a vector state, (3,) [N]."""
    return reaction(turning(q), b)


@formula
def vector_rates(q, b):
    """Return the rates of a vector state: 3hat' = L x 3hat/I1, L' = a x F."""
    return VectorState(*axis_rate(q, b), *moment(axis(q), force(q, b), b))


@formula
def spin(q, b):
    """Return omega_3 = L.3hat/I3 [rad/s] of a vector state; L about any point of the axis."""
    x = turning(q)
    return dot(x.L, x.u) / b.I3


@formula
def vector_of_angles(e, s, z, b):
    """Return the vector state of angles e; s, z: sin(theta), cos(theta), exact at the poles.

    e: a record ANGLES, with phi, not an `EulerState`. `heavy_top` calls it with b.I1 about the tip.
    """
    u, L = axis_and_momentum(e, s, z, b.I1, b.I3)
    return VectorState(*u, *L)


angles_of_vector = angles_by(ANGLES, vector_scalars)


# --- the catalogue --------------------------------------------------------------------------------


VECTOR = Form(
    "vector",
    VECTOR_UNITS,
    vector_rates,
    vector_scalars,
    vector_of_angles,
    angles_of_vector,
    integrals=(
        *place(velocity),
        integral("impulse", lambda q, carried, b: force(q, b).z),
    ),
    orientation=carried_along(axis_rate, spin),
)
EULER = in_euler_angles(
    ANGLES,
    EULER_UNITS,
    euler_rates,
    euler_scalars,
    (*place_of_angles(contact.rolling_velocity), integral("impulse", vertical_force)),
)
FORMS = {form.name: form for form in (VECTOR, EULER)}
LIFTOFF = replace(
    gliding.LIFTOFF,
    long_name="normal force falls to zero: beyond it the model is not valid",
    formula=normal_force,
)


def of_system_at_rest(of_system: dict[str, Any]) -> dict[str, Any]:
    """Return fields of a System at rest on its contact, by name, from those of one that glides.

    They lack the numbers of v_A, whose names begin with nu_, the flag that replaces them, and laws.
    """
    initial = of_system["initial"]
    undefined = of_system["undefined_at_poles"]
    return of_system | {
        "initial": {name: rule for name, rule in initial.items() if not name.startswith("nu_")},
        "alternatives": tuple(one for one in of_system["alternatives"] if not one.flag),
        "undefined_at_poles": tuple(name for name in undefined if not name.startswith("nu_")),
        "integrals": ("energy",),
        "laws": {},
    }


OF_SYSTEM = of_system_at_rest(gliding.OF_SYSTEM) | {
    "start": gliding.start_of(ANGLES),
    "angles": ANGLES,
    "forms": FORMS,
    "events": (gliding.TURNING, LIFTOFF, gliding.EQUATOR, gliding.INVERTED),
}
"""Fields of a System."""

HORIZONTAL = Quantity(
    "horizontal_force", "|F_h|", NEWTON, "horizontal part of the reaction", horizontal_force
)
FRICTION_NEEDED = Quantity(
    "friction_needed",
    "|F_h|/F_z",
    ONE,
    "Coulomb friction coefficient that rolling needs",
    friction_needed,
)
REACTION = (
    Quantity("normal_force", "F_z", NEWTON, "normal force", normal_force),
    HORIZONTAL,
    FRICTION_NEEDED,
)
"""Columns of a body at rest on its contact; `heavy_top` takes the first two."""

"""The rolling tippe top by its angular momentum about the contact: the form `contact`.

It is regular everywhere. No reaction enters M' = m g a x zhat - m a' x s', and omega follows from M
by division, since lambda = -a.M and D determine the rest. The scalars take 3hat and L, not D and
lambda: that D and lambda of these stay constant remains a check.

Symbols
    b         the body, a `contact.body.Touch`; R, c, I1, I3, m, g are its numbers
    q         a state of the form: 3hat, M_x, M_y, D, lambda (`lam`); carried: record of integrals
    e         record of angles and rates; s, z: sin(theta), cos(theta)
    M, L      angular momentum about the contact, about the centre of mass; M = L - m a x s'
    a, s'     the arm, to the contact point; the velocity of the centre of mass, (3,)
    D         Routh's function; lambda: Jellett's integral; u = 3hat: the axis; z = u_z
"""

from ..contact import body as contact
from ..contact import gliding, rolling
from ..contact.body import AXIS, filled
from ..contact.body_axes import carried_along
from ..contact.gliding import axis
from ..contact.integrals import integral
from ..contact.rolling import VectorState
from ..operand import Vector, cross, formula, plus, times
from ..system import Form
from ..units import ANGULAR_MOMENTUM, JELLETT, ONE
from . import tippe_top
from .tippe_top_reduced import spin_momentum


CONTACT_UNITS = filled(
    **dict.fromkeys(AXIS, ONE),
    Mx=ANGULAR_MOMENTUM,
    My=ANGULAR_MOMENTUM,
    D=ANGULAR_MOMENTUM,
    lam=JELLETT,
)
"""3hat, M_x and M_y about the contact, Routh's function D, Jellett's integral lambda."""

ContactState = type(CONTACT_UNITS)


@formula
def spin(q, b):
    """Return omega_3 [rad/s] of a state, from D."""
    return spin_momentum(q.uz, q.D, b) / b.I3


@formula
def tipping_inertia(q, b):
    """Return I1 + m |a|^2 [kg m^2], the moment about a horizontal line through the contact."""
    return b.I1 + b.m * contact.arm2(q.uz, b)


@formula
def angular_velocity(q, b):
    """Return omega of a state, (3,) in space [rad/s].

    It solves M = (I1 + m |a|^2) omega + (I3 - I1) omega_3 3hat - m (a.omega) a.
    """
    w3 = spin(q, b)
    excess = (b.I3 - b.I1) * w3
    arm_turn = -(q.lam + excess * (b.c - b.R * q.uz)) / b.I1  # a.omega, since a.L = -lambda
    along = b.m * b.c * arm_turn - excess
    inertia = tipping_inertia(q, b)
    return Vector(
        (q.Mx + along * q.ux) / inertia,
        (q.My + along * q.uy) / inertia,
        (b.c * w3 - arm_turn) / b.R,
    )


@formula
def axis_rate(q, b):
    """Return 3hat' = omega x 3hat of a state, (3,) [1/s]."""
    return cross(angular_velocity(q, b), axis(q))


@formula
def momentum(q, b):
    """Return L about the centre of mass of a state, (3,) in space [kg m^2/s]."""
    return plus(times(b.I1, angular_velocity(q, b)), times((b.I3 - b.I1) * spin(q, b), axis(q)))


@formula
def centre_velocity(q, b):
    """Return the horizontal part of s' = -(omega x a), (3,) [m/s]: the rates of x and y."""
    w = angular_velocity(q, b)
    u_dot = axis_rate(q, b)
    return Vector(b.R * w.y - b.c * u_dot.x, -(b.R * w.x) - b.c * u_dot.y, 0)


@formula
def contact_rates(q, b):
    """Return the rates of a state q.

    3hat' = omega x 3hat, M' = m g c (u_y, -u_x) - m c R z' (omega_x, omega_y), D' = lambda' = 0. `0
    * q.D` is a zero of the type of the state's numbers.
    """
    w = angular_velocity(q, b)
    u_dot = axis_rate(q, b)
    weight = b.m * b.g * b.c
    pull = b.m * b.c * b.R
    return ContactState(
        u_dot.x,
        u_dot.y,
        u_dot.z,
        weight * q.uy - pull * (u_dot.z * w.x),
        -(weight * q.ux) - pull * (u_dot.z * w.y),
        0 * q.D,
        0 * q.lam,
    )


@formula
def vertical_force(q, carried, b):
    """Return the normal force m (g - c z'') [N], z'' from (I1 + m |a|^2) z' = M_x u_y - M_y u_x.

    It is the rate of the integral `impulse`; `carried` is there for its signature.
    """
    u_dot = axis_rate(q, b)
    rates = contact_rates(q, b)
    turn = rates.Mx * q.uy - rates.My * q.ux + q.Mx * u_dot.y - q.My * u_dot.x
    # the term is -m (|a|^2)' z', with |a|^2 of `body.arm2`
    z_dot2 = (turn + 2 * (b.m * b.c * b.R) * (u_dot.z * u_dot.z)) / tipping_inertia(q, b)
    return b.m * (b.g - b.c * z_dot2)


@formula
def contact_scalars(q, b):
    """Return the scalars of a state, `rolling.Scalars`, by 3hat and L as in the vector form."""
    x = contact.Turning(axis(q), momentum(q, b))
    return rolling.scalars(x, axis_rate(q, b), centre_velocity(q, b), b)


@formula
def vectors(q, b):
    """Return the state of the vector form: 3hat, and L about the centre of mass."""
    return VectorState(*axis(q), *momentum(q, b))


@formula
def contact_of_angles(e, s, z, b):
    """Return the state q of angles e: `of_angles` of the form.

    s, z are sin(theta), cos(theta), exact at the poles.
    """
    v = rolling.vector_of_angles(e, s, z, b)
    x = gliding.turning(v)
    k = contact.kinematics(x, contact.axis_rate(x, b), b)
    w = contact.angular_velocity(x, b)
    arm = contact.arm(x.u, b)
    M = plus(x.L, times(b.m, cross(arm, cross(w, arm))))
    D = tippe_top.routh(k, b)
    lam = contact.jellett(k, b)
    return ContactState(x.u.x, x.u.y, x.u.z, M.x, M.y, D, lam)


@formula
def angles_of_contact(q, carried, b):
    """Return the record of angles of a state; 0/0 exactly at a pole, where phi is undefined."""
    return rolling.angles_of_vector(vectors(q, b), carried, b)


CONTACT = Form(
    "contact",
    CONTACT_UNITS,
    contact_rates,
    contact_scalars,
    contact_of_angles,
    angles_of_contact,
    vectors=vectors,
    integrals=(
        integral("x", lambda q, carried, b: centre_velocity(q, b).x),
        integral("y", lambda q, carried, b: centre_velocity(q, b).y),
        integral("impulse", vertical_force),
    ),
    orientation=carried_along(axis_rate, spin),
)

"""The equations of each phase, the events that end it, and the row that each of its states stands for.

All are those of one ball of radius R whose centre is c above the centre of mass along -3hat: the body, or its stem.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ...events import Event
from ...form import Form
from ...operand import Operand, Vector, atan2, cos, cross, dot, formula, sin, sqrt, times
from ...units import ANGULAR_MOMENTUM, METRE, METRE_PER_SECOND, ONE, RADIAN
from .. import body as contact
from ..ball import (
    Ball,
    arm,
    bias_vector,
    centre_velocity,
    contact_acceleration_vector,
    contact_velocity,
    height,
)
from ..coulomb import along_and_across, slip_force_vector
from ..gliding import catalogue as gliding
from ..gliding import vector as gliding_vector
from ..integrals import integral
from ..orientation import carried_along
from ..rolling import catalogue as rolling
from ..rolling import reaction as rolling_reaction
from ..rolling import vector as rolling_vector
from ..rolling.reaction import kinematics
from . import row


STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. What is left of it is an impulse."""


class Body(NamedTuple):
    """A gliding body of one ball, and where another ball touches too: clearance + lever cos(theta) = 0, falling."""

    m: Operand
    R: Operand
    c: Operand
    I1: Operand
    I3: Operand
    g: Operand
    friction: Any
    clearance: Operand
    lever: Operand


def body_units(friction: Any) -> Body:
    """The units of a Body."""
    return Body._make((*contact.body_units(friction), METRE, METRE))


PARAMETERS = ("m", "R", "c", "I1", "I3", "g", "clearance", "lever")
"""What a Body is made of beside the friction law."""


def body(parameters: Any, friction: Any) -> Body:
    """The Body of parameters by name."""
    *of_ball, clearance, lever = (parameters[name] for name in PARAMETERS)
    return Body._make((*of_ball, friction, clearance, lever))


class Reached(NamedTuple):
    """What a state of a phase says of the body, as a row has it."""

    u: Vector
    L: Vector
    velocity: Vector  # of the centre of mass
    height: Operand  # of the centre of mass
    force: Vector  # reaction
    drilled: Operand = 0  # power that a torque of the contact takes


# --- events -----------------------------------------------------------------------------------------------------------


@formula
def sliding_left(s, b):
    """|v_A| less the speed at which sliding ends: transversal, as |v_A|^2 is not. [contact 2.2]"""
    return s.w - STOPS_AT


@formula
def cone(s, b):
    """mu^2 N^2 - |F_h|^2: what is left of the friction cone in rolling. [contact 2.3]"""
    return (b.friction.mu * rolling_reaction.normal_force(s, b)) ** 2 - s.friction_force2


@formula
def other_gap(s, b):
    """Height of the other ball above the plane, that of this one being zero. [contact 4.1]"""
    return b.clearance + b.lever * s.z


STICK = Event(
    "stick", "sliding stops, v_A = 0: the contact rolls, if the friction cone allows", sliding_left, -1, "stick"
)
SLIP = Event("slip", "rolling needs more friction than there is: the contact slides", cone, -1, "slip")
TOUCH = Event("touch", "the other ball touches the plane", other_gap, -1, "touch")

SLIPPING = (gliding.LIFTOFF, TOUCH)
ROLLING = (rolling.LIFTOFF, TOUCH, SLIP)


# --- sliding under Coulomb's law itself -------------------------------------------------------------------------------


class DrySlipState(NamedTuple):
    """3hat, L about the centre of mass, v_A = w (cos(beta), sin(beta)) in space axes: so |v_A| keeps its digits,
    and its direction its length, where sliding stops."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    beta: Operand
    w: Operand


class DryScalars(NamedTuple):
    """What its events read."""

    z: Operand  # cos(theta)
    z_dot: Operand
    w: Operand  # |v_A|
    force: Operand  # normal force


@formula
def ball(b):
    """The ball of a body, as the formulas of its contact take it."""
    return Ball(b.m, b.I1, b.I3, b.g, b.friction.mu, b.c, b.R)


@formula
def direction(q):
    """n = v_A/|v_A|, (3,)."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


@formula
def dry_force(q, b):
    """F = N (zhat - mu v_A/|v_A|), (3,) [N]. [contact 2.1]"""
    u = row.axis(q)
    return slip_force_vector(u, bias_vector(u, row.momentum(q), ball(b)), direction(q), ball(b))


@formula
def dry_scalars(q, b):
    """The scalars of a state."""
    return DryScalars(q.uz, row.axis_rate(q, b).z, q.w, dry_force(q, b).z)


@formula
def dry_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, and w', w beta' of v_A' = b + K F. [contact 1, 2.1]"""
    u, F = row.axis(q), dry_force(q, b)
    G = contact_acceleration_vector(u, bias_vector(u, row.momentum(q), ball(b)), F, ball(b))
    P, Q = along_and_across(G, direction(q))
    return DrySlipState._make((*row.axis_rate(q, b), *cross(arm(u, ball(b)), F), Q / q.w, P))


@formula
def dry_velocity(q, b):
    """Velocity of the centre of mass, (3,) [m/s]."""
    return centre_velocity(row.axis(q), row.momentum(q), times(q.w, direction(q)), ball(b))


@formula
def dry_slipping(q, b):
    """What a state says."""
    return Reached(row.axis(q), row.momentum(q), dry_velocity(q, b), height(q.uz, ball(b)), dry_force(q, b))


@formula
def dry_normal_force(s, b):
    """Normal force [N]."""
    return s.force


DRY = Form(
    "vector",
    DrySlipState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, RADIAN, METRE_PER_SECOND),
    dry_rates,
    dry_scalars,
    of_angles=lambda e, s, z, b: None,  # it begins in the state that another phase leaves
    to_angles=lambda q, carried, b: None,
    integrals=(
        integral("x", lambda q, carried, b: dry_velocity(q, b).x),
        integral("y", lambda q, carried, b: dry_velocity(q, b).y),
        integral("work", lambda q, carried, b: -(q.w * dot(direction(q), dry_force(q, b)))),
        integral("impulse", lambda q, carried, b: dry_force(q, b).z),
    ),
    orientation=carried_along(row.axis, row.axis_rate, row.spin),
)
DRY_SLIPPING = (replace(gliding.LIFTOFF, formula=dry_normal_force), TOUCH, STICK)


def dry_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Body) -> Any:
    """The state of sliding of a body on the plane."""
    v = contact_velocity(u, L, velocity, ball(b))
    return DrySlipState(*u, *L, atan2(v.y, v.x), sqrt(v.x * v.x + v.y * v.y))


# --- free flight ------------------------------------------------------------------------------------------------------


class FreeState(NamedTuple):
    """3hat, L and L_3 about the centre of mass, its velocity and height."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    rx_dot: Operand
    ry_dot: Operand
    rz_dot: Operand
    height: Operand


FREE_UNITS = FreeState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 3, METRE)


@formula
def free_scalars(q, b):
    """How the axis moves."""
    return kinematics(row.axis(q), row.momentum(q), row.axis_rate(q, b), b)


@formula
def free_rates(q, b):
    """3hat' = L x 3hat/I1, L' = 0, s'' = -g zhat. [contact 3.1]"""
    none = 0 * q.uz
    return FreeState._make((*row.axis_rate(q, b), none, none, none, none, none, none - b.g, q.rz_dot))


FREE = Form(
    "vector",
    FREE_UNITS,
    free_rates,
    free_scalars,
    of_angles=lambda e, s, z, b: None,  # a flight begins in the state that another phase leaves
    to_angles=lambda q, carried, b: None,
    integrals=(
        integral("x", lambda q, carried, b: q.rx_dot),
        integral("y", lambda q, carried, b: q.ry_dot),
    ),
    orientation=carried_along(row.axis, row.axis_rate, row.spin),
)


# --- states and rows --------------------------------------------------------------------------------------------------


@formula
def slipping(q, b):
    """What a state of sliding says. [contact 2.1]"""
    u, s = gliding_vector.axis(q), gliding_vector.vector_scalars(q, b)
    v, N = gliding_vector.contact_velocity(q, b), contact.g_n(s, b)
    k = gliding_vector.slip_coefficient(s.v2, s.z, b.friction) * N
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * s.z_dot))
    return Reached(u, gliding_vector.momentum(q), velocity, b.R - b.c * u.z, Vector(-(k * v.x), -(k * v.y), N))


@formula
def rolled(q, b):
    """What a state of rolling says. [contact 2.3]"""
    u, L, u_dot = gliding_vector.axis(q), gliding_vector.momentum(q), gliding_vector.axis_rate(q, b)
    s = kinematics(u, L, u_dot, b)
    v = rolling_vector.centre_velocity(u, u_dot, s.L3 / b.I3, b)
    F = rolling_reaction.reaction(u, L, u_dot, s, b)
    return Reached(u, L, Vector(v.x, v.y, -(b.c * s.z_dot)), b.R - b.c * u.z, F)


@formula
def flying(q, b):
    """What a state of flight says. [contact 3.1]"""
    none = 0 * q.uz
    velocity = Vector(q.rx_dot, q.ry_dot, q.rz_dot)
    return Reached(row.axis(q), row.momentum(q), velocity, q.height, Vector(none, none, none))


def slip_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Body) -> Any:
    """The state of sliding of a body on the plane."""
    return gliding_vector.VectorState(*u, *L, dot(L, u), velocity.x, velocity.y)


def roll_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Body) -> Any:
    """The state of rolling of a body whose contact is at rest."""
    return rolling_vector.VectorState(*u, *L)


def free_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Body) -> Any:
    """The state of flight."""
    return FreeState(*u, *L, *velocity, height)


def dry_sliding(u: Vector, L: Vector, w: Any, beta: Any, b: Body) -> Any:
    """The state of sliding with the speed w in the direction beta."""
    return DrySlipState(*u, *L, beta, w)


class Kind(NamedTuple):
    """How a phase moves.

    Parameters
    ----------
    phase
        Its name.
    form
        Its equations.
    events
        What ends it.
    says, state
        says(q, b) -> Reached; state(u, L, velocity, height, b) -> q.
    """

    phase: str
    form: Form
    events: tuple[Event, ...]
    says: Callable
    state: Callable
    sliding: Callable | None = None  # sliding(u, L, w, beta, b) -> q with v_A = w (cos(beta), sin(beta))
    axis_stays: bool = False  # whether theta is constant
    keeps_jellett: bool = True  # whether Jellett's integral, with what is integrated of its loss, is


ROLL_FORM = replace(rolling.VECTOR, domains=())
KINDS = {
    "slip": Kind("slip", gliding.VECTOR, SLIPPING, slipping, slip_state),
    "dry-slip": Kind("slip", DRY, DRY_SLIPPING, dry_slipping, dry_state, dry_sliding),
    "roll": Kind("roll", ROLL_FORM, ROLLING, rolled, roll_state),
    "flight": Kind("flight", FREE, (), flying, free_state),
}
"""Every way that a body moves; sliding with set-valued friction can stop."""

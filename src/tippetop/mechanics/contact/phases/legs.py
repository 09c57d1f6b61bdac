"""The equations of each phase, the events that end it, and the row that each of its states stands for.

All are those of a body seen from one ball, `contact.body.Touch`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ...events import Event
from ...form import Form
from ...operand import Operand, Vector, dot, formula
from ...units import ANGULAR_MOMENTUM, METRE, METRE_PER_SECOND, ONE
from .. import body as contact
from ..body import Touch
from ..gliding import catalogue as gliding
from ..gliding import vector as gliding_vector
from ..integrals import integral
from ..orientation import carried_along
from ..rolling import catalogue as rolling
from ..rolling import reaction as rolling_reaction
from ..rolling import vector as rolling_vector
from ..rolling.reaction import kinematics
from . import row


def body_units(friction: Any) -> Touch:
    """Return the units of a Touch of a body with two balls."""
    return contact.body_units(friction)._replace(clearance=METRE, lever=METRE)


PARAMETERS = tuple(name for name in Touch._fields if name != "friction")
"""The fields of a Touch without the friction law."""


def body(parameters: Any, friction: Any) -> Touch:
    """Return the Touch of parameters by name."""
    return Touch(friction=friction, **parameters)


class Placed(NamedTuple):
    """Where a body is and how it moves."""

    u: Vector
    L: Vector
    velocity: Vector  # of the centre of mass
    height: Operand  # of the centre of mass


class Reached(NamedTuple):
    """What a state of a phase says of the body, as a row has it: where it is, and what the plane does to it."""

    u: Vector
    L: Vector
    velocity: Vector
    height: Operand
    force: Vector  # reaction
    drilled: Operand = 0  # power that a torque of the contact takes


# --- events -----------------------------------------------------------------------------------------------------------


@formula
def cone(s, b):
    """mu^2 N^2 - |F_h|^2: what is left of the friction cone in rolling. [contact 2.3]"""
    return (b.friction.mu * rolling_reaction.normal_force(s, b)) ** 2 - s.friction_force2


@formula
def other_gap(s, b):
    """Height of the other ball above the plane, that of this one being zero. [contact 4.1]"""
    return b.clearance + b.lever * s.z


SLIP = Event("slip", "rolling needs more friction than there is: the contact slides", cone, -1, "slip")
TOUCH = Event("touch", "the other ball touches the plane", other_gap, -1, "touch")

SLIPPING = (gliding.LIFTOFF, TOUCH)
ROLLING = (rolling.LIFTOFF, TOUCH, SLIP)


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
def slip_place(q, b):
    """Where a body is that slides."""
    u = row.axis(q)
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * row.axis_rate(q, b).z))
    return Placed(u, row.momentum(q), velocity, contact.height(u.z, b))


@formula
def slipping(q, b):
    """What a state of sliding says. [contact 2.1]"""
    s, v = gliding_vector.vector_scalars(q, b), gliding_vector.sliding_velocity(q, b)
    N = contact.g_n(s, b)
    k = gliding_vector.slip_coefficient(s.v2, s.z, b.friction) * N
    return Reached._make((*slip_place(q, b), Vector(-(k * v.x), -(k * v.y), N), 0))


@formula
def roll_place(q, b):
    """Where a body is that rolls."""
    u, L, u_dot = row.axis(q), row.momentum(q), row.axis_rate(q, b)
    v = rolling_vector.centre_velocity(u, u_dot, dot(L, u) / b.I3, b)
    return Placed(u, L, Vector(v.x, v.y, -(b.c * u_dot.z)), contact.height(u.z, b))


@formula
def rolled(q, b):
    """What a state of rolling says. [contact 2.3]"""
    u, L, u_dot = row.axis(q), row.momentum(q), row.axis_rate(q, b)
    F = rolling_reaction.reaction(u, L, u_dot, kinematics(u, L, u_dot, b), b)
    return Reached._make((*roll_place(q, b), F, 0))


@formula
def free_place(q, b):
    """Where a body is that flies."""
    return Placed(row.axis(q), row.momentum(q), Vector(q.rx_dot, q.ry_dot, q.rz_dot), q.height)


@formula
def flying(q, b):
    """What a state of flight says. [contact 3.1]"""
    none = 0 * q.uz
    return Reached._make((*free_place(q, b), Vector(none, none, none), 0))


def slip_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Touch) -> Any:
    """The state of sliding of a body on the plane."""
    return gliding_vector.VectorState(*u, *L, dot(L, u), velocity.x, velocity.y)


def roll_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Touch) -> Any:
    """The state of rolling of a body whose contact is at rest."""
    return rolling_vector.VectorState(*u, *L)


def free_state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Touch) -> Any:
    """The state of flight."""
    return FreeState(*u, *L, *velocity, height)


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
    place, says, state
        place(q, b) -> Placed; says(q, b) -> Reached; state(u, L, velocity, height, b) -> q.
    """

    phase: str
    form: Form
    events: tuple[Event, ...]
    place: Callable
    says: Callable
    state: Callable
    sliding: Callable | None = None  # sliding(u, L, w, beta, b) -> q with v_A = w (cos(beta), sin(beta))
    axis_stays: bool = False  # whether theta is constant
    keeps_jellett: bool = True  # whether Jellett's integral, with what is integrated of its loss, is


ROLL_FORM = replace(rolling.VECTOR, domains=())
KINDS = {
    "slip": Kind("slip", gliding.VECTOR, SLIPPING, slip_place, slipping, slip_state),
    "roll": Kind("roll", ROLL_FORM, ROLLING, roll_place, rolled, roll_state),
    "flight": Kind("flight", FREE, (), free_place, flying, free_state),
}
"""Every way that a body moves under a law that is smooth in the sliding velocity, and rolls."""

"""The phases of a body on one of its balls, and in flight: equations, what ends them, and their
common state."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

from ..disc_friction import STOPS_ROLLING, Region, drilling_force, rolling_torque
from ..events import Event
from ..form import Form, Integral, Phase
from ..friction import slip_coefficient
from ..operand import Operand, Vector, atan2, cos, cross, dot, formula, plus, sin, sqrt, times
from ..units import ANGULAR_MOMENTUM, METRE, METRE_PER_SECOND, ONE, RADIAN
from . import body as contact
from .body import Touch, angular_velocity, arm, centre_velocity, contact_velocity, height
from .coulomb import loaded_normal_force, slip_force_vector, slip_motion
from .disc_at_rest import holding, holds, stopped
from .gliding import catalogue as gliding
from .gliding import vector as gliding_vector
from .gliding.vector import VectorState, axis, axis_rate, momentum
from .integrals import integral
from .orientation import carried_along
from .response import bias_vector, contact_acceleration_vector, torque_acceleration
from .rolling import catalogue as rolling
from .rolling import vector as rolling_vector
from .rolling.reaction import kinematics, normal_force, reaction
from .state import LOST, Moving, Reaction


def vector_form(
    units: Any,
    rates: Callable,
    scalars: Callable,
    integrals: Mapping[str, Callable],
    lost: Callable | None = None,
) -> Form:
    """Return the form of a phase whose state has axis and momentum.

    `integrals` are their rates by name, `lost` is the rate at which torques take Jellett's
    integral.
    """
    found = [integral(name, rate) for name, rate in integrals.items()]
    if lost is not None:
        found.append(Integral(*LOST, formula(lost)))
    orientation = carried_along(axis, axis_rate, rolling_vector.spin)
    return Form("vector", units, rates, scalars, integrals=tuple(found), orientation=orientation)


@formula
def force_of(s, b):
    """Normal force [N]."""
    return s.force


@formula
def other_gap(s, b):
    """Height of the other ball above the plane, that of this one being zero. [contact 4.1]"""
    return b.clearance + b.lever * s.z


TOUCH = Event("touch", "the other ball touches the plane", other_gap, -1, "touch")
LIFTOFF = replace(gliding.LIFTOFF, formula=force_of)


# --- free flight ----------------------------------------------------------------------------------


class FreeState(NamedTuple):
    """3hat, L about the centre of mass, its velocity and height."""

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


@formula
def free_rates(q, b):
    """3hat' = L x 3hat/I1, L' = 0, s'' = -g zhat. [contact 3.1]"""
    none = 0 * q.uz
    return FreeState._make((*axis_rate(q, b), none, none, none, none, none, none - b.g, q.rz_dot))


@formula
def free_reaction(q, b):
    """None."""
    none = 0 * q.uz
    return Reaction(Vector(none, none, none))


FLIGHT = Phase(
    {
        "vector": vector_form(
            FreeState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 3, METRE),
            free_rates,
            formula(lambda q, b: kinematics(axis(q), momentum(q), axis_rate(q, b), b)),
            {"x": lambda q, carried, b: q.rx_dot, "y": lambda q, carried, b: q.ry_dot},
        )
    },
    enter=lambda x, b: FreeState._make((*x.u, *x.L, *x.velocity, x.height)),
    leave=lambda q, b: Moving(axis(q), momentum(q), Vector(*q[6:9]), q.height),
    reaction=free_reaction,
    label="flight",
)


# --- sliding under a law that is smooth in the velocity -------------------------------------------


@formula
def slip_leave(q, b):
    """The common state of a body that slides."""
    u = axis(q)
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * axis_rate(q, b).z))
    return Moving(u, momentum(q), velocity, height(u.z, b))


@formula
def slip_reaction(q, b):
    """The force on a body that slides. [contact 2.1]"""
    s, v = gliding_vector.vector_scalars(q, b), gliding_vector.sliding_velocity(q, b)
    N = contact.g_n(s, b)
    k = slip_coefficient(s.v2, s.z, b.friction) * N
    return Reaction(Vector(-(k * v.x), -(k * v.y), N))


SLIP = Phase(
    {"vector": gliding.VECTOR},
    (),
    (gliding.LIFTOFF,),
    enter=lambda x, b: VectorState._make((*x.u, *x.L, dot(x.L, x.u), *x.velocity[:2])),
    leave=slip_leave,
    reaction=slip_reaction,
    label="slip",
)


# --- rolling --------------------------------------------------------------------------------------


@formula
def roll_leave(q, b):
    """The common state of a body that rolls."""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    v = rolling_vector.centre_velocity(u, u_dot, dot(L, u) / b.I3, b)
    return Moving(u, L, Vector(v.x, v.y, -(b.c * u_dot.z)), height(u.z, b))


@formula
def roll_reaction(q, b):
    """The force on a body that rolls. [contact 2.3]"""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    return Reaction(reaction(u, L, u_dot, kinematics(u, L, u_dot, b), b))


@formula
def cone(s, b):
    """mu^2 N^2 - |F_h|^2: what is left of the friction cone in rolling. [contact 2.3]"""
    return (b.friction.mu * normal_force(s, b)) ** 2 - s.friction_force2


CONE = Event(
    "slip",
    "rolling needs more friction than there is: the contact slides",
    cone,
    -1,
    "slip",
)
ROLL = Phase(
    {"vector": replace(rolling.VECTOR, domains=())},
    (),
    (rolling.LIFTOFF, CONE),
    enter=lambda x, b: rolling_vector.VectorState(*x.u, *x.L),
    leave=roll_leave,
    reaction=roll_reaction,
    label="roll",
)


# --- sliding under a set-valued law ---------------------------------------------------------------


STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. What is left of it is an
impulse."""


class DirectedState(NamedTuple):
    """3hat, L about the centre of mass, v_A = w (cos(beta), sin(beta)) in space axes: so |v_A|
    keeps its digits, and its direction its length, where sliding stops."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    beta: Operand
    w: Operand


class DirectedScalars(NamedTuple):
    """The scalars of its events."""

    z: Operand  # cos(theta)
    z_dot: Operand
    w: Operand  # |v_A|
    force: Operand  # normal force


@formula
def direction(q):
    """n = v_A/|v_A|, (3,)."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


@formula
def directed_force(q, b):
    """F = N (zhat - mu v_A/|v_A|), (3,) [N]. [contact 2.1]"""
    u = axis(q)
    return slip_force_vector(u, bias_vector(u, momentum(q), b), direction(q), b)


@formula
def directed_scalars(q, b):
    """The scalars of a state."""
    return DirectedScalars(q.uz, axis_rate(q, b).z, q.w, directed_force(q, b).z)


@formula
def directed_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, and w', w beta' of v_A' = b + K F. [contact 1, 2.1]"""
    u = axis(q)
    F, P, Q = slip_motion(u, momentum(q), direction(q), b)
    return DirectedState._make((*axis_rate(q, b), *cross(arm(u, b), F), Q / q.w, P))


@formula
def directed_leave(q, b):
    """The common state of a body that slides."""
    u, L = axis(q), momentum(q)
    return Moving(u, L, centre_velocity(u, L, times(q.w, direction(q)), b), height(q.uz, b))


def directed(u: Vector, L: Vector, w: Any, beta: Any, b: Touch) -> DirectedState:
    """Return the state of sliding with the speed w in the direction beta."""
    return DirectedState._make((*u, *L, beta, w))


@formula
def directed_enter(x, b):
    """The state of a body that slides."""
    v = contact_velocity(x.u, x.L, x.velocity, b)
    return directed(x.u, x.L, sqrt(v.x * v.x + v.y * v.y), atan2(v.y, v.x), b)


@formula
def sliding_left(s, b):
    """|v_A| less the speed at which sliding ends: transversal, as |v_A|^2 is not. [contact 2.2]"""
    return s.w - STOPS_AT


STICK = Event(
    "stick",
    "sliding stops, v_A = 0: the contact rolls, if the friction cone allows",
    sliding_left,
    -1,
    "stick",
)
DIRECTED_SLIP = Phase(
    {
        "vector": vector_form(
            DirectedState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, RADIAN, METRE_PER_SECOND),
            directed_rates,
            directed_scalars,
            {
                "x": lambda q, carried, b: directed_leave(q, b).velocity.x,
                "y": lambda q, carried, b: directed_leave(q, b).velocity.y,
                "work": lambda q, carried, b: -(q.w * dot(direction(q), directed_force(q, b))),
                "impulse": lambda q, carried, b: directed_force(q, b).z,
            },
        )
    },
    (),
    (LIFTOFF, STICK),
    enter=directed_enter,
    leave=directed_leave,
    reaction=formula(lambda q, b: Reaction(directed_force(q, b))),
    label="slip",
)


# --- sliding of a disc, under a law with regions --------------------------------------------------


STILL = 1e-9
"""Speed of the disc's edge, internal units, below which friction on a disc that does not turn is
smooth. Where such a disc begins to slide, or turns back, the motion differs from that under
Coulomb's law itself by about so much."""

RESTS_BELOW = 1e-4
"""Angular velocity, internal units, below which a disc comes to rest, if friction can hold it: what
is left of its turning lasts some hundredths of internal time."""

LEAST_PATCH = STILL / RESTS_BELOW
"""Radius of the disc, by that of the sphere. The speeds at which a smaller one rests are less than
STILL, where smooth friction lets it creep: it would never come to rest."""


class DiscState(NamedTuple):
    """3hat, L about the centre of mass, v_A."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    vx: Operand
    vy: Operand


class DiscScalars(NamedTuple):
    """The scalars of its events."""

    z: Operand  # cos(theta)
    z_dot: Operand
    force: Operand  # normal force
    v2: Operand  # |v_A|^2
    U2: Operand  # (patch Omega_z)^2


class Loaded(NamedTuple):
    """The contact of a disc with its load."""

    force: Vector
    torque: Vector
    U2: Operand
    omega: Vector


@formula
def patch_speed2(omega, b):
    """U^2 = (patch Omega_z)^2, never quite zero."""
    turn = b.friction.patch * omega.z
    return turn * turn + STILL**2


def disc_friction(drag: Callable, torque: Callable) -> Callable:
    """Return friction(omega, v, z, b) of a disc: minus the horizontal force, and the torque, per
    normal force."""

    def friction(omega: Vector, v: Vector, z: Operand, b: Any) -> tuple[Vector, Vector]:
        by = drag(v.x * v.x + v.y * v.y, patch_speed2(omega, b))
        force = drilling_force(1, v, by, b.friction.mu)
        return Vector(-force.x, -force.y, 0 * omega.z), torque(by, omega, b.friction)

    return friction


@formula
def speed_beyond_rest(s, b):
    """w^2 + U^2 beyond that of a disc that comes to rest."""
    return s.v2 + s.U2 - STILL**2 - (b.friction.patch * RESTS_BELOW) ** 2


RESTS = Event(
    "rests",
    "the contact's disc neither slides nor turns",
    speed_beyond_rest,
    -1,
    "rests",
)


def borders(region: Region) -> list[Event]:
    """Return the events in which a region ends."""
    text = "sliding against turning"
    return [Event(way.event, text, way.beyond, way.direction, way.event) for way in region.borders]


@formula
def disc_leave(q, b):
    """The common state of a body that slides."""
    u, L = axis(q), momentum(q)
    return Moving(u, L, centre_velocity(u, L, Vector(q.vx, q.vy, 0 * q.uz), b), height(q.uz, b))


@formula
def disc_enter(x, b):
    """The state of a body that slides."""
    v = contact_velocity(x.u, x.L, x.velocity, b)
    return DiscState._make((*x.u, *x.L, v.x, v.y))


@lru_cache
def disc_slip(region: Region, torque: Callable) -> Phase:
    """Return the phase of sliding in a region of a law."""
    friction = disc_friction(region.drag, torque)

    @formula
    def loaded(q, b):
        u, L = axis(q), momentum(q)
        omega = angular_velocity(u, L, b)
        push, torque = friction(omega, Vector(q.vx, q.vy, 0 * q.uz), q.uz, b)
        N = loaded_normal_force(u, bias_vector(u, L, b), push, torque, b)
        force = Vector(-(N * push.x), -(N * push.y), N)
        return Loaded(force, times(N, torque), patch_speed2(omega, b), omega)

    @formula
    def scalars(q, b):
        c = loaded(q, b)
        return DiscScalars(q.uz, axis_rate(q, b).z, c.force.z, q.vx * q.vx + q.vy * q.vy, c.U2)

    @formula
    def rates(q, b):
        u, c = axis(q), loaded(q, b)
        G = plus(
            contact_acceleration_vector(u, bias_vector(u, momentum(q), b), c.force, b),
            torque_acceleration(u, c.torque, b),
        )
        turn = plus(cross(arm(u, b), c.force), c.torque)
        return DiscState._make((*axis_rate(q, b), *turn, G.x, G.y))

    @formula
    def power(q, b):
        c = loaded(q, b)
        return -(c.force.x * q.vx + c.force.y * q.vy + dot(c.torque, c.omega))

    @formula
    def reaction(q, b):
        c = loaded(q, b)
        return Reaction(c.force, -dot(c.torque, c.omega))

    form = vector_form(
        DiscState(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 2),
        rates,
        scalars,
        {
            "x": lambda q, carried, b: disc_leave(q, b).velocity.x,
            "y": lambda q, carried, b: disc_leave(q, b).velocity.y,
            "work": lambda q, carried, b: power(q, b),
            "impulse": lambda q, carried, b: loaded(q, b).force.z,
        },
        lost=lambda q, carried, b: dot(loaded(q, b).torque, arm(axis(q), b)),
    )
    events = (LIFTOFF, RESTS, *borders(region))
    return Phase({"vector": form}, (), events, (), disc_enter, disc_leave, reaction, label="slip")


class Disc(NamedTuple):
    """The scalars of borders."""

    v2: Operand
    U2: Operand


def disc_speeds(x: Moving, b: Touch) -> Disc:
    """Return how a disc slides and turns."""
    v, omega = contact_velocity(x.u, x.L, x.velocity, b), angular_velocity(x.u, x.L, b)
    return Disc(v.x * v.x + v.y * v.y, patch_speed2(omega, b))


def regions_of(x: Moving, regions: Mapping[str, Region], *bodies: Touch) -> tuple[str, ...]:
    """Return the regions of a body's sliding on balls; empty under a law that has none.

    A region is the first, by rising x, whose end is not reached."""

    def region(s: Disc, b: Touch) -> str:
        ends = {name: (way for way in one.borders if way.direction > 0) for name, one in regions.items()}
        return next(name for name, ways in ends.items() if all(way.beyond(s, b) < 0 for way in ways))

    return tuple(region(disc_speeds(x, b), b) for b in bodies if regions)


def stays_at_rest(x: Moving, b: Touch) -> bool:
    """Return whether friction can hold the disc of a body, once it is at rest."""
    L, _ = stopped(x.u, x.L, x.velocity, b)
    rolls = rolling_torque(1, angular_velocity(x.u, L, b), b.friction.mu_r, STOPS_ROLLING)
    return holds(holding(x.u, L, rolls, b), b.friction.mu, b.friction.patch)

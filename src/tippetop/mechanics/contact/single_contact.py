"""The phases of a body on one of its balls, and in flight: equations and events, and their common
state."""

from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

from ..disc_friction import Region, drilling_force, rolling
from ..event import Event
from ..form import Form, Integral, Phase
from ..friction import load, slip_coefficient
from ..operand import Vector, atan2, cos, cross, dot, plus, sin, sqrt, times
from ..units import METRE, METRE_PER_SECOND, RADIAN
from . import body as contact
from .body import Touch, angular_velocity, arm, centre_velocity, contact_velocity, height
from .coulomb import loaded_normal_force, slip_motion, sticking
from .disc_at_rest import holding, margin
from .gliding import catalogue as gliding
from .gliding import vector as gliding_vector
from .gliding.vector import VectorState, axis, axis_rate, momentum
from .integrals import NAMED
from .orientation import carried_along
from .response import bias_vector, contact_acceleration_vector, torque_acceleration
from .rolling import catalogue
from .rolling import vector as rolling_vector
from .rolling.reaction import Kinematics, kinematics, normal_force, reaction
from .state import LOST, VELOCITY, Moving, Reaction, filled, state


def phase_of(label: str, units: Any, events: tuple, formulas: tuple, **rates: Callable) -> Phase:
    """Return a phase whose state has axis and momentum.

    `formulas` are the rates of the state, its scalars, `enter`, `leave` and `reaction`; `rates` are
    those of integrals, rate(q, b), besides x and y.
    """
    moved, scalars, enter, leave, reaction = formulas

    def carried(name: str, rate: Callable) -> Integral:
        unit_and_words = LOST[1:] if name == LOST[0] else NAMED[name]
        return Integral(name, *unit_and_words, lambda q, carried, b: rate(q, b))

    place = {name: lambda q, b, k=k: leave(q, b).velocity[k] for k, name in enumerate("xy")}
    integrals = tuple(carried(*item) for item in {**place, **rates}.items())
    turn = carried_along(axis, axis_rate, rolling_vector.spin)
    form = Form("vector", units, moved, scalars, integrals=integrals, orientation=turn)
    return Phase({"vector": form}, (), events, (), enter, leave, reaction, label=label)


class Acts(NamedTuple):
    """What the plane does to a body, and how the contact moves, (3,) each."""

    force: Vector
    torque: Vector
    velocity: Vector
    omega: Vector


def loaded_phase(label: str, units: Any, events: tuple, formulas: tuple, acts: Callable) -> Phase:
    """Return a phase of a contact with a torque.

    `formulas` are those of `phase_of` without `reaction`; acts(q, b) -> Acts.
    """

    def power(q, b):
        F, torque, v, omega = acts(q, b)
        return -(F.x * v.x + F.y * v.y + dot(torque, omega))

    def reaction(q, b):
        by = acts(q, b)
        return Reaction(by.force, -dot(by.torque, by.omega))

    return phase_of(
        label,
        units,
        events,
        (*formulas, reaction),
        work=power,
        impulse=lambda q, b: acts(q, b).force.z,
        jellett_lost=lambda q, b: dot(acts(q, b).torque, arm(axis(q), b)),
    )


def ending(name: str, long_name: str, function: Callable, direction: int = -1) -> Event:
    """Return an event that ends a phase."""
    return Event(name, long_name, function, direction, name)


def force_of(s, b):
    """Normal force [N]."""
    return s.force


def other_gap(s, b):
    """Height of the other ball above the plane, that of this one being zero. [contact 4.1]"""
    return b.clearance + b.lever * s.z


TOUCH = ending("touch", "the other ball touches the plane", other_gap)
LIFTOFF = replace(gliding.LIFTOFF, formula=force_of)


# --- free flight --------------------------------------------------------------------------------


FREE = state(**VELOCITY, height=METRE)
Free: Any = type(filled(**dict.fromkeys((*Kinematics._fields, "height"))))


def free_rates(q, b):
    """3hat' = L x 3hat/I1, L' = 0, s'' = -g zhat. [contact 3.1]"""
    none = 0 * q.uz
    return type(FREE)(*axis_rate(q, b), *(none,) * 5, none - b.g, q.rz_dot)


def own_gap(s, b):
    """Height of the ball above the plane."""
    return contact.gap(s.height, s.z, b)


LAND = ending("land", "the ball lands", own_gap)
FLIGHT = phase_of(
    "flight",
    FREE,
    (LAND, replace(TOUCH, formula=lambda s, b: own_gap(s, b) + other_gap(s, b))),
    (
        free_rates,
        lambda q, b: Free(*kinematics(axis(q), momentum(q), axis_rate(q, b), b), q.height),
        lambda x, b: type(FREE)(*x.u, *x.L, *x.velocity, x.height),
        lambda q, b: Moving(axis(q), momentum(q), Vector(*q[6:9]), q.height),
        lambda q, b: Reaction(Vector(*(0 * q.uz,) * 3)),
    ),
)


# --- sliding under a law that is smooth in the velocity -----------------------------------------


def slip_leave(q, b):
    """The common state of a body that slides."""
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * axis_rate(q, b).z))
    return Moving(axis(q), momentum(q), velocity, height(q.uz, b))


def slip_reaction(q, b):
    """The force on a body that slides. [contact 2.1]"""
    s, v = gliding_vector.vector_scalars(q, b), gliding_vector.sliding_velocity(q, b)
    N = contact.g_n(s, b)
    k = slip_coefficient(s.v2, s.z, b.friction) * N
    return Reaction(Vector(-(k * v.x), -(k * v.y), N))


SLIP = Phase(
    {"vector": gliding.VECTOR},
    (),
    (gliding.LIFTOFF, TOUCH),
    enter=lambda x, b: VectorState._make((*x.u, *x.L, dot(x.L, x.u), *x.velocity[:2])),
    leave=slip_leave,
    reaction=slip_reaction,
    label="slip",
)


# --- rolling ------------------------------------------------------------------------------------


def roll_leave(q, b):
    """The common state of a body that rolls."""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    v = rolling_vector.centre_velocity(u, u_dot, dot(L, u) / b.I3, b)
    return Moving(u, L, v._replace(z=-(b.c * u_dot.z)), height(u.z, b))


def roll_reaction(q, b):
    """The force on a body that rolls. [contact 2.3]"""
    u, L, u_dot = axis(q), momentum(q), axis_rate(q, b)
    return Reaction(reaction(u, L, u_dot, kinematics(u, L, u_dot, b), b))


def cone(s, b):
    """mu^2 N^2 - |F_h|^2: margin of the friction cone in rolling. [contact 2.3]"""
    return (b.friction.mu * normal_force(s, b)) ** 2 - s.friction_force2


CONE = ending("slip", "rolling needs more friction than there is: the contact slides", cone)
ROLL = Phase(
    {"vector": replace(catalogue.VECTOR, domains=())},
    (),
    (catalogue.LIFTOFF, TOUCH, CONE),
    enter=lambda x, b: rolling_vector.VectorState(*x.u, *x.L),
    leave=roll_leave,
    reaction=roll_reaction,
    label="roll",
)


# --- sliding under a set-valued law -------------------------------------------------------------


STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. An impulse takes the rest."""

DIRECTED = state(beta=RADIAN, w=METRE_PER_SECOND)
"""v_A = w (cos(beta), sin(beta)) in space axes: so |v_A| keeps its digits, and its direction its
length, where sliding stops."""

Directed: Any = namedtuple("Directed", "z z_dot w force")


def direction(q):
    """n = v_A/|v_A|, (3,)."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


def directed_slide(q, b):
    """Force and torque of sliding, and what they do. [contact 2.1]"""
    return slip_motion(axis(q), momentum(q), direction(q), b)


def directed_force(q, b):
    """F = N (zhat - mu v_A/|v_A|), (3,) [N]."""
    return directed_slide(q, b).force


def directed_rates(q, b):
    """3hat' = L x 3hat/I1, L' = a x F, and w', w beta' of v_A' = b + K F. [contact 1, 2.1]"""
    by = directed_slide(q, b)
    return type(DIRECTED)(*axis_rate(q, b), *by.turn, by.Q / q.w, by.P)


def on_plane(u, L, v, b):
    """The common state of a body whose lowest point has the velocity v."""
    return Moving(u, L, centre_velocity(u, L, v, b), height(u.z, b))


def directed(u: Vector, L: Vector, w: Any, beta: Any) -> Any:
    """Return the state of sliding with the speed w in the direction beta."""
    return type(DIRECTED)(*u, *L, beta, w)


def directed_enter(x, b):
    """The state of a body that slides."""
    v = contact_velocity(x.u, x.L, x.velocity, b)
    return directed(x.u, x.L, sqrt(v.x * v.x + v.y * v.y), atan2(v.y, v.x))


def directed_leave(q, b):
    """The common state of a body that slides."""
    return on_plane(axis(q), momentum(q), times(q.w, direction(q)), b)


STICK = ending(
    "stick",
    "sliding stops, v_A = 0: the contact rolls, if the friction cone allows",
    lambda s, b: s.w - STOPS_AT,  # transversal, as |v_A|^2 is not [contact 2.2]
)
SLIDES = (
    directed_rates,
    lambda q, b: Directed(q.uz, axis_rate(q, b).z, q.w, directed_force(q, b).z),
    directed_enter,
    directed_leave,
)
DIRECTED_SLIP = phase_of(
    "slip",
    DIRECTED,
    (LIFTOFF, TOUCH, STICK),
    (*SLIDES, lambda q, b: Reaction(directed_force(q, b))),
    work=lambda q, b: -(q.w * dot(direction(q), directed_force(q, b))),
    impulse=lambda q, b: directed_force(q, b).z,
)


# --- sliding of a disc, under a law with regions ------------------------------------------------


STILL = 1e-9
"""Speed of the disc's edge, internal units, below which friction on a disc that does not turn is
smooth. Where such a disc begins to slide, or turns back, the motion differs from that under
Coulomb's law itself by about so much."""

RESTS_BELOW = 1e-6
"""Angular velocity, internal units, below which a disc comes to rest, if friction can hold it. An
impulse takes the rest of its turning, which would last less than a thousandth of internal time.
"""

LEAST_PATCH = 1e-5
"""Radius of the disc, by that of the sphere. The speeds at which a smaller one rests are less than
STILL, where smooth friction lets it creep: it would never come to rest."""

DISC = state(vx=METRE_PER_SECOND, vy=METRE_PER_SECOND)
"""v_A."""

Disc: Any = namedtuple("Disc", "z z_dot force v2 U2")
"""v2 is |v_A|^2, U2 is (patch Omega_z)^2."""

Speeds: Any = namedtuple("Speeds", "v2 U2")


def patch_speed2(omega, b):
    """U^2 = (patch Omega_z)^2, never quite zero."""
    turn = b.friction.patch * omega.z
    return turn * turn + STILL**2


def disc_friction(
    drag: Callable, torque: Callable, edge_speed2: Callable = patch_speed2
) -> Callable:
    """Return friction(omega, v, z, b) of a disc: minus the horizontal force, and the torque, per
    normal force."""

    def friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
        by = drag(v.x * v.x + v.y * v.y, edge_speed2(omega, b))
        force = drilling_force(1, v, by, b.friction.mu)
        return Vector(-force.x, -force.y, 0 * omega.z), torque(by, omega, b.friction)

    return friction


def smooth_friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
    """Return minus the horizontal force, and the torque, per normal force, of a law of the sliding
    velocity."""
    none = 0 * z
    push = times(slip_coefficient(v.x * v.x + v.y * v.y, z, b.friction), v)
    return push._replace(z=none), load(omega, b.friction) or Vector(none, none, none)


def rest_speed2(b):
    """Square of the speed of its edge below which a disc rests."""
    return STILL**2 + (b.friction.patch * RESTS_BELOW) ** 2


RESTS = ending(
    "rests",
    "the contact's disc neither slides nor turns",
    lambda s, b: s.v2 + s.U2 - STILL**2 - rest_speed2(b),
)


def borders(region: Region) -> list[Event]:
    """Return the events in which a region ends."""
    text = "sliding against turning"
    return [ending(way.event, text, way.beyond, way.direction) for way in region.borders]


def disc_enter(x, b):
    """The state of a body that slides."""
    v = contact_velocity(x.u, x.L, x.velocity, b)
    return type(DISC)(*x.u, *x.L, v.x, v.y)


def slip_under(friction: Callable, events: tuple, edge_speed2: Callable) -> Phase:
    """Return the phase of sliding under a law with a torque; edge_speed2(omega, b) -> U^2."""

    def acts(q, b):
        u, L, v = axis(q), momentum(q), Vector(q.vx, q.vy, 0 * q.uz)
        omega = angular_velocity(u, L, b)
        push, torque = friction(omega, v, u.z, b)
        N = loaded_normal_force(u, bias_vector(u, L, b), push, torque, b)
        return Acts(Vector(-(N * push.x), -(N * push.y), N), times(N, torque), v, omega)

    def scalars(q, b):
        by = acts(q, b)
        U2 = edge_speed2(by.omega, b)
        return Disc(q.uz, axis_rate(q, b).z, by.force.z, q.vx * q.vx + q.vy * q.vy, U2)

    def rates(q, b):
        u, by = axis(q), acts(q, b)
        G = plus(
            contact_acceleration_vector(u, bias_vector(u, momentum(q), b), by.force, b),
            torque_acceleration(u, by.torque, b),
        )
        turn = plus(cross(arm(u, b), by.force), by.torque)
        return type(DISC)(*axis_rate(q, b), *turn, G.x, G.y)

    def leave(q, b):
        return on_plane(axis(q), momentum(q), Vector(q.vx, q.vy, 0 * q.uz), b)

    return loaded_phase("slip", DISC, events, (rates, scalars, disc_enter, leave), acts)


@lru_cache
def disc_slip(region: Region, torque: Callable) -> Phase:
    """Return the phase of sliding in a region of a law."""
    events = (LIFTOFF, TOUCH, RESTS, *borders(region))
    return slip_under(disc_friction(region.drag, torque), events, patch_speed2)


def regions_of(x: Moving, regions: Mapping[str, Region], *bodies: Touch) -> tuple[str, ...]:
    """Return the regions of a body's sliding on balls; empty under a law that has none."""
    names = []
    for b in bodies if regions else ():
        v, omega = contact_velocity(x.u, x.L, x.velocity, b), angular_velocity(x.u, x.L, b)
        s = Speeds(v.x * v.x + v.y * v.y, patch_speed2(omega, b))
        names.append(region_of(s, regions, b))
    return tuple(names)


def region_of(s: Any, regions: Mapping[str, Region], b: Touch) -> str:
    """Return the region of sliding at these speeds: the first, by rising x, whose end is not
    reached; or "", of speeds that are not finite."""
    for name, region in regions.items():
        if all(way.direction < 0 or way.beyond(s, b) < 0 for way in region.borders):
            return name
    return ""


# --- a disc at rest, which rolls without turning ------------------------------------------------


Resting: Any = namedtuple("Resting", "z z_dot force by")
"""`by` is what the plane does."""

GIVES = ending(
    "gives",
    "friction can no longer hold the contact's disc: it slides and turns",
    lambda s, b: margin(s.by.force, s.by.torque.z, b.friction),
)
GIVES = replace(GIVES, sampled=True)
ROLLING = state()


def without_slip(label: str, events: tuple, holds: Callable) -> Phase:
    """Return a phase in which the contact point stays at rest, under a law with a torque:
    holds(u, L, b) -> force and torque."""

    def acts(q, b):
        u, L, none = axis(q), momentum(q), 0 * q.uz
        force, torque = holds(u, L, b)
        return Acts(force, torque, Vector(none, none, none), angular_velocity(u, L, b))

    def rates(q, b):
        by = acts(q, b)
        turn = plus(cross(arm(axis(q), b), by.force), by.torque)
        return type(ROLLING)(*axis_rate(q, b), *turn)

    def scalars(q, b):
        by = acts(q, b)
        return Resting(q.uz, axis_rate(q, b).z, by.force.z, by)

    def enter(x, b):
        return type(ROLLING)(*x.u, *x.L)

    return loaded_phase(label, ROLLING, events, (rates, scalars, enter, roll_leave), acts)


def disc_held(u: Vector, L: Vector, b: Touch) -> tuple[Vector, Vector]:
    """Return the force and the torque on a disc that neither slides nor turns."""
    rolls = rolling(angular_velocity(u, L, b), b.friction)
    held = holding(u, L, rolls, b)
    N = held.force.z
    return held.force, Vector(N * rolls.x, N * rolls.y, held.torque)


REST = without_slip("rest", (LIFTOFF, TOUCH, GIVES), disc_held)


# --- laws with rolling resistance and a drilling torque -----------------------------------------


def loaded_cone(s, b):
    """mu^2 N^2 - |F_h|^2."""
    F = s.by.force
    return (b.friction.mu * F.z) ** 2 - F.x * F.x - F.y * F.y


def directed_acts(q, b):
    """What the plane does to a body that slides under a set-valued law."""
    by = directed_slide(q, b)
    omega = angular_velocity(axis(q), momentum(q), b)
    return Acts(by.force, by.torque, times(q.w, direction(q)), omega)


UNLOADED = {"slip": SLIP, "directed": DIRECTED_SLIP, "roll": ROLL}
"""The phases of contacts under laws without torques."""

LOADED = {
    "slip": slip_under(smooth_friction, (LIFTOFF, TOUCH), lambda omega, b: 0 * omega.z),
    "directed": loaded_phase("slip", DIRECTED, (LIFTOFF, TOUCH, STICK), SLIDES, directed_acts),
    "roll": without_slip("roll", (LIFTOFF, TOUCH, replace(CONE, formula=loaded_cone)), sticking),
}
"""The phases of contacts under laws with parts, apart from those of discs."""

"""The phases of a body on one of its balls, and in flight: equations and events, and their common
state."""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ..disc_friction import Region, drilling_force
from ..event import Event
from ..form import Form, Phase
from ..friction import load, slip_coefficient
from ..operand import Vector, atan2, cos, cross, dot, plus, sin, sqrt, times
from ..units import METRE, METRE_PER_SECOND, RADIAN
from . import gliding
from .body import (
    VELOCITY,
    Moving,
    Reaction,
    Touch,
    angular_velocity,
    arm,
    centre_velocity,
    contact_velocity,
    height,
    state,
    velocities,
)
from .body_axes import carried_along
from .gliding import VectorState, axis, axis_rate, turning
from .integrals import integral, place
from .response import (
    across_and_along,
    cone,
    contact_acceleration,
    margin,
    resting,
    sliding,
    sliding_along,
    sticking,
)
from .rolling import spin


def phase_of(units: Any, events: tuple, formulas: tuple, **rates: Callable) -> Phase:
    """Return a phase whose state has axis and momentum.

    `formulas` are the rates of the state, its scalars, `enter`, `leave` and `reaction`; `rates` are
    those of integrals, rate(q, carried, b), besides x and y.
    """
    moved, scalars, enter, leave, reaction = formulas
    integrals = (
        *place(lambda q, carried, b: leave(q, b).velocity),
        *(integral(name, rate) for name, rate in rates.items()),
    )
    turn = carried_along(axis_rate, spin)
    form = Form("vector", units, moved, scalars, integrals=integrals, orientation=turn)
    return Phase(form, (), events, (), enter, leave, reaction)


class Acts(NamedTuple):
    """Force and torque of the plane on a body, v_A and omega, (3,) each."""

    force: Vector
    torque: Vector
    velocity: Vector
    omega: Vector
    sides: tuple = ()  # the actions on each ball, if there are two


Contact: Any = namedtuple("Contact", "z z_dot force by sides q")
"""`force` is the normal force, `by` the action of the plane, `sides` that on each ball in contact,
`q` the state.
"""


def on_ball(
    units: Any,
    events: tuple,
    forces: Callable,
    velocity: Callable,
    enter: Callable,
    changes: Callable,
) -> Phase:
    """Return a phase on one ball.

    Parameters
    ----------
    forces
        forces(turning(q), q, b) -> force and torque of the plane, and the actions on both balls, if
        both touch.
    velocity
        velocity(q) -> v_A.
    enter
        enter(v) -> what the state has besides axis and momentum, of v_A.
    changes
        changes(q, G) -> the rates of that, of the acceleration G of the contact point.
    """

    def acts(q, b):
        x = turning(q)
        force, torque, *sides = forces(x, q, b)
        return Acts(force, torque, velocity(q), angular_velocity(x, b), tuple(sides))

    def rates(q, b):
        by = acts(q, b)
        turn = plus(cross(arm(axis(q), b), by.force), by.torque)
        G = contact_acceleration(turning(q), by.force, by.torque, b)
        return type(units)(*axis_rate(q, b), *turn, *changes(q, G))

    def scalars(q, b):
        by = acts(q, b)
        return Contact(q.uz, axis_rate(q, b).z, by.force.z, by, by.sides or (by,), q)

    def entered(x, b):
        return type(units)(*x.u, *x.L, *enter(contact_velocity(x, b)))

    def leave(q, b):
        return on_plane(turning(q), velocity(q), b)

    def reaction(q, b):
        by = acts(q, b)
        return Reaction(by.force, -dot(by.torque, by.omega))

    def power(q, carried, b):
        by = acts(q, b)
        return -(dot(by.force, by.velocity) + dot(by.torque, by.omega))

    return phase_of(
        units,
        events,
        (rates, scalars, entered, leave, reaction),
        work=power,
        impulse=lambda q, carried, b: acts(q, b).force.z,
        jellett_lost=lambda q, carried, b: dot(acts(q, b).torque, arm(axis(q), b)),
    )


def on_plane(x, v, b):
    """Return the common state of a body whose lowest point has the velocity v."""
    return Moving(x.u, x.L, centre_velocity(x, v, b), height(x.u.z, b))


def none(q: Any) -> Vector:
    """Return no velocity, or no force."""
    return Vector(*(0 * q.uz,) * 3)


def ending(name: str, long_name: str, function: Callable, direction: int = -1) -> Event:
    """Return an event that ends a phase."""
    return Event(name, long_name, function, direction, name)


def force_of(s, b):
    """Return the normal force [N]."""
    return s.force


def other_gap(s, b):
    """Return the height of the other ball above the plane, that of this one being zero.

    [contact 4.1]
    """
    return b.clearance + b.lever * s.z


TOUCH = ending("touch", "the other ball touches the plane", other_gap)
LIFTOFF = replace(gliding.LIFTOFF, formula=force_of)


# --- free flight --------------------------------------------------------------------------------


FREE = state(**VELOCITY, height=METRE)
Free: Any = namedtuple("Free", "z z_dot height")


def free_rates(q, b):
    """Return 3hat' = L x 3hat/I1, L' = 0, s'' = -g zhat. [contact 3.1]"""
    still = 0 * q.uz
    return type(FREE)(*axis_rate(q, b), *(still,) * 5, still - b.g, q.rz_dot)


def own_gap(s, b):
    """Return the height of the ball above the plane."""
    return s.height - height(s.z, b)


LAND = ending("land", "the ball lands", own_gap)
FLIGHT = phase_of(
    FREE,
    (LAND, replace(TOUCH, formula=lambda s, b: own_gap(s, b) + other_gap(s, b))),
    (
        free_rates,
        lambda q, b: Free(q.uz, axis_rate(q, b).z, q.height),
        lambda x, b: type(FREE)(*x.u, *x.L, *x.velocity, x.height),
        lambda q, b: Moving(axis(q), turning(q).L, Vector(*q[6:9]), q.height),
        lambda q, b: Reaction(none(q)),
    ),
)


# --- sliding under a law that is smooth in the velocity -----------------------------------------


def slip_leave(q, b):
    """Return the common state of a body that slides."""
    velocity = Vector(q.rx_dot, q.ry_dot, -(b.c * axis_rate(q, b).z))
    return Moving(axis(q), turning(q).L, velocity, height(q.uz, b))


SLIP = Phase(
    gliding.VECTOR,
    (),
    (gliding.LIFTOFF, TOUCH),
    enter=lambda x, b: VectorState(*x.u, *x.L, dot(x.L, x.u), *x.velocity[:2]),
    leave=slip_leave,
    reaction=lambda q, b: Reaction(gliding.reaction(q, b)),
)


# --- rolling, and sliding under a set-valued law -----------------------------------------------


def without_slip(events: tuple, holds: Callable) -> Phase:
    """Return a phase in which the contact point stays at rest: holds(x, b) -> force, torque."""
    forces = lambda x, q, b: holds(x, b)  # noqa: E731
    return on_ball(state(), events, forces, none, lambda v: (), lambda q, G: ())


CONE = ending(
    "slip",
    "rolling needs more friction than there is: the contact slides",
    lambda s, b: cone(s.by.force, b),
)
ROLL = without_slip((LIFTOFF, TOUCH, CONE), sticking)

STOPS_AT = 2.0**-43
"""|v_A| at which a sliding contact stops, internal units: 1.1e-13. An impulse takes the rest."""

DIRECTED = state(beta=RADIAN, w=METRE_PER_SECOND)
"""v_A = w (cos(beta), sin(beta)) in space axes: so |v_A| keeps its digits, and its direction its
length, where sliding stops."""


def direction(q: Any) -> Vector:
    """Return n = v_A/|v_A|, (3,)."""
    return Vector(cos(q.beta), sin(q.beta), 0 * q.w)


def directed_changes(q, G):
    """Return beta' and w' of v_A' = b + K F. [contact 1, 2.1]"""
    across, along = across_and_along(G, direction(q))
    return across / q.w, along


STICK = ending(
    "stick",
    "sliding stops, v_A = 0: the contact rolls, if the friction cone allows",
    lambda s, b: s.q.w - STOPS_AT,  # transversal, as |v_A|^2 is not [contact 2.2]
)
DIRECTED_SLIP = on_ball(
    DIRECTED,
    (LIFTOFF, TOUCH, STICK),
    lambda x, q, b: sliding_along(x, direction(q), b),
    lambda q: times(q.w, direction(q)),
    lambda v: (atan2(v.y, v.x), sqrt(v.x * v.x + v.y * v.y)),
    directed_changes,
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

Speeds: Any = namedtuple("Speeds", "v2 U2")


def patch_speed2(omega, b):
    """Return U^2 = (patch Omega_z)^2, never quite zero."""
    turn = b.friction.patch * omega.z
    return turn * turn + STILL**2


def disc_friction(
    drag: Callable, torque: Callable, edge_speed2: Callable = patch_speed2
) -> Callable:
    """Return friction(omega, v, z, b) of a disc.

    It gives minus the horizontal force, and the torque, per normal force.
    """

    def friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
        by = drag(v.x * v.x + v.y * v.y, edge_speed2(omega, b))
        force = drilling_force(1, v, by, b.friction.mu)
        return Vector(-force.x, -force.y, 0 * omega.z), torque(by, omega, b.friction)

    return friction


def smooth_friction(omega: Vector, v: Vector, z: Any, b: Any) -> tuple[Vector, Vector]:
    """Return minus the horizontal force, and the torque, per normal force.

    The law is one of the sliding velocity.
    """
    push = times(slip_coefficient(v.x * v.x + v.y * v.y, z, b.friction), v)
    return push._replace(z=0 * z), load(omega, b.friction)


def rest_speed2(b):
    """Return the square of the speed of its edge below which a disc rests."""
    return STILL**2 + (b.friction.patch * RESTS_BELOW) ** 2


def speeds(v: Vector, omega: Vector, b: Touch) -> Speeds:
    """Return the squares of the speeds of a contact."""
    return Speeds(v.x * v.x + v.y * v.y, patch_speed2(omega, b))


def beyond_rest(s, b):
    """Return the square of the speeds of contacts beyond those of discs at rest."""
    moves = (sum(speeds(side.velocity, side.omega, b)) for side in s.sides)
    return sum(speed2 - STILL**2 - rest_speed2(b) for speed2 in moves)


RESTS = ending("rests", "the contact's disc neither slides nor turns", beyond_rest)


def borders(region: Region, side: int = 0, prefix: str = "") -> list[Event]:
    """Return the events in which a region ends, of one of the contacts."""

    def end(way: Any) -> Event:
        def beyond(s, b):
            by = s.sides[side]
            return way.beyond(speeds(by.velocity, by.omega, b), b)

        return ending(prefix + way.event, "sliding against turning", beyond, way.direction)

    return [end(way) for way in region.borders]


def with_slip(events: tuple, pushed: Callable) -> Phase:
    """Return a phase of sliding in any direction: pushed(x, v, b) -> force, torque."""

    def velocity(q):
        return Vector(q.vx, q.vy, 0 * q.uz)

    forces = lambda x, q, b: pushed(x, velocity(q), b)  # noqa: E731
    return on_ball(DISC, events, forces, velocity, lambda v: v[:2], lambda q, G: G[:2])


def slip_under(friction: Callable, *events: Event) -> Phase:
    """Return the phase of sliding under friction(omega, v, z, b), with a torque."""

    def pushed(x, v, b):
        push, per_force = friction(angular_velocity(x, b), v, x.u.z, b)
        return sliding(x, push, per_force, b)

    return with_slip((LIFTOFF, TOUCH, *events), pushed)


def regions_of(x: Moving, *bodies: Touch) -> tuple[str, ...]:
    """Return the regions of a body's sliding on balls; empty under a law that has none."""
    names = []
    for b in bodies if bodies[0].friction.regions else ():
        v, omega = velocities(x, b)
        names.append(region_of(speeds(v, omega, b), b))
    return tuple(names)


def region_of(s: Any, b: Touch) -> str:
    """Return the region of sliding at these speeds.

    It is the first, by rising x, whose end is not reached; or "", of speeds that are not finite.
    """
    for name, region in b.friction.regions.items():
        if all(way.direction < 0 or way.beyond(s, b) < 0 for way in region.borders):
            return name
    return ""


# --- a disc at rest, which rolls without turning ------------------------------------------------


GIVES = ending(
    "gives",
    "friction can no longer hold the contact's disc: it slides and turns",
    lambda s, b: margin(s.by.force, s.by.torque.z, b.friction),
)
GIVES = replace(GIVES, sampled=True)


REST = without_slip((LIFTOFF, TOUCH, GIVES), resting)


LOADED_SLIP = slip_under(smooth_friction)
"""Sliding under a law that is smooth in the velocity and has a torque."""


def slides(law: Any) -> dict[tuple[str, ...], Phase]:
    """Return the phases of sliding under a law, by the regions of the law."""
    if law.regions:
        return {
            (name,): slip_under(disc_friction(region.drag, law.torque), RESTS, *borders(region))
            for name, region in law.regions.items()
        }
    if law.set_valued:
        return {(): DIRECTED_SLIP}
    return {(): LOADED_SLIP if law.torque else SLIP}

"""Sliding under friction that drills, which takes energy and Jellett's integral by its torque.

It stops only where turning does, both at once; before that the equations are as stiff as 1/Omega_z. What follows, a
disc that sticks, has no equations here.
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from ...disc_friction import EDGE, OUTSIDE_FROM, REGIONS, STOPS_ROLLING, drilling_force, rolling_torque, torque
from ...events import Event
from ...form import Form, Integral
from ...operand import Operand, Vector, cross, dot, formula, plus, times
from ...units import ANGULAR_MOMENTUM, JELLETT, METRE_PER_SECOND, ONE
from ..body import angular_velocity, arm, centre_velocity, contact_velocity, height
from ..coulomb import loaded_normal_force
from ..disc_at_rest import holding, holds, stopped
from ..gliding import catalogue as gliding
from ..integrals import integral
from ..orientation import carried_along
from ..response import bias_vector, contact_acceleration_vector, torque_acceleration
from . import legs, row


STILL = 1e-9
"""Speed of the disc's edge, internal units, below which friction on a disc that does not turn is smooth. Where such a
disc begins to slide, or turns back, the motion differs from that under Coulomb's law by about so much."""


RESTS_BELOW = 1e-4
"""Angular velocity, internal units, below which a disc comes to rest, if friction can hold it: what is left of its
turning lasts some hundredths of internal time."""


LEAST_PATCH = STILL / RESTS_BELOW
"""Radius of the disc, by that of the sphere. The speeds at which a smaller one rests are less than STILL, where smooth
friction lets it creep: it would never come to rest."""


class State(NamedTuple):
    """3hat, L about the centre of mass, v_A."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    vx: Operand
    vy: Operand


class Scalars(NamedTuple):
    """What its events read."""

    z: Operand  # cos(theta)
    z_dot: Operand
    force: Operand  # normal force
    v2: Operand  # |v_A|^2
    U2: Operand  # (patch Omega_z)^2


class Contact(NamedTuple):
    """What the plane does to the body."""

    force: Vector
    torque: Vector
    U2: Operand
    omega: Vector


@formula
def patch_speed2(omega, b):
    """U^2 = (patch Omega_z)^2, never quite zero."""
    turn = b.friction.patch * omega.z
    return turn * turn + STILL**2


@formula
def per_force(drag, omega, v, b):
    """Of friction per normal force: minus the horizontal force, and the torque, (3,) each."""
    force = drilling_force(1, v, drag, b.friction.mu)
    return Vector(-force.x, -force.y, 0 * omega.z), torque(drag, omega, b.friction)


def _contact(drag: Callable) -> Callable:
    """contact(q, b) in the region of this drag."""

    @formula
    def contact(q, b):
        u, L, v = row.axis(q), row.momentum(q), Vector(q.vx, q.vy, 0 * q.uz)
        omega = angular_velocity(u, L, b)
        U2 = patch_speed2(omega, b)
        push, torque = per_force(drag(v.x * v.x + v.y * v.y, U2), omega, v, b)
        N = loaded_normal_force(u, bias_vector(u, L, b), push, torque, b)
        return Contact(Vector(-(N * push.x), -(N * push.y), N), times(N, torque), U2, omega)

    return contact


def _form(name: str, contact: Callable) -> Form:
    """The equations in a region."""

    @formula
    def scalars(q, b):
        c = contact(q, b)
        return Scalars(q.uz, row.axis_rate(q, b).z, c.force.z, q.vx * q.vx + q.vy * q.vy, c.U2)

    @formula
    def rates(q, b):
        u, c = row.axis(q), contact(q, b)
        G = plus(
            contact_acceleration_vector(u, bias_vector(u, row.momentum(q), b), c.force, b),
            torque_acceleration(u, c.torque, b),
        )
        turn = plus(cross(arm(u, b), c.force), c.torque)
        return State._make((*row.axis_rate(q, b), *turn, G.x, G.y))

    @formula
    def power(q, b):
        c = contact(q, b)
        return -(c.force.x * q.vx + c.force.y * q.vy + dot(c.torque, c.omega))

    return Form(
        "vector",
        State(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 2),
        rates,
        scalars,
        of_angles=lambda e, s, z, b: None,  # it begins in the state that another phase leaves
        to_angles=lambda q, carried, b: None,
        integrals=(
            integral("x", lambda q, carried, b: place(q, b).velocity.x),
            integral("y", lambda q, carried, b: place(q, b).velocity.y),
            integral("work", lambda q, carried, b: power(q, b)),
            integral("impulse", lambda q, carried, b: contact(q, b).force.z),
            Integral(
                *LOST, formula(lambda q, carried, b: dot(contact(q, b).torque, arm(row.axis(q), b)))
            ),
        ),
        orientation=carried_along(row.axis, row.axis_rate, row.spin),
    )  # fmt: skip


LOST = ("jellett_lost", JELLETT, "Jellett's integral taken by the torque of the contact since the start")


@formula
def place(q, b):
    """Where the body is."""
    u, L = row.axis(q), row.momentum(q)
    velocity = centre_velocity(u, L, Vector(q.vx, q.vy, 0 * q.uz), b)
    return legs.Placed(u, L, velocity, height(q.uz, b))


def _says(contact: Callable) -> Callable:
    @formula
    def says(q, b):
        c = contact(q, b)
        return legs.Reached._make((*place(q, b), c.force, -dot(c.torque, c.omega)))

    return says


def state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Any) -> State:
    """The state of sliding of a body on the plane."""
    v = contact_velocity(u, L, velocity, b)
    return State(*u, *L, v.x, v.y)


# --- from region to region --------------------------------------------------------------------------------------------


@formula
def normal_force(s, b):
    """Normal force [N]."""
    return s.force


@formula
def speed_beyond_rest(s, b):
    """w^2 + U^2 beyond that of a disc that comes to rest."""
    return s.v2 + s.U2 - STILL**2 - (b.friction.patch * RESTS_BELOW) ** 2


RESTS = Event("rests", "the contact's disc neither slides nor turns", speed_beyond_rest, -1, "rests")
COMMON = (replace(gliding.LIFTOFF, formula=normal_force), legs.TOUCH, RESTS)


def borders(name: str) -> list[Event]:
    """Return the events in which a region ends."""
    return [
        Event(border.event, "sliding against turning", border.beyond, border.direction, border.event)
        for border in REGIONS[name].borders
    ]


def _kind(name: str) -> legs.Kind:
    contact = _contact(REGIONS[name].drag)
    return legs.Kind("slip", _form(name, contact), (*COMMON, *borders(name)), place, _says(contact), state)


DRILLING_KINDS = {f"drill-{name}": _kind(name) for name in REGIONS} | {"flight": legs.KINDS["flight"]}
FOLLOWS = {
    (f"drill-{name}", border.event): f"drill-{border.follows}"
    for name, region in REGIONS.items()
    for border in region.borders
}
"""The kind that follows a kind and the event that ended it."""


def stays_at_rest(u: Vector, L: Vector, velocity: Vector, b: Any) -> bool:
    """Whether friction can hold the disc of a body, once it is at rest."""
    L, _ = stopped(u, L, velocity, b)
    rolling = rolling_torque(1, angular_velocity(u, L, b), b.friction.mu_r, STOPS_ROLLING)
    return holds(holding(u, L, rolling, b), b.friction.mu, b.friction.patch)


def region(u: Vector, L: Vector, velocity: Vector, b: Any) -> str:
    """The region of a body's sliding, by the numbers of its state."""
    v, U2 = contact_velocity(u, L, velocity, b), patch_speed2(angular_velocity(u, L, b), b)
    x2 = (v.x * v.x + v.y * v.y) / U2
    return "inside" if x2 < EDGE**2 else "between" if x2 < OUTSIDE_FROM**2 else "outside"


def region_kind(u: Vector, L: Vector, velocity: Vector, b: Any) -> str:
    """The kind of sliding of a body, by the numbers of its state."""
    return f"drill-{region(u, L, velocity, b)}"


Angles: Any = namedtuple("Angles", (*row.Angles._fields, LOST[0]))  # type: ignore[misc]
"""As of any body whose contact has phases, and what its torque took of Jellett's integral."""

ANGLES = Angles._make((*row.ANGLES, JELLETT))


@formula
def angles_of_row(q, carried, b):
    """The angles of a row."""
    return Angles._make((*row.angles_of_row(q, carried, b), carried.jellett_lost))


DRILLING_ROW = replace(
    row.ROW,
    to_angles=angles_of_row,
    integrals=(*row.ROW.integrals, Integral(*LOST, formula(lambda q, carried, b: 0 * q.uz))),
)

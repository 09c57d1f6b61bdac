"""Sphere and stem on the plane at once: the axis keeps its angle, and each ball slides and carries its share.

The state is that of the sphere; two conditions, that theta and the height stay, give the two normal
forces, whatever each contact does per normal force. [contact 4.3]
"""

from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

from ...disc_friction import REGIONS
from ...events import Event
from ...form import Form, Integral
from ...friction import slip_coefficient
from ...operand import Operand, Vector, cross, dot, formula, plus, times
from ...units import ANGULAR_MOMENTUM, METRE_PER_SECOND, ONE
from ..body import angular_velocity, arm, arm_velocity, height
from ..integrals import integral
from ..orientation import carried_along
from . import legs, row
from .drilling import LOST, borders, patch_speed2, per_force, region


class State(NamedTuple):
    """3hat, L about the centre of mass, horizontal velocity of the centre of mass."""

    ux: Operand
    uy: Operand
    uz: Operand
    Lx: Operand
    Ly: Operand
    Lz: Operand
    rx_dot: Operand
    ry_dot: Operand


class Touching(NamedTuple):
    """What the plane does to one of the balls, per its normal force; and where it slides."""

    arm: Vector
    force: Vector
    torque: Vector
    velocity: Vector
    lean: Operand  # (L' x 3hat)_z that it gives
    N: Operand = 0  # normal force


class Scalars(NamedTuple):
    """What the events of standing on both read."""

    z: Operand  # cos(theta)
    force: Operand  # normal force of the sphere
    stem_force: Operand  # and of the stem
    v2: Operand  # |v|^2 of the sphere's lowest point
    stem_v2: Operand
    U2: Operand  # (patch Omega_z)^2


@formula
def stem(b):
    """The stem, of the body of the sphere."""
    return b._replace(R=b.R - b.clearance, c=b.c + b.lever, clearance=-b.clearance, lever=-b.lever)


def smooth(omega: Vector, v: Vector, z: Operand, b: Any) -> tuple[Vector, Vector]:
    """Of a law of the sliding velocity: minus the horizontal force, and the torque, per normal force."""
    none = 0 * z
    push = times(slip_coefficient(v.x * v.x + v.y * v.y, z, b.friction), v)
    return Vector(push.x, push.y, none), Vector(none, none, none)


def drills(drag: Callable) -> Callable:
    """The same of a patch that drills, in the region of this drag."""

    def law(omega: Vector, v: Vector, z: Operand, b: Any) -> tuple[Vector, Vector]:
        return per_force(drag(v.x * v.x + v.y * v.y, patch_speed2(omega, b)), omega, v, b)

    return law


@formula
def shares(one, two, total, swing):
    """N of sphere and stem, whose sum is `total` and whose (L' x 3hat)_z is `swing`; or the same of impulses."""
    N = (swing - total * one.lean) / (two.lean - one.lean)
    return total - N, N


def _sides(laws: tuple[Callable, Callable]) -> Callable:
    """sides(q, b) -> Touching of sphere and stem, whose N is not yet known, of their laws."""

    @formula
    def sides(q, b):
        u, L = row.axis(q), row.momentum(q)
        omega, touching = angular_velocity(u, L, b), []
        for law, body in zip(laws, (b, stem(b)), strict=True):
            turned, a = arm_velocity(u, L, body), arm(u, body)
            v = Vector(q.rx_dot + turned.x, q.ry_dot + turned.y, 0 * q.uz)
            push, torque = law(omega, v, q.uz, body)
            force = Vector(-push.x, -push.y, 1 + 0 * q.uz)
            turn = plus(cross(a, force), torque)
            touching.append(Touching(a, force, torque, v, turn.x * u.y - turn.y * u.x))
        return touching

    return sides


def _pair(sides: Callable) -> Callable:
    """pair(q, b) -> Touching of sphere and stem while theta and the height stay."""

    @formula
    def pair(q, b):
        one, two = sides(q, b)
        L, u_dot = row.momentum(q), row.axis_rate(q, b)
        N = shares(one, two, b.m * b.g, L.y * u_dot.x - L.x * u_dot.y)
        return one._replace(N=N[0]), two._replace(N=N[1])

    return pair


@formula
def force_of(side):
    """The force on a ball, (3,) [N]."""
    return times(side.N, side.force)


@formula
def power_of(side, omega):
    """What the contact of a ball takes [W]."""
    return -(side.N * (dot(side.force, side.velocity) + dot(side.torque, omega)))


@formula
def lost_of(one, two):
    """What the contacts take of the Jellett's integral of the sphere, with both forces N, or both impulses."""
    turn = plus(cross(two.arm, two.force), two.torque)
    return one.N * dot(one.torque, one.arm) + two.N * dot(turn, one.arm)


def _form(pair: Callable, balanced: bool) -> Form:
    """The equations; `balanced`: whether the loss of Jellett's integral is integrated."""

    @formula
    def scalars(q, b):
        one, two = pair(q, b)
        omega = angular_velocity(row.axis(q), row.momentum(q), b)
        U2 = patch_speed2(omega, b) if balanced else 0 * q.uz
        return Scalars(q.uz, one.N, two.N, dot(one.velocity, one.velocity), dot(two.velocity, two.velocity), U2)

    @formula
    def rates(q, b):
        turns, forces = [], []
        for side in pair(q, b):
            forces.append(force_of(side))
            turns.append(times(side.N, plus(cross(side.arm, side.force), side.torque)))
        F = plus(*forces)
        return State._make((*row.axis_rate(q, b), *plus(*turns), F.x / b.m, F.y / b.m))

    @formula
    def power(q, b):
        omega = angular_velocity(row.axis(q), row.momentum(q), b)
        one, two = pair(q, b)
        return power_of(one, omega) + power_of(two, omega)

    @formula
    def lost(q, b):
        one, two = pair(q, b)
        return lost_of(one, two)

    integrals = (
        integral("x", lambda q, carried, b: q.rx_dot),
        integral("y", lambda q, carried, b: q.ry_dot),
        integral("work", lambda q, carried, b: power(q, b)),
        integral("impulse", lambda q, carried, b: b.m * b.g + 0 * q.uz),
    )
    return Form(
        "vector",
        State(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 2),
        rates,
        scalars,
        of_angles=lambda e, s, z, b: None,  # it begins in the state that another phase leaves
        to_angles=lambda q, carried, b: None,
        integrals=(*integrals, Integral(*LOST, formula(lambda q, carried, b: lost(q, b)))) if balanced else integrals,
        orientation=carried_along(row.axis, row.axis_rate, row.spin),
    )


@formula
def place(q, b):
    """Where the body is."""
    return legs.Placed(row.axis(q), row.momentum(q), Vector(q.rx_dot, q.ry_dot, 0 * q.uz), height(q.uz, b))


def _says(pair: Callable) -> Callable:
    @formula
    def says(q, b):
        (one, two), omega = pair(q, b), angular_velocity(row.axis(q), row.momentum(q), b)
        F = plus(force_of(one), force_of(two))
        other = power_of(one, omega) + power_of(two, omega) + dot(F, one.velocity)
        return legs.Reached._make((*place(q, b), F, other))

    return says


def state(u: Vector, L: Vector, velocity: Vector, height: Any, b: Any) -> State:
    """The state of a body that stands on both."""
    return State(*u, *L, velocity.x, velocity.y)


@formula
def force(s, b):
    """Normal force of the sphere [N]."""
    return s.force


@formula
def stem_force(s, b):
    """Normal force of the stem [N]."""
    return s.stem_force


LEAVES = (
    Event("sphere-leaves", "the sphere leaves the plane, the stem stays", force, -1, "sphere-leaves"),
    Event("stem-leaves", "the stem leaves the plane, the sphere stays", stem_force, -1, "stem-leaves"),
)
STAYS = {"sphere-leaves": 1, "stem-leaves": 0}
"""The ball that stays on the plane, by the event that ends standing on both."""

STEMS: Any = namedtuple("STEMS", ("v2", "U2"))


def _of_stem(function: Callable) -> Callable:
    """A border between regions, of the stem's contact."""
    return formula(lambda s, b: function(STEMS(s.stem_v2, s.U2), b))


class BothKind(NamedTuple):
    """A kind of standing on both, and its contacts."""

    kind: legs.Kind
    sides: Callable  # sides(q, b) -> Touching of sphere and stem, without N


def _drilling(sphere: str, stem_: str) -> BothKind:
    sides = _sides((drills(REGIONS[sphere].drag), drills(REGIONS[stem_].drag)))
    pair = _pair(sides)
    of_stem = [
        Event(f"stem-{event.name}", event.long_name, _of_stem(event.formula), event.direction, f"stem-{event.ends}")
        for event in borders(stem_)
    ]
    events = (*LEAVES, *borders(sphere), *of_stem)
    kind = legs.Kind("both", _form(pair, True), events, place, _says(pair), state, axis_stays=True)
    return BothKind(kind, sides)


def _smooth() -> BothKind:
    sides = _sides((smooth, smooth))
    pair = _pair(sides)
    kind = legs.Kind(
        "both", _form(pair, False), LEAVES, place, _says(pair), state, axis_stays=True, keeps_jellett=False
    )
    return BothKind(kind, sides)


BOTH = {"both": _smooth()} | {f"both-{one}-{two}": _drilling(one, two) for one in REGIONS for two in REGIONS}
"""Every way to stand on both: under a smooth law, and by the regions of a patch that drills."""

BOTH_KINDS = {name: both.kind for name, both in BOTH.items()}

BOTH_FOLLOWS = {
    (f"both-{one}-{two}", border.event): f"both-{border.follows}-{two}"
    for two in REGIONS
    for one, its in REGIONS.items()
    for border in its.borders
} | {
    (f"both-{one}-{two}", f"stem-{border.event}"): f"both-{one}-{border.follows}"
    for one in REGIONS
    for two, its in REGIONS.items()
    for border in its.borders
}
"""The kind that follows a kind and the event that ended it."""


def both_kind(u: Vector, L: Vector, velocity: Vector, b: Any, drilling: bool) -> str:
    """The kind of standing on both, by the numbers of a state; b is the sphere."""
    return f"both-{region(u, L, velocity, b)}-{region(u, L, velocity, stem(b))}" if drilling else "both"

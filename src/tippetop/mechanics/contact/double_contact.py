"""The phases of a body on both of its balls: the axis keeps its angle, and each ball slides and
carries its share.

The state is that of the first ball, the sphere; two conditions, that theta and the height stay,
give the two normal forces, whatever each contact does per normal force. [contact 4.3]
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

from ..disc_friction import Region
from ..events import Event
from ..form import Phase
from ..friction import slip_coefficient
from ..operand import Operand, Vector, cross, dot, formula, plus, times
from ..units import ANGULAR_MOMENTUM, METRE_PER_SECOND, ONE
from .body import Touch, angular_velocity, arm, arm_velocity, height
from .gliding.vector import axis, axis_rate, momentum
from .single_contact import borders, disc_friction, force_of, patch_speed2, vector_form
from .state import Moving, Reaction, gained


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


class Side(NamedTuple):
    """What the plane does to one of the balls, per its normal force; and how it slides."""

    arm: Vector
    force: Vector
    torque: Vector
    velocity: Vector
    lean: Operand  # (L' x 3hat)_z that it gives
    N: Operand = 0  # normal force


class Scalars(NamedTuple):
    """The scalars of the events."""

    z: Operand  # cos(theta)
    force: Operand  # normal force of the sphere
    stem_force: Operand  # and of the stem
    v2: Operand  # |v|^2 of the sphere's lowest point
    stem_v2: Operand
    U2: Operand  # (patch Omega_z)^2


StemDisc: Any = namedtuple("StemDisc", ("v2", "U2"))


def smooth_friction(omega: Vector, v: Vector, z: Operand, b: Any) -> tuple[Vector, Vector]:
    """Return minus the horizontal force, and the torque, per normal force, of a law of the sliding
    velocity."""
    none = 0 * z
    push = times(slip_coefficient(v.x * v.x + v.y * v.y, z, b.friction), v)
    return Vector(push.x, push.y, none), Vector(none, none, none)


@formula
def other_ball(b):
    """The body seen from the stem, of the body seen from the sphere."""
    return b._replace(R=b.R - b.clearance, c=b.c + b.lever, clearance=-b.clearance, lever=-b.lever)


@formula
def turn_of(side):
    """Torque about the centre of mass of a side, per its normal force."""
    return plus(cross(side.arm, side.force), side.torque)


@formula
def loaded(sides, total, swing):
    """Sphere and stem with N, whose sum is `total` and whose (L' x 3hat)_z is `swing`; or the same
    of impulses."""
    one, two = sides
    N = (swing - total * one.lean) / (two.lean - one.lean)
    return one._replace(N=total - N), two._replace(N=N)


@formula
def force_on(sides):
    """The force on both balls, (3,) [N], or their impulse."""
    one, two = sides
    return plus(times(one.N, one.force), times(two.N, two.force))


@formula
def turn_on(sides):
    """The torque about the centre of mass of both, (3,) [N m], or that of their impulses."""
    one, two = sides
    return plus(times(one.N, turn_of(one)), times(two.N, turn_of(two)))


@formula
def jellett_lost(sides):
    """What the contacts take of the Jellett's integral of the sphere, with both forces N, or both
    impulses."""
    one, two = sides
    return one.N * dot(one.torque, one.arm) + two.N * dot(turn_of(two), one.arm)


def sides_of(*frictions: Callable) -> Callable:
    """Return sides(x, b) -> sphere and stem, whose N is not yet known, of what friction does to
    each."""

    @formula
    def sides(x, b):
        omega, found = angular_velocity(x.u, x.L, b), []
        for friction, ball in zip(frictions, (b, other_ball(b)), strict=True):
            turned, a = arm_velocity(x.u, x.L, ball), arm(x.u, ball)
            v = Vector(x.velocity.x + turned.x, x.velocity.y + turned.y, 0 * x.u.z)
            push, torque = friction(omega, v, x.u.z, ball)
            force = Vector(-push.x, -push.y, 1 + 0 * x.u.z)
            turn = plus(cross(a, force), torque)
            found.append(Side(a, force, torque, v, turn.x * x.u.y - turn.y * x.u.x))
        return found

    return sides


@formula
def leave(q, b):
    """The common state."""
    return Moving(axis(q), momentum(q), Vector(q.rx_dot, q.ry_dot, 0 * q.uz), height(q.uz, b))


@formula
def enter(x, b):
    """The state of a body on both."""
    return State._make((*x.u, *x.L, x.velocity.x, x.velocity.y))


LEAVES = (
    Event(
        "sphere-leaves",
        "the sphere leaves the plane, the stem stays",
        force_of,
        -1,
        "sphere-leaves",
    ),
    Event(
        "stem-leaves",
        "the stem leaves the plane, the sphere stays",
        formula(lambda s, b: s.stem_force),
        -1,
        "stem-leaves",
    ),
)


def _of_stem(event: Event) -> Event:
    """Return an end of a region, of the stem's contact."""
    name = f"stem-{event.name}"
    function = formula(lambda s, b: event.formula(StemDisc(s.stem_v2, s.U2), b))
    return Event(name, event.long_name, function, event.direction, name)


class Double(NamedTuple):
    """A phase on both balls, and its contacts."""

    phase: Phase
    sides: Callable  # sides(x, b) -> sphere and stem, without N


@lru_cache
def double_contact(regions: tuple[Region, ...] = (), torque: Any = None) -> Double:
    """Return the phase on both balls: of sphere and stem in two regions of a law with this torque,
    or, without, under a law that is smooth in the velocity."""
    if regions:
        sides = sides_of(*(disc_friction(region.drag, torque) for region in regions))
        events = (*LEAVES, *borders(regions[0]), *map(_of_stem, borders(regions[1])))
    else:
        sides, events = sides_of(smooth_friction, smooth_friction), LEAVES

    @formula
    def pair(q, b):
        L, u_dot = momentum(q), axis_rate(q, b)
        return loaded(sides(leave(q, b), b), b.m * b.g, L.y * u_dot.x - L.x * u_dot.y)

    @formula
    def scalars(q, b):
        one, two = pair(q, b)
        v2, stem_v2 = dot(one.velocity, one.velocity), dot(two.velocity, two.velocity)
        U2 = patch_speed2(angular_velocity(axis(q), momentum(q), b), b) if regions else 0 * q.uz
        return Scalars(q.uz, one.N, two.N, v2, stem_v2, U2)

    @formula
    def rates(q, b):
        both = pair(q, b)
        F = force_on(both)
        return State._make((*axis_rate(q, b), *turn_on(both), F.x / b.m, F.y / b.m))

    @formula
    def power(q, b):
        omega = angular_velocity(axis(q), momentum(q), b)
        one, two = (-(s.N * (dot(s.force, s.velocity) + dot(s.torque, omega))) for s in pair(q, b))
        return one + two

    @formula
    def reaction(q, b):
        both = pair(q, b)
        F = force_on(both)
        return Reaction(F, power(q, b) + dot(F, both[0].velocity))

    form = vector_form(
        State(*(ONE,) * 3, *(ANGULAR_MOMENTUM,) * 3, *(METRE_PER_SECOND,) * 2),
        rates,
        scalars,
        {
            "x": lambda q, carried, b: q.rx_dot,
            "y": lambda q, carried, b: q.ry_dot,
            "work": lambda q, carried, b: power(q, b),
            "impulse": lambda q, carried, b: b.m * b.g + 0 * q.uz,
        },
        lost=(lambda q, carried, b: jellett_lost(pair(q, b))) if regions else None,
    )
    phase = Phase({"vector": form}, (), events, (), enter, leave, reaction, label="both")
    return Double(replace(phase, axis_stays=True), sides)


def brought_to_rest(x: Moving, regions: tuple, torque: Any, b: Touch) -> Moving:
    """Return the body without theta' and vertical velocity, which impulses at both balls take, as
    the endless hops from one to the other would."""
    both = loaded(
        double_contact(regions, torque).sides(x, b),
        -(b.m * x.velocity.z),
        x.L.y * x.u.x - x.L.x * x.u.y,
    )
    p, turn = force_on(both), turn_on(both)
    L, velocity = plus(x.L, turn), plus(x.velocity, times(1 / b.m, p))
    mean = times(0.5, plus(angular_velocity(x.u, x.L, b), angular_velocity(x.u, L, b)))
    work = -(dot(p, times(0.5, plus(x.velocity, velocity))) + dot(turn, mean))
    x = gained(x._replace(L=L, velocity=velocity._replace(z=0 * p.z)), work=work, impulse=p.z)
    return gained(x, jellett_lost=jellett_lost(both)) if regions else x

"""The phases of a body on both of its balls: the axis keeps its angle, and each ball slides and
carries its share.

The state is that of the first ball, the sphere; two conditions, that theta and the height stay,
give the two normal forces, whatever each contact does per normal force. [contact 4.3]
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

from ..disc_friction import STOPS_ROLLING, Region, rolling
from ..form import Phase
from ..operand import Operand, Vector, cross, dot, plus, times
from ..units import METRE_PER_SECOND
from .body import (
    Touch,
    angular_velocity,
    arm,
    arm_velocity,
    centre_velocity,
    height,
    seen_from_other,
    state,
)
from .gliding.gliding_vector import axis, axis_rate, momentum
from .single_contact import (
    beyond_rest,
    borders,
    disc_friction,
    ending,
    force_of,
    phase_of,
    smooth_friction,
)
from .state import Moving, Reaction, gained


STATE = state(rx_dot=METRE_PER_SECOND, ry_dot=METRE_PER_SECOND)
"""Horizontal velocity of the centre of mass."""

Scalars: Any = namedtuple("Scalars", "z force stem_force by stem")
"""Normal forces of sphere and stem, and the actions of the plane on each."""


class Side(NamedTuple):
    """Action of the plane on one of the balls, per normal force; and its sliding velocity."""

    arm: Vector
    force: Vector
    torque: Vector
    velocity: Vector
    omega: Vector
    turn: Vector  # torque of both about the centre of mass
    lean: Operand  # (L' x 3hat)_z that it gives
    N: Operand = 0  # normal force


def loaded(sides, total, swing):
    """Return sphere and stem with N, the sum of which is `total`.

    Their (L' x 3hat)_z is `swing`; or the same of impulses.
    """
    one, two = sides
    N = (swing - total * one.lean) / (two.lean - one.lean)
    return one._replace(N=total - N), two._replace(N=N)


def sum_of(sides, name):
    """Return the sum of forces, or of turns, on both balls, (3,)."""
    return plus(*(times(side.N, getattr(side, name)) for side in sides))


def jellett_lost(sides):
    """Return the part of the sphere's Jellett's integral that the contacts take.

    Both sides have their forces N, or their impulses.
    """
    one, two = sides
    return one.N * dot(one.torque, one.arm) + two.N * dot(two.turn, one.arm)


def enter(x, b):
    """Return the state."""
    return type(STATE)(*x.u, *x.L, *x.velocity[:2])


def leave(q, b):
    """Return the common state."""
    velocity = Vector(q.rx_dot, q.ry_dot, 0 * q.uz)
    return Moving(axis(q), momentum(q), velocity, height(q.uz, b))


LEAVES = (
    ending("sphere-leaves", "the sphere leaves the plane, the stem stays", force_of),
    ending("stem-leaves", "the stem leaves the plane, the sphere stays", lambda s, b: s.stem_force),
)


STANDS = ending(
    "stands",
    "the discs of both contacts neither slide nor turn",
    lambda s, b: beyond_rest(s.by, b) + beyond_rest(s.stem, b),
)


class Double(NamedTuple):
    """A phase on both balls, and its contacts."""

    phase: Phase
    sides: Callable  # sides(x, b) -> sphere and stem, without N


@lru_cache
def double_contact(regions: tuple[Region, ...] = (), torque: Any = None) -> Double:
    """Return the phase on both balls.

    Sphere and stem slide in two regions of a law with this torque; without regions, under a law
    that is smooth in the velocity.
    """

    frictions = [disc_friction(region.drag, torque) for region in regions] or [smooth_friction] * 2

    def sides(x, b):
        omega, none, sides = angular_velocity(x.u, x.L, b), 0 * x.u.z, []
        for friction, ball in zip(frictions, (b, seen_from_other(b)), strict=True):
            turned, a = arm_velocity(x.u, x.L, ball), arm(x.u, ball)
            v = Vector(x.velocity.x + turned.x, x.velocity.y + turned.y, none)
            push, twist = friction(omega, v, x.u.z, ball)
            force = Vector(-push.x, -push.y, 1 + none)
            turn = plus(cross(a, force), twist)
            sides.append(Side(a, force, twist, v, omega, turn, turn.x * x.u.y - turn.y * x.u.x))
        return sides

    def pair(q, b):
        L, u_dot = momentum(q), axis_rate(q, b)
        return loaded(sides(leave(q, b), b), b.m * b.g, L.y * u_dot.x - L.x * u_dot.y)

    def scalars(q, b):
        one, two = pair(q, b)
        return Scalars(q.uz, one.N, two.N, one, two)

    def rates(q, b):
        both = pair(q, b)
        F = sum_of(both, "force")
        return type(STATE)(*axis_rate(q, b), *sum_of(both, "turn"), F.x / b.m, F.y / b.m)

    def power(q, b):
        one, two = (
            -(s.N * (dot(s.force, s.velocity) + dot(s.torque, s.omega))) for s in pair(q, b)
        )
        return one + two

    def reaction(q, b):
        both = pair(q, b)
        F = sum_of(both, "force")
        return Reaction(F, power(q, b) + dot(F, both[0].velocity))

    ends: tuple = ()
    if regions:
        ends = (STANDS, *borders(regions[0]), *borders(regions[1], "stem", "stem-"))
    phase = phase_of(
        STATE,
        (*LEAVES, *ends),
        (rates, scalars, enter, leave, reaction),
        work=power,
        impulse=lambda q, b: b.m * b.g + 0 * q.uz,
        jellett_lost=lambda q, b: jellett_lost(pair(q, b)),
    )
    return Double(replace(phase, axis_stays=True), sides)


# --- rolling on both, as a cone does ------------------------------------------------------------


def rolled(q, b):
    """Return L', the acceleration of the centre of mass, and the power of rolling resistance.

    The body turns about the line through both contacts, and that line about the vertical.
    """
    x, u_dot = leave(q, b), axis_rate(q, b)
    turn = (x.u.x * u_dot.y - x.u.y * u_dot.x) / (x.u.x**2 + x.u.y**2)
    omega = angular_velocity(x.u, x.L, b)
    moves = dot(omega, x.L) + b.m * dot(x.velocity, x.velocity)  # twice the energy
    resists = b.m * b.g * dot(rolling(omega, b.friction), omega)
    slows = resists / (moves + b.I1 * STOPS_ROLLING**2)

    def rate(v):
        return Vector(slows * v.x - turn * v.y, slows * v.y + turn * v.x, slows * v.z)

    return rate(x.L), rate(x.velocity), slows * moves


def rolling_sides(q, b):
    """Return sphere and stem with N, of a body that rolls on both."""
    x, (L_dot, V_dot, _) = leave(q, b), rolled(q, b)
    omega, none = angular_velocity(x.u, x.L, b), 0 * q.uz
    up, still = Vector(none, none, 1 + none), Vector(none, none, none)
    rolls = rolling(omega, b.friction)

    def side(ball):
        a = arm(x.u, ball)
        turn = cross(a, up)
        return Side(a, up, rolls, still, omega, turn, cross(turn, x.u).z)

    swing = cross(L_dot, x.u).z - b.m * (height(q.uz, b) * dot(V_dot, x.u))
    swing = swing - b.m * b.g * cross(rolls, x.u).z
    return loaded([side(b), side(seen_from_other(b))], b.m * b.g, swing)


def rolling_scalars(q, b):
    """Return the scalars of a body that rolls on both."""
    one, two = rolling_sides(q, b)
    return Scalars(q.uz, one.N, two.N, one, two)


def rolling_rates(q, b):
    """Return the rates of a body that rolls on both."""
    L_dot, V_dot, _ = rolled(q, b)
    return type(STATE)(*axis_rate(q, b), *L_dot, *V_dot[:2])


def rolling_reaction(q, b):
    """Return the sum of both forces, and the power that the torques take."""
    _, V_dot, gains = rolled(q, b)
    return Reaction(Vector(b.m * V_dot.x, b.m * V_dot.y, b.m * b.g + 0 * q.uz), -gains)


ROLLS_ON_BOTH = phase_of(
    STATE,
    LEAVES,
    (rolling_rates, rolling_scalars, enter, leave, rolling_reaction),
    work=lambda q, b: -rolled(q, b)[2],
    impulse=lambda q, b: b.m * b.g + 0 * q.uz,
    jellett_lost=lambda q, b: dot(rolled(q, b)[0], arm(axis(q), b)),
)
ROLLS_ON_BOTH = replace(ROLLS_ON_BOTH, axis_stays=True)


def on_both(law: Any) -> dict[tuple[str, ...], Phase]:
    """Return the phases on both balls under a law, by the regions of the law on each."""
    if law.set_valued:
        return {}
    if not law.regions:
        return {(): double_contact((), law.torque).phase}
    phases: dict[tuple[str, ...], Phase] = {("roll",): ROLLS_ON_BOTH}
    for names in product(law.regions, repeat=2):
        regions = tuple(law.regions[name] for name in names)
        phases[names] = double_contact(regions, law.torque).phase
    return phases


def without_slip_on_both(x: Moving, b: Touch) -> Moving:
    """Return the body without the rest of its sliding and turning on both balls."""
    omega = angular_velocity(x.u, x.L, b)
    spin = (omega.x * x.u.x + omega.y * x.u.y) / (x.u.x**2 + x.u.y**2)
    omega = Vector(spin * x.u.x, spin * x.u.y, 0 * spin)
    L = plus(times(b.I1, omega), times((b.I3 - b.I1) * dot(omega, x.u), x.u))
    none = 0 * spin
    after = x._replace(L=L, velocity=centre_velocity(x.u, L, Vector(none, none, none), b))
    lost = plus(L, times(-1, x.L))
    work = kinetic_energy(x, b) - kinetic_energy(after, b)
    return gained(after, work=work, jellett_lost=dot(lost, arm(x.u, b)))


def kinetic_energy(x, b):
    """Return the kinetic energy of a common state."""
    turns = dot(angular_velocity(x.u, x.L, b), x.L)
    return (b.m * dot(x.velocity, x.velocity) + turns) / 2


def brought_to_rest(x: Moving, sides: Callable, b: Touch, drills: bool) -> Moving:
    """Return the body without theta' and vertical velocity, which impulses at both balls take.

    The endless hops from one to the other would do so.
    """
    both = loaded(sides(x, b), -(b.m * x.velocity.z), x.L.y * x.u.x - x.L.x * x.u.y)
    p, turn = sum_of(both, "force"), sum_of(both, "turn")
    L, velocity = plus(x.L, turn), plus(x.velocity, times(1 / b.m, p))
    mean = times(0.5, plus(angular_velocity(x.u, x.L, b), angular_velocity(x.u, L, b)))
    work = b.m * b.g * (x.height - height(x.u.z, b))  # of the rest of its fall
    work = work - (dot(p, times(0.5, plus(x.velocity, velocity))) + dot(turn, mean))
    x = gained(x._replace(L=L, velocity=velocity._replace(z=0 * p.z)), work=work, impulse=p.z)
    return gained(x, jellett_lost=jellett_lost(both)) if drills else x

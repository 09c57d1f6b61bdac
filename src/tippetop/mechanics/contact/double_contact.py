"""The phases of a body on both of its balls: the axis keeps its angle, and each ball slides, or
both roll, and carries its share.

The state is that of the first ball, the sphere; two conditions, that theta and the height stay,
give the two normal forces, whatever each contact does per normal force. [contact 4.3]
"""

from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

from ..disc_friction import STOPS_ROLLING, rolling
from ..event import Event
from ..form import Phase
from ..operand import Operand, Vector, cross, dot, plus, times
from ..units import METRE_PER_SECOND
from .body import (
    Moving,
    Reaction,
    Touch,
    angular_velocity,
    arm,
    axis_rate,
    centre_velocity,
    contact_velocity,
    gained,
    height,
    seen_from_other,
    state,
)
from .gliding.gliding_vector import axis, momentum
from .single_contact import (
    beyond_rest,
    borders,
    disc_friction,
    ending,
    force_of,
    phase_of,
    smooth_friction,
)


STATE = state(rx_dot=METRE_PER_SECOND, ry_dot=METRE_PER_SECOND)
"""Horizontal velocity of the centre of mass."""

Scalars: Any = namedtuple("Scalars", "z force stem_force by stem")
"""Normal forces of sphere and stem, and the actions of the plane on each."""


class Side(NamedTuple):
    """Action of the plane on one of the balls, per normal force; and its sliding velocity."""

    force: Vector
    torque: Vector
    velocity: Vector
    omega: Vector
    turn: Vector  # torque of both about the centre of mass
    N: Operand = 0  # normal force


def sides(x: Moving, frictions: Sequence[Callable], b: Touch) -> list[Side]:
    """Return sphere and stem, without N, under friction(omega, v, z, b) of each."""
    omega, none, both = angular_velocity(x.u, x.L, b), 0 * x.u.z, []
    for friction, ball in zip(frictions, (b, seen_from_other(b)), strict=True):
        v = contact_velocity(x.u, x.L, x.velocity, ball)._replace(z=none)
        push, twist = friction(omega, v, x.u.z, ball)
        force = Vector(-push.x, -push.y, 1 + none)
        turn = plus(cross(arm(x.u, ball), force), twist)
        both.append(Side(force, twist, v, omega, turn))
    return both


def loaded(sides, total, swing, u):
    """Return sphere and stem with N, the sum of which is `total`.

    Their (L' x 3hat)_z is `swing`; or the same of impulses.
    """
    one, two = sides
    lean, other = (cross(side.turn, u).z for side in sides)
    N = (swing - total * lean) / (other - lean)
    return one._replace(N=total - N), two._replace(N=N)


def sum_of(sides, name):
    """Return the sum of forces, or of turns, on both balls, (3,)."""
    return plus(*(times(side.N, getattr(side, name)) for side in sides))


def enter(x, b):
    """Return the state."""
    return type(STATE)(*x.u, *x.L, *x.velocity[:2])


def leave(q, b):
    """Return the common state."""
    velocity = Vector(q.rx_dot, q.ry_dot, 0 * q.uz)
    return Moving(axis(q), momentum(q), velocity, height(q.uz, b))


def two_contacts(acts: Callable, *ends: Any) -> Phase:
    """Return a phase on both balls: acts(x, b) -> its sides with N, L' and the force."""

    def scalars(q, b):
        (one, two), _, _ = acts(leave(q, b), b)
        return Scalars(q.uz, one.N, two.N, one, two)

    def rates(q, b):
        x = leave(q, b)
        _, L_dot, F = acts(x, b)
        return type(STATE)(*axis_rate(x.u, x.L, b), *L_dot, F.x / b.m, F.y / b.m)

    def power(q, b):
        both, _, _ = acts(leave(q, b), b)
        one, two = (-(s.N * (dot(s.force, s.velocity) + dot(s.torque, s.omega))) for s in both)
        return one + two

    def reaction(q, b):
        both, _, F = acts(leave(q, b), b)
        return Reaction(F, power(q, b) + dot(F, both[0].velocity))

    leaves = (
        ending("sphere-leaves", "the sphere leaves the plane, the stem stays", force_of),
        ending(
            "stem-leaves", "the stem leaves the plane, the sphere stays", lambda s, b: s.stem_force
        ),
    )
    phase = phase_of(
        STATE,
        (*leaves, *ends),
        (rates, scalars, enter, leave, reaction),
        work=power,
        impulse=lambda q, b: b.m * b.g + 0 * q.uz,
        jellett_lost=lambda q, b: dot(Vector(*rates(q, b)[3:6]), arm(axis(q), b)),
    )
    return replace(phase, axis_stays=True)


# --- sliding ------------------------------------------------------------------------------------


STANDS = ending(
    "stands",
    "the discs of both contacts neither slide nor turn",
    lambda s, b: beyond_rest(s.by, b) + beyond_rest(s.stem, b),
)


def frictions_of(law: Any, names: Sequence[str]) -> list[Callable]:
    """Return friction(omega, v, z, b) of sphere and stem, in these regions of a law if it has any.

    Without regions the law is smooth in the velocity.
    """
    by_region = [disc_friction(law.regions[name].drag, law.torque) for name in names]
    return by_region or [smooth_friction] * 2


def slide_on_both(law: Any, *names: str) -> Phase:
    """Return the phase in which sphere and stem slide, in these regions of a law."""
    frictions = frictions_of(law, names)

    def acts(x, b):
        swing = -cross(x.L, axis_rate(x.u, x.L, b)).z  # z'' is zero
        both = loaded(sides(x, frictions, b), b.m * b.g, swing, x.u)
        return both, sum_of(both, "turn"), sum_of(both, "force")

    ends: list[Event] = [STANDS] if names else []
    for name, of_ball in zip(names, (("by", ""), ("stem", "stem-")), strict=False):
        ends += borders(law.regions[name], *of_ball)
    return two_contacts(acts, *ends)


# --- rolling on both, as a cone does ------------------------------------------------------------


def rolled(x, b):
    """Return sphere and stem with N, L' and the force on a body that rolls on both.

    The body turns about the line through both contacts, and that line about the vertical. It does
    not matter here how the two share the horizontal force.
    """
    u_dot, omega = axis_rate(x.u, x.L, b), angular_velocity(x.u, x.L, b)
    turn = (x.u.x * u_dot.y - x.u.y * u_dot.x) / (x.u.x**2 + x.u.y**2)
    moves = dot(omega, x.L) + b.m * dot(x.velocity, x.velocity)  # twice the energy
    share = 1 / (moves + b.I1 * STOPS_ROLLING**2)
    rolls = rolling(omega, b.friction)
    slows = b.m * b.g * dot(rolls, omega) * share

    def rate(v):
        return Vector(slows * v.x - turn * v.y, slows * v.y + turn * v.x, slows * v.z)

    L_dot, V_dot = rate(x.L), rate(x.velocity)
    acts = times(-1 / b.g, V_dot), times(moves * share, rolls)
    both = sides(x, [lambda *of: acts] * 2, b)
    both = loaded(both, b.m * b.g, cross(L_dot, x.u).z, x.u)
    return both, L_dot, times(b.m, V_dot)._replace(z=b.m * b.g + 0 * slows)


ROLLS_ON_BOTH = two_contacts(rolled)


def on_both(law: Any) -> dict[tuple[str, ...], Phase]:
    """Return the phases on both balls under a law, by the regions of the law on each."""
    if law.set_valued:
        return {}
    if not law.regions:
        return {(): slide_on_both(law)}
    slides = {names: slide_on_both(law, *names) for names in product(law.regions, repeat=2)}
    return {("roll",): ROLLS_ON_BOTH, **slides}


# --- what brings a body onto both ---------------------------------------------------------------


def without_slip_on_both(x: Moving, b: Touch) -> Moving:
    """Return the body without the rest of its sliding and turning on both balls."""
    omega, none = angular_velocity(x.u, x.L, b), 0 * x.u.z
    spin = (omega.x * x.u.x + omega.y * x.u.y) / (x.u.x**2 + x.u.y**2)
    omega = Vector(spin * x.u.x, spin * x.u.y, none)
    L = plus(times(b.I1, omega), times((b.I3 - b.I1) * dot(omega, x.u), x.u))
    return slowed(x, L, centre_velocity(x.u, L, Vector(none, none, none), b), b)


def brought_to_rest(x: Moving, frictions: Sequence[Callable], b: Touch) -> Moving:
    """Return the body without theta' and vertical velocity, which impulses at both balls take.

    The endless hops from one to the other would do so.
    """
    both = loaded(sides(x, frictions, b), -(b.m * x.velocity.z), -cross(x.L, x.u).z, x.u)
    p, L = sum_of(both, "force"), plus(x.L, sum_of(both, "turn"))
    velocity = plus(x.velocity, times(1 / b.m, p))._replace(z=0 * p.z)
    return gained(slowed(x, L, velocity, b), impulse=p.z)


def slowed(x: Moving, L: Vector, velocity: Vector, b: Touch) -> Moving:
    """Return the body on the plane with less momentum: its contacts take the energy it loses."""
    after = x._replace(L=L, velocity=velocity, height=height(x.u.z, b))
    lost = dot(plus(L, times(-1, x.L)), arm(x.u, b))
    return gained(after, work=energy(x, b) - energy(after, b), jellett_lost=lost)


def energy(x, b):
    """Return the energy of a common state."""
    turns = dot(angular_velocity(x.u, x.L, b), x.L)
    return (b.m * dot(x.velocity, x.velocity) + turns) / 2 + b.m * b.g * x.height

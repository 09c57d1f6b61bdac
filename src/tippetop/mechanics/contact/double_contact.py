"""The phases of a body on both of its balls: the axis keeps its angle, and each ball slides, or
both roll, and carries its share.

The motion is that of a body on its first ball, the sphere, which feels the force of both and the
torque of the other about the sphere's contact point; two conditions, that theta and the height
stay, give the two normal forces, whatever each contact does per normal force. [contact 4.3]
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from ..disc_friction import STOPS_ROLLING, rolling
from ..event import Event
from ..form import Phase
from ..operand import Vector, cross, dot, plus, times
from .body import (
    Moving,
    Touch,
    Turning,
    angular_velocity,
    arm,
    axis_rate,
    centre_velocity,
    contact_velocity,
    gained,
    height,
    seen_from_other,
)
from .response import kicked
from .single_contact import (
    Acts,
    beyond_rest,
    borders,
    disc_friction,
    ending,
    smooth_friction,
    with_slip,
    without_slip,
)


def shared(x, v, frictions, total, swing, b):
    """Return the force of both balls, the torque with which it acts at the contact of the sphere,
    and the actions on sphere and stem under friction(omega, v, z, b) of each.

    The sum of the normal forces is `total`, and (L' x 3hat)_z is `swing`; or the same of impulses.
    v is the velocity of the sphere's contact point.
    """
    u, omega, other, sides = x.u, angular_velocity(x, b), seen_from_other(b), []
    apart = plus(arm(u, other), times(-1, arm(u, b)))
    slips = v, plus(v, cross(omega, apart))
    for friction, slip, ball in zip(frictions, slips, (b, other), strict=True):
        push, torque = friction(omega, slip, u.z, ball)
        force = Vector(-push.x, -push.y, 1 + 0 * u.z)
        lean = cross(plus(cross(arm(u, ball), force), torque), u).z
        sides.append((Acts(force, torque, slip, omega), lean))
    (_, lean), (_, other_lean) = sides
    N = (swing - total * lean) / (other_lean - lean)
    one, two = (
        by._replace(force=times(load, by.force), torque=times(load, by.torque))
        for load, (by, _) in zip((total - N, N), sides, strict=True)
    )
    torque = plus(plus(one.torque, two.torque), cross(apart, two.force))
    return plus(one.force, two.force), torque, one, two


def leaving(side: int, name: str, other: str) -> Event:
    """Return the event in which one of the balls leaves the plane."""
    text = f"the {name} leaves the plane, the {other} stays"
    return ending(f"{name}-leaves", text, lambda s, b: s.sides[side].force.z)


LEAVES = leaving(0, "sphere", "stem"), leaving(1, "stem", "sphere")


# --- sliding ------------------------------------------------------------------------------------


STANDS = ending("stands", "the discs of both contacts neither slide nor turn", beyond_rest)


def frictions_of(law: Any, names: Sequence[str]) -> list[Callable]:
    """Return friction(omega, v, z, b) of sphere and stem, in these regions of a law if it has any.

    Without regions the law is smooth in the velocity.
    """
    by_region = [disc_friction(law.regions[name].drag, law.torque) for name in names]
    return by_region or [smooth_friction] * 2


def slide_on_both(law: Any, *names: str) -> Phase:
    """Return the phase in which sphere and stem slide, in these regions of a law."""
    frictions = frictions_of(law, names)

    def pushed(x, v, b):
        swing = -cross(x.L, axis_rate(x, b)).z  # z'' is zero
        return shared(x, v, frictions, b.m * b.g, swing, b)

    ends = [*LEAVES, STANDS] if names else [*LEAVES]
    for side, name in enumerate(names):
        ends += borders(law.regions[name], side, "stem-" * side)
    return replace(with_slip(tuple(ends), pushed), axis_stays=True)


# --- rolling on both, as a cone does ------------------------------------------------------------


def rolled(x, b):
    """Return force and torque on a body that rolls on both, and the actions on each.

    The body turns about the line through both contacts, and that line about the vertical. It does
    not matter here how the two share the horizontal force.
    """
    u, u_dot, omega, still = x.u, axis_rate(x, b), angular_velocity(x, b), times(0, x.u)
    velocity = centre_velocity(x, still, b)
    turn = (u.x * u_dot.y - u.y * u_dot.x) / (u.x**2 + u.y**2)
    moves = dot(omega, x.L) + b.m * dot(velocity, velocity)  # twice the energy
    share = 1 / (moves + b.I1 * STOPS_ROLLING**2)
    rolls = rolling(omega, b.friction)
    slows = b.m * b.g * dot(rolls, omega) * share

    def rate(a):
        return Vector(slows * a.x - turn * a.y, slows * a.y + turn * a.x, slows * a.z)

    L_dot, V_dot = rate(x.L), rate(velocity)
    acts = times(-1 / b.g, V_dot), times(moves * share, rolls)
    frictions, swing = [lambda *of: acts] * 2, cross(L_dot, u).z
    _, _, *sides = shared(x, still, frictions, b.m * b.g, swing, b)
    force = times(b.m, V_dot)._replace(z=b.m * b.g + 0 * slows)
    return force, plus(L_dot, times(-1, cross(arm(u, b), force))), *sides


ROLLS_ON_BOTH = replace(without_slip(LEAVES, rolled), axis_stays=True)


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
    omega, none = angular_velocity(x, b), 0 * x.u.z
    spin = (omega.x * x.u.x + omega.y * x.u.y) / (x.u.x**2 + x.u.y**2)
    omega = Vector(spin * x.u.x, spin * x.u.y, none)
    L = plus(times(b.I1, omega), times((b.I3 - b.I1) * dot(omega, x.u), x.u))
    velocity = centre_velocity(Turning(x.u, L), times(0, L), b)
    p = times(b.m, plus(velocity, times(-1, x.velocity)))
    turn = plus(L, times(-1, plus(x.L, cross(arm(x.u, b), p))))
    return kicked(x, b, p, turn)


def brought_to_rest(x: Moving, frictions: Sequence[Callable], b: Touch) -> Moving:
    """Return the body on both balls without theta' and vertical velocity, which impulses take.

    The endless hops from one to the other would do so.
    """
    v, sinks = contact_velocity(x, b), -(b.m * x.velocity.z)
    p, twist, *_ = shared(x, v, frictions, sinks, -cross(x.L, x.u).z, b)
    after, lies = kicked(x, b, p, twist), height(x.u.z, b)
    after = after._replace(velocity=after.velocity._replace(z=0 * sinks), height=lies)
    return gained(after, work=b.m * b.g * (x.height - lies))

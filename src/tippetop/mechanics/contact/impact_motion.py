"""An impact as a motion: the forces and torques of sliding, rolling or resting, per normal impulse.

dv_A = (K F + (I^-1 T) x a) dp and dL = (a x F + T) dp; F and T are those of the same law in the
phases of contact, per normal force, and the axis stays. The clock is v_n, which rises; under a
set-valued law that slides it is sigma, dp = |v_A| dsigma, and the slip is its direction and the
logarithm of its speed, in which nothing is singular where sliding stops. The units of slip and of
v_n are powers of two near them, so that steps are as exact for slow impacts as for fast ones.
[contact 3.2, 3.3]
"""

from collections import namedtuple
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

from ..disc_friction import Drag
from ..event import Event
from ..form import Form
from ..operand import Vector, cross, dot, exp, log, plus, sqrt, times
from ..units import ONE
from .body import Turning, angular_velocity, arm
from .contact_phases import Acts, Speeds, disc_friction, region_of, smooth_friction
from .response import (
    across_and_along,
    direction,
    held_disc,
    held_point,
    impulses,
    margin,
    mobility_inverse_times,
    mobility_times,
)


CLOCK_RATE = 2.0**10
"""Of the time of a motion, relative to v_n: a step that leads nowhere takes 1e-10 of this time."""

RESTS_AT, STOPS_AT = 450, 1e-3
"""Slip at which a disc neither slides nor turns, and at which a point stops, in rounding errors."""

BEGINS_AT, DISC_BEGINS_AT = 1e-10, 2e-8
"""Slip with which sliding of a point and of a disc begins within an impact with torques: the error
of the motion after it. A smaller one takes more steps where torques turn the force that holds the
contact.
"""

Blow: Any = namedtuple("Blow", "by_v_n by_work_n by_p_n goal speed ratio rest begins u L touch")
"""The parameters of an impact.

A stage ends where by_v_n v_n + by_work_n work_n + by_p_n p_n = goal. Then the unit of slip; the
unit of v_n by it; the slip of a contact at rest, and that with which it begins to slide; 3hat; L
before the impact; the body.
"""

Motion: Any = namedtuple("Motion", "v_x v_y turn v_n p_x p_y p_n t_x t_y t_n work_n work_t")
"""Slip, and that of the edge of a disc; v_n; impulses of the force and of the torque; works of the
normal force and of friction.

Of a point that slides under a set-valued law, equations have the direction of the slip and, as
`turn`, the logarithm of its speed.
"""


REACHED = Event(
    "reached",
    "the stage ends",
    lambda q, by, b: b.by_v_n * q.v_n + b.by_work_n * q.work_n + b.by_p_n * q.p_n - b.goal,
    1,
    "reached",
)
STOPS = Event(
    "stops",
    "the contact neither slides nor turns",
    lambda q, by, b: sum(speeds(q)) - b.rest**2,
    -1,
    "stops",
)


def growth(q: Any, by: Acts, b: Any) -> Any:
    """Return half the rate of the squares of the slip of a disc and of its edge."""
    across = gains(by, b)
    return q.v_x * across.x + q.v_y * across.y + q.turn * spun(by, b)


SLOWEST = Event("slowest", "slip begins to grow", growth, 1, "slowest")
REST = "rest"
FLAT_BIAS = Vector(0.0, 0.0, -1.0)
"""Minus the acceleration of the contact point: v_n rises by one."""


class Stage(NamedTuple):
    """The motion in a region of a law, or at rest."""

    form: Form
    acts: Callable  # acts(q, b) -> Acts, per normal impulse
    events: tuple[Event, ...]  # formula(q, acts, b)
    follows: dict[str, Any]  # the border that is reached, by its event
    is_directed: bool  # equations have the direction of the slip


def speeds(q: Any) -> Speeds:
    """Return the squares of sliding and turning."""
    return Speeds(q.v_x * q.v_x + q.v_y * q.v_y, q.turn * q.turn)


def directed(q: Any) -> Any:
    """Return a motion by the direction and the logarithm of its slip."""
    w = sqrt(speeds(q).v2)
    return q._replace(v_x=q.v_x / w, v_y=q.v_y / w, turn=log(w))


def undirected(q: Any) -> Any:
    """Return a motion by its slip."""
    w = exp(q.turn)
    return q._replace(v_x=w * q.v_x, v_y=w * q.v_y, turn=0 * w)


def gains(by: Acts, b: Any) -> Vector:
    """Return dv_A/dp."""
    return mobility_times(b.u, by.force, by.torque, b.touch)


def spun(by: Acts, b: Any) -> Any:
    """Return the rate of the velocity of a disc's edge by the normal impulse."""
    turned = plus(cross(arm(b.u, b.touch), by.force), by.torque)
    return b.touch.friction.patch * angular_velocity(Turning(b.u, turned), b.touch).z


def held(law: Any, u: Vector, omega: Vector, b: Any) -> tuple[Vector, Vector]:
    """Return force and torque at rest, per rise of v_n."""
    if law.regions:
        return held_disc(u, FLAT_BIAS, 0.0, omega, b)
    return held_point(u, FLAT_BIAS, omega, b)


@cache
def stages(law: Any) -> dict[str, Stage]:
    """Return the motions of impacts under a law, by its regions and REST.

    "" is that without regions, or of a disc without friction.
    """
    torque = law.torque

    def stage(
        friction: Any, events: tuple = (), follows: Any = None, is_directed: bool = False
    ) -> Stage:
        def acts(q, b):
            none = 0 * q.v_n
            v = Vector(q.v_x, q.v_y, none)
            if not is_directed:
                v = times(b.speed, v)
            p, twist = Vector(q.p_x, q.p_y, q.p_n), Vector(q.t_x, q.t_y, q.t_n)
            gained = times(b.speed * b.ratio, plus(cross(arm(b.u, b.touch), p), twist))
            omega = angular_velocity(Turning(b.u, plus(b.L, gained)), b.touch)
            if law.regions:
                omega = omega._replace(z=b.speed * q.turn / b.touch.friction.patch)
            if friction is None:
                force, twist = held(law, b.u, omega, b.touch)
                force, twist = times(1 / force.z, force), times(1 / force.z, twist)
            else:
                force, twist = friction(omega, v, b.u.z, b.touch)
            return Acts(force, twist, v, omega)

        def rates(q, b):
            by = acts(q, b)
            across, none = gains(by, b), 0 * q.turn
            slides: Any = across.x, across.y, spun(by, b) if law.regions else none
            pace, w = 1 / across.z, 1
            if is_directed:
                turns, along = across_and_along(across, Vector(q.v_x, q.v_y, none))
                slides, pace, w = (-(turns * q.v_y), turns * q.v_x, along), 1, exp(q.turn)
            slips = (b.ratio * pace * one if friction else none for one in slides)
            power = w * (by.force.x * q.v_x + by.force.y * q.v_y)
            power = power + dot(by.torque, by.omega) / b.speed
            works = across.z, *by.force, *by.torque, q.v_n, power
            every = *slips, *(pace * w * one for one in works)
            return Motion._make(one / CLOCK_RATE for one in every)

        form = Form("impact", Motion._make((ONE,) * len(Motion._fields)), rates, lambda q, b: q)
        return Stage(form, acts, (REACHED, *events), follows or {}, is_directed)

    known = {REST: stage(None)}
    if not law.regions:
        stops = replace(STOPS, formula=lambda q, by, b: q.turn - log(b.rest))
        events = (stops,) if law.set_valued else ()
        return known | {"": stage(smooth_friction, events, is_directed=law.set_valued)}
    for name, region in law.regions.items():
        borders = [way for way in region.borders if way.event != "slow"]
        passing = (Event(way.event, "", border(way), way.direction, way.event) for way in borders)
        friction = disc_friction(region.drag, torque, edge_speed2)
        ends = (SLOWEST, STOPS, *passing)
        known[name] = stage(friction, ends, {way.event: way for way in borders})
    return known | {"": stage(disc_friction(lambda v2, U2: Drag(0.0, 0.0), torque, edge_speed2))}


def edge_speed2(omega: Vector, b: Any) -> Any:
    """Return U^2."""
    return (b.friction.patch * omega.z) ** 2


def border(way: Any) -> Callable:
    """Return the function of an end of a region."""
    return lambda q, by, b: way.beyond(speeds(q), b.touch)


def region_at(law: Any, q: Any, b: Any) -> str:
    """Return the region of a motion."""
    return region_of(speeds(q), b.touch) if can_rest(law, b) else ""


# --- stops, and what follows them ---------------------------------------------------------------


def can_rest(law: Any, b: Any) -> bool:
    """Return whether a law can hold the contact at rest."""
    return law.set_valued or bool(law.regions and b.touch.friction.mu > 0)


def stopped(law: Any, q: Any, b: Any) -> Any:
    """Return the motion without the rest of sliding and turning, which an impulse takes."""
    none = 0 * q.v_n
    q = kicked(law, q, Vector(-q.v_x, -q.v_y, none), -q.turn, b)
    return q._replace(v_x=none, v_y=none, turn=none)


def left(law: Any, by: Acts, b: Any) -> Any:
    """Return by how much friction can give more, of a contact at rest.

    The value is negative where it cannot hold the contact.
    """
    friction = b.touch.friction
    if law.regions:
        return margin(by.force, by.torque.z, friction)
    return friction.mu - sqrt(by.force.x**2 + by.force.y**2)


def slide(law: Any, q: Any, by: Acts, b: Any) -> Any:
    """Return the motion where a contact at rest begins to slide; `by` is what would hold it."""
    speed = b.begins
    if law.regions:
        v, edge = direction(by.force, by.torque.z, b.touch.friction)
        return kicked(law, q, times(speed, v), speed * edge, b)

    F = Vector(by.force.x, by.force.y, 0 * q.v_n)
    return kicked(law, q, times(-speed / sqrt(dot(F, F)), F), 0.0, b)


def kicked(law: Any, q: Any, v: Vector, turn: Any, b: Any) -> Any:
    """Return the motion after impulses that add v to the slip and `turn` to that of the edge."""
    p, twist = mobility_inverse_times(b.u, v, b.touch), 0.0
    if law.regions:
        p, (_, _, twist) = impulses(b.u, v, turn / b.touch.friction.patch, b.touch)
    omega = (2 * q.turn + turn) / getattr(b.touch.friction, "patch", 1.0)
    work = p.x * (q.v_x + v.x / 2) + p.y * (q.v_y + v.y / 2) + twist * omega / 2
    p, twist = times(1 / b.ratio, p), twist / b.ratio
    added = (v.x, v.y, turn, 0.0, *p, 0.0, 0.0, twist, p.z * q.v_n, work / b.ratio)
    return Motion._make(one + more for one, more in zip(q, added, strict=True))

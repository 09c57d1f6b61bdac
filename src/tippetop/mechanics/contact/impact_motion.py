"""An impact as a motion: the forces and torques of sliding, rolling or resting, per normal impulse.

dv_A = (K F + (I^-1 T) x a) dp and dL = (a x F + T) dp, F = zhat - push; push and T are those of the
same law in the phases of contact. The clock is v_n, which rises; under a set-valued law that slides
it is sigma, dp = |v_A| dsigma, in which nothing is singular where sliding stops. Components are
along e, 2hat, zhat, in internal units. The units of slip and of v_n are powers of two near them, so
that steps are as exact for slow impacts as for fast ones. [contact 3.2, 3.3]
"""

from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..disc_friction import Drag, rolling
from ..event import Event
from ..form import Form
from ..friction import load
from ..inlining import inlined
from ..operand import Vector, cross, dot, plus, sqrt, times
from ..units import ONE
from .body import angular_velocity, arm
from .coulomb import along_and_across, held_point
from .disc_at_rest import Held, direction, held_disc, impulses, margin
from .first_slip import first_directions
from .response import mobility_inverse_times, torque_acceleration
from .single_contact import Acts, Speeds, disc_friction, region_of, smooth_friction


CLOCK_RATE = 2.0**10
"""Of the time of a motion, relative to v_n: a step that leads nowhere takes 1e-10 of this time."""

RESTS_AT = 450
"""Slip at which a contact neither slides nor turns, in rounding errors."""

BEGINS_AT, DISC_BEGINS_AT = 1e-10, 2e-8
"""Slip with which sliding of a point and of a disc begins within an impact with torques: the error
of the motion after it. A smaller one takes more steps where torques turn the force that holds the
contact.
"""

Blow: Any = namedtuple("Blow", "by_v_n by_work_n by_p_n goal K s z speed ratio rest begins L touch")
"""The parameters of an impact.

A stage ends where by_v_n v_n + by_work_n work_n + by_p_n p_n = goal. Then mobility; sin(theta),
cos(theta); the unit of slip; the unit of v_n by it; the slip of a contact at rest, and that with
which it begins to slide; L before the impact; the body.
"""

Motion: Any = namedtuple("Motion", "v_e v_2 turn v_n p_e p_2 p_n t_e t_2 t_n work_n work_t")
"""Slip along e and 2hat, and of the edge of a disc; v_n; impulses of the force and of the torque;
works of the normal force and of friction."""

REACHED = Event(
    "reached",
    "the stage ends",
    lambda q, by, b: b.by_v_n * q.v_n + b.by_work_n * q.work_n + b.by_p_n * q.p_n - b.goal,
    1,
    "reached",
)
REST = "rest"
FLAT_BIAS = Vector(0.0, 0.0, -1.0)
"""Minus the acceleration of the contact point: v_n rises by one."""


class Stage(NamedTuple):
    """The motion in a region of a law, or at rest."""

    form: Form
    acts: Callable  # acts(q, b) -> Acts, per normal impulse
    slope: Callable  # slope(q, b) -> v_n per normal impulse, and growth
    events: tuple[Event, ...]  # formula(q, acts, b)
    follows: dict[str, str]  # the next region, by the event of a border


def axis(b: Any) -> Vector:
    """Return 3hat."""
    return Vector(b.s, 0.0, b.z)


def speeds(q: Any) -> Speeds:
    """Return the squares of sliding and turning."""
    return Speeds(q.v_e * q.v_e + q.v_2 * q.v_2, q.turn * q.turn)


def gains(by: Acts, b: Any) -> Vector:
    """Return dv_A/dp."""
    K, F, turned = b.K, by.force, torque_acceleration(axis(b), by.torque, b.touch)
    pushed = Vector(K.ez * F.z + K.ee * F.x, K.tt * F.y, K.zz * F.z + K.ez * F.x)
    return plus(pushed, turned)


def spun(by: Acts, b: Any) -> Any:
    """Return the rate of the velocity of a disc's edge by the normal impulse."""
    turned = plus(cross(arm(axis(b), b.touch), by.force), by.torque)
    return b.touch.friction.patch * angular_velocity(axis(b), turned, b.touch).z


def held(law: Any, u: Vector, omega: Vector, b: Any) -> tuple[Vector, Vector]:
    """Return force and torque at rest, per rise of v_n."""
    if law.regions:
        rolls = rolling(omega, b.friction)
        force, torque = held_disc(u, FLAT_BIAS, 0.0, rolls, b)
        return force, Vector(force.z * rolls.x, force.z * rolls.y, torque)
    return held_point(u, FLAT_BIAS, load(omega, b.friction), b)


_stages: dict[type, dict[str, Stage]] = {}


def stages(law: Any) -> dict[str, Stage]:
    """Return the motions of impacts under a law; the same ones for a law's record."""
    if law not in _stages:
        _stages[law] = new_stages(law)
    return _stages[law]


def new_stages(law: Any) -> dict[str, Stage]:
    """Return the motions of impacts under a law, by its regions and REST; "" is that without
    regions, or of a disc without friction.
    """
    torque = law.torque

    def stage(
        friction: Callable | None, events: tuple = (), follows: Any = None, by_slip: bool = False
    ) -> Stage:
        def acts(q, b):
            none, u = 0 * q.v_n, axis(b)
            v = Vector(b.speed * q.v_e, b.speed * q.v_2, none)
            p, twist = Vector(q.p_e, q.p_2, q.p_n), Vector(q.t_e, q.t_2, q.t_n)
            gained = times(b.speed * b.ratio, plus(cross(arm(u, b.touch), p), twist))
            omega = angular_velocity(u, plus(b.L, gained), b.touch)
            if law.regions:
                omega = omega._replace(z=b.speed * q.turn / b.touch.friction.patch)
            if friction is None:
                force, twist = held(law, u, omega, b.touch)
                force, twist = times(1 / force.z, force), times(1 / force.z, twist)
            else:
                push, twist = friction(omega, v, u.z, b.touch)
                force = Vector(-push.x, -push.y, 1 + none)
            return Acts(force, twist, v, omega)

        def growth(q, by, b):
            across = gains(by, b)
            turning = q.turn * spun(by, b) if law.regions else 0 * q.turn
            return q.v_e * across.x + q.v_2 * across.y + turning

        def rates(q, b):
            by = acts(q, b)
            across = gains(by, b)
            per = (sqrt(speeds(q).v2) if by_slip else 1 / across.z) / CLOCK_RATE
            slips: Any = (0 * q.turn,) * 3
            if friction is not None:
                slips = across.x, across.y, spun(by, b) if law.regions else 0 * q.turn
            power = by.force.x * q.v_e + by.force.y * q.v_2 + dot(by.torque, by.omega) / b.speed
            every = (
                *(b.ratio * rate for rate in slips),
                across.z,
                *by.force,
                *by.torque,
                q.v_n,
                power,
            )
            return Motion._make(per * rate for rate in every)

        @inlined
        def slope(q, b):
            by = acts(q, b)
            return gains(by, b).z, growth(q, by, b)

        slowest = (
            ()
            if by_slip or friction is None
            else (Event("slowest", "slip begins to grow", growth, 1, "slowest"),)
        )
        form = Form("impact", Motion._make((ONE,) * len(Motion._fields)), rates, lambda q, b: q)
        return Stage(form, acts, slope, (REACHED, *slowest, *events), follows or {})

    stops = Event("stops", "the contact neither slides nor turns", beyond_rest, -1, "stops")
    known = {REST: stage(None)}
    if not law.regions:
        return known | {
            "": stage(smooth_friction, (stops,) if law.set_valued else (), by_slip=law.set_valued)
        }
    for name, region in law.regions.items():
        borders = [way for way in region.borders if way.event != "slow"]
        events = (Event(way.event, "", border(way), way.direction, way.event) for way in borders)
        friction = disc_friction(region.drag, torque, edge_speed2)
        known[name] = stage(friction, (stops, *events), {way.event: way.follows for way in borders})
    return known | {"": stage(disc_friction(lambda v2, U2: Drag(0.0, 0.0), torque, edge_speed2))}


def edge_speed2(omega: Vector, b: Any) -> Any:
    """Return U^2."""
    return (b.friction.patch * omega.z) ** 2


def border(way: Any) -> Callable:
    """Return the function of an end of a region."""
    return lambda q, by, b: way.beyond(speeds(q), b.touch)


def beyond_rest(q: Any, by: Any, b: Any) -> Any:
    """Return the square of the slip beyond that of a contact at rest."""
    return sum(speeds(q)) - b.rest**2


def region_at(law: Any, q: Any, b: Any) -> str:
    """Return the region of a motion."""
    return region_of(speeds(q), law.regions, b.touch) if can_rest(law, b) else ""


# --- stops, and what follows them ---------------------------------------------------------------


def can_rest(law: Any, b: Any) -> bool:
    """Return whether a law can hold the contact at rest."""
    return law.set_valued or bool(law.regions and b.touch.friction.mu > 0)


def stopped(law: Any, q: Any, b: Any) -> Any:
    """Return the motion without the rest of sliding and turning, which an impulse takes."""
    q = kicked(law, q, Vector(-q.v_e, -q.v_2, 0 * q.v_n), -q.turn, b)
    return q._replace(v_e=0 * q.v_n, v_2=0 * q.v_n, turn=0 * q.v_n)


def left(law: Any, by: Acts, b: Any) -> Any:
    """Return by how much friction can give more, of a contact at rest; negative where it cannot
    hold it.
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

    def motion(beta):
        n = Vector(np.cos(beta), np.sin(beta), 0 * beta)
        across = gains(stages(law)[""].acts(q._replace(v_e=n.x, v_2=n.y), b), b)
        return (*along_and_across(across, n), 1 + 0 * beta)

    directions = first_directions(motion)
    beta = directions[0] if len(directions) else np.arctan2(-by.force.y, -by.force.x)
    return kicked(law, q, Vector(speed * np.cos(beta), speed * np.sin(beta), 0.0), 0.0, b)


def kicked(law: Any, q: Any, v: Vector, turn: Any, b: Any) -> Any:
    """Return the motion after impulses that add v to the slip and `turn` to that of the edge."""
    u = axis(b)
    if law.regions:
        p, twist = impulses(u, v, turn / b.touch.friction.patch, b.touch)
    else:
        p, twist = Held(mobility_inverse_times(u, v, b.touch), 0.0)
    omega = (2 * q.turn + turn) / getattr(b.touch.friction, "patch", 1.0)
    work = p.x * (q.v_e + v.x / 2) + p.y * (q.v_2 + v.y / 2) + twist * omega / 2
    p, twist = times(1 / b.ratio, p), twist / b.ratio
    added = (v.x, v.y, turn, 0.0, *p, 0.0, 0.0, twist, p.z * q.v_n, work / b.ratio)
    return Motion._make(one + more for one, more in zip(q, added, strict=True))

"""An impact under a law with torques: the forces and torques of sliding, rolling or resting, per normal impulse.

dv_A = (K F + (I^-1 T) x a) dp and dL = (a x F + T) dp, F = zhat - push; push and T are those of the same law in the
phases of contact. The clock is v_n, which rises; under a set-valued law that slides it is sigma, dp = |v_A| dsigma,
in which nothing is singular where sliding stops. [contact 3.2, 3.3]
"""

from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..disc_friction import rolling
from ..events import Event
from ..form import Form
from ..friction import load
from ..operand import Vector, cross, dot, plus, sqrt, times
from ..units import ONE
from .body import angular_velocity, arm, centre_velocity
from .coulomb import along_and_across, held_point
from .disc_at_rest import Held, direction, held_disc, impulses, margin
from .first_slip import first_directions
from .impact_motion import CLOCK_RATE
from .response import mobility_inverse_times, mobility_times, torque_acceleration
from .single_contact import (
    RESTS,
    STOPS_AT,
    Acts,
    Speeds,
    disc_friction,
    patch_speed2,
    regions_of,
    rest_speed2,
    smooth_friction,
)
from .state import Moving


BEGINS_AT = 1e-10
"""|v_A| with which sliding begins within an impact under a set-valued law: the error of the motion after it."""

Blow: Any = namedtuple("Blow", "u touch unit by_v by_work by_p goal")
"""Parameters: 3hat; the body; the unit of the clock; a stage ends where by_v v_n + by_work work_n +
by_p p_z = goal."""

Motion: Any = namedtuple("Motion", "vx vy v_n Lx Ly Lz px py p_z tx ty tz work_n work_t")
"""Velocity of the contact point, L, impulses of the force and of the torque; works of the normal
force and of friction."""

REACHED = Event(
    "reached",
    "the stage ends",
    lambda q, by, b: b.by_v * q.v_n + b.by_work * q.work_n + b.by_p * q.p_z - b.goal,
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
    events: tuple[Event, ...]  # formula(q, acts, b)
    follows: tuple  # pairs of the event of a border and the next region


def speeds(by: Acts, b: Any) -> Speeds:
    """Return the squares of sliding and turning, of a law with regions."""
    return Speeds(by.velocity.x**2 + by.velocity.y**2, patch_speed2(by.omega, b.touch))


def gains(by: Acts, b: Any) -> Vector:
    """Return dv_A/dp."""
    return plus(mobility_times(b.u, by.force, b.touch), torque_acceleration(b.u, by.torque, b.touch))


def turns(by: Acts, b: Any) -> Vector:
    """Return dL/dp."""
    return plus(cross(arm(b.u, b.touch), by.force), by.torque)


def growth(q: Any, by: Acts, b: Any) -> Any:
    """Half of the rate of the square of the slip."""
    across, v = gains(by, b), by.velocity
    spun = angular_velocity(b.u, turns(by, b), b.touch).z
    return v.x * across.x + v.y * across.y + b.touch.friction.patch**2 * by.omega.z * spun


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
    """Return the motions of impacts under a law, by its regions and REST; of a law without regions the first is ""."""

    def stage(friction: Callable | None, events: tuple, follows: tuple, by_slip: bool = False) -> Stage:
        def acts(q, b):
            none = 0 * q.v_n
            v, omega = Vector(q.vx, q.vy, none), angular_velocity(b.u, Vector(q.Lx, q.Ly, q.Lz), b.touch)
            if friction is None:
                force, torque = held(law, b.u, omega, b.touch)
                force, torque = times(1 / force.z, force), times(1 / force.z, torque)
            else:
                push, torque = friction(omega, v, b.u.z, b.touch)
                force = Vector(-push.x, -push.y, 1 + none)
            return Acts(force, torque, v, omega)

        def rates(q, b):
            by = acts(q, b)
            v, across = by.velocity, gains(by, b)
            per = (sqrt(v.x**2 + v.y**2) if by_slip else b.unit / across.z) / CLOCK_RATE
            power = dot(by.force, v) + dot(by.torque, by.omega)
            every = (*across, *turns(by, b), *by.force, *by.torque, q.v_n, power)
            return Motion._make(per * rate for rate in every)

        form = Form("impact", Motion._make((ONE,) * len(Motion._fields)), rates, lambda q, b: q)
        return Stage(form, acts, (REACHED, *events), follows)

    def stops(function: Callable) -> Event:
        return Event("stops", "the contact neither slides nor turns", function, -1, "stops")

    at_rest = {REST: stage(None, (), ())}
    if not law.regions:
        slow = stops(lambda q, by, b: sqrt(q.vx**2 + q.vy**2) - STOPS_AT)
        ends = (slow,) if law.set_valued else ()
        return {"": stage(smooth_friction, ends, (), law.set_valued), **at_rest}
    some, torque = {}, law.torque
    assert torque is not None
    for name, region in law.regions.items():
        borders = [way for way in region.borders if way.event != "slow"]
        events = (
            stops(lambda q, by, b: RESTS.formula(speeds(by, b), b.touch)),
            Event("slowest", "slip begins to grow", growth, 1, "slowest"),
            *(Event(way.event, "", border(way), way.direction, way.event) for way in borders),
        )
        friction = disc_friction(region.drag, torque)
        some[name] = stage(friction, events, tuple((way.event, way.follows) for way in borders))
    return some | at_rest


def border(way: Any) -> Callable:
    """Return the function of an end of a region."""
    return lambda q, by, b: way.beyond(speeds(by, b), b.touch)


# --- stops, and what follows them -----------------------------------------------------------------


def is_slow(law: Any, q: Any, b: Any, stops: bool) -> bool:
    """Return whether the contact rests, or is about to, as it is where its slip has just stopped."""
    if law.regions:
        return bool(b.touch.friction.mu > 0 and (stops or speed2(q, b) <= rest_speed2(b.touch)))
    return bool(law.set_valued and (stops or speed2(q, b) <= STOPS_AT**2))


def speed2(q: Any, b: Any) -> Any:
    """Return the square of the slip."""
    turns = angular_velocity(b.u, Vector(q.Lx, q.Ly, q.Lz), b.touch).z
    return q.vx**2 + q.vy**2 + (getattr(b.touch.friction, "patch", 0.0) * turns) ** 2


def stopped(law: Any, q: Any, b: Any) -> Any:
    """Return the motion without the rest of sliding and turning, which an impulse takes."""
    turns = angular_velocity(b.u, Vector(q.Lx, q.Ly, q.Lz), b.touch).z
    return kicked(law, q, Vector(-q.vx, -q.vy, 0 * q.v_n), -turns, b)


def left(law: Any, by: Acts, b: Any) -> Any:
    """Return by how much friction can give more, of a contact at rest; negative where it cannot hold it."""
    friction = b.touch.friction
    if law.regions:
        return margin(by.force, by.torque.z, friction)
    return friction.mu - sqrt(by.force.x**2 + by.force.y**2)


def slide(law: Any, stage: Any, q: Any, by: Acts, b: Any) -> Any:
    """Return the motion where a contact at rest begins to slide; `by` is what would hold it,
    `stage` the motion of sliding under a law without regions."""
    if law.regions:
        v, edge = direction(by.force, by.torque.z, b.touch.friction)
        speed = 2 * sqrt(rest_speed2(b.touch))
        return kicked(law, q, times(speed, v), speed * edge / b.touch.friction.patch, b)

    def motion(beta):
        n = Vector(np.cos(beta), np.sin(beta), 0 * beta)
        across = gains(stage.acts(q._replace(vx=n.x, vy=n.y), b), b)
        return (*along_and_across(across, n), 1 + 0 * beta)

    directions = first_directions(motion)
    beta = directions[0] if len(directions) else np.arctan2(-by.force.y, -by.force.x)
    return kicked(law, q, Vector(BEGINS_AT * np.cos(beta), BEGINS_AT * np.sin(beta), 0.0), 0.0, b)


def kicked(law: Any, q: Any, v: Vector, Omega_z: Any, b: Any) -> Any:
    """Return the motion after impulses that add v to the velocity of the contact and Omega_z to its turning."""
    by = impulses(b.u, v, Omega_z, b.touch) if law.regions else Held(mobility_inverse_times(b.u, v, b.touch), 0.0)
    p, twist = by.force, Vector(0.0, 0.0, by.torque)
    turn = plus(cross(arm(b.u, b.touch), p), twist)
    L = Vector(q.Lx, q.Ly, q.Lz)
    turned = angular_velocity(b.u, plus(times(2, L), turn), b.touch).z
    work = p.x * (q.vx + v.x / 2) + p.y * (q.vy + v.y / 2) + twist.z * turned / 2
    added = (v.x, v.y, 0.0, *turn, *p, *twist, p.z * q.v_n, work)
    return Motion._make(one + more for one, more in zip(q, added, strict=True))


def region_at(law: Any, q: Any, b: Any) -> str:
    """Return the region of a motion."""
    L, v = Vector(q.Lx, q.Ly, q.Lz), Vector(q.vx, q.vy, q.v_n)
    x = Moving(b.u, L, centre_velocity(b.u, L, v, b.touch), 0.0)
    return "".join(regions_of(x, law.regions, b.touch))

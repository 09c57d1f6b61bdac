"""An impact under friction that is smooth in the sliding velocity, as a motion: v_n, which rises, is
its clock. [contact 3.3, 5]

dv = K (zhat - push) dp of the normal impulse p, and what a torque about the vertical adds, as in
`struck`. A contact disc turns at its edge with `turn`, its radius times Omega_z; a law with regions
has one motion for each. The units of a motion are powers of two near its numbers, so that steps
are as exact for slow impacts as for fast ones.
"""

import math
from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from ..disc_friction import Border, Region
from ..events import Event
from ..form import Form
from ..friction import slip_coefficient
from ..inlining import inlined
from ..operand import formula
from ..units import ONE


CLOCK_RATE = 2.0**10
"""Of the time of a motion, relative to v_n: a step that leads nowhere takes 1e-10 of this time."""

RESTS_AT = 450
"""Slip at which a disc neither slides nor turns, in rounding errors."""

Blow: Any = namedtuple("Blow", "ee zz ez tt across about z ratio speed rest friction")
"""The parameters of an impact: mobility and `Spin`; cos(theta); the unit of v_n by the unit of slip;
the unit of slip; the slip of a disc at rest; the record of the law."""

Motion: Any = namedtuple("Motion", "v_e v_2 turn v_n p_e p_2 p_n twist work_n work_t")
"""Slip along e and 2hat, and of the edge of the disc; v_n; impulses, `twist` that of the torque;
works of the normal force and of friction."""

Push: Any = namedtuple("Push", "e t turn")
"""Friction along e, along 2hat and at the edge, per normal force."""

Speeds: Any = namedtuple("Speeds", "v2 U2")


@formula
def speeds(q):
    """Return the squares of sliding and turning."""
    return Speeds(q.v_e * q.v_e + q.v_2 * q.v_2, q.turn * q.turn)


@formula
def smooth_push(q, b):
    """Friction under a law with a coefficient."""
    k = b.speed * slip_coefficient(speeds(q).v2 * b.speed**2, b.z, b.friction)
    return Push(-(k * q.v_e), -(k * q.v_2), 0 * k)


@formula
def lift(push, b):
    """v_n per normal impulse. Where it is not positive, friction jams the contact."""
    return b.zz + b.ez * push.e


@formula
def slip_rates(push, b):
    """Rates of v_e, v_2 and turn by the normal impulse."""
    along = b.ez + b.ee * push.e
    across = b.tt * push.t + b.across * push.turn
    return along, across, b.across * push.t + b.about * push.turn


@formula
def growth(q, push, b):
    """Half the rate of the square of the slip by the normal impulse."""
    along, across, turn = slip_rates(push, b)
    return q.v_e * along + q.v_2 * across + q.turn * turn


@formula
def beyond_rest(q, push, b):
    """Square of the slip beyond that of a disc at rest."""
    return sum(speeds(q)) - b.rest**2


SLOWEST = Event("slowest", "slip begins to grow", growth, 1, "slowest")
"""A step ends there: a longer one may pass over a stop of the slip, and not see it."""

STOPS = Event("stops", "the disc neither slides nor turns", beyond_rest, -1, "stops")
RESTORED = {"energetic": "work_n", "poisson": "p_n"}
"""What is zero at the end of restitution, by its law; under the other one v_n is known."""


class Sliding(NamedTuple):
    """The motion of a contact that slides, in a region of a law."""

    form: Form
    push: Callable  # push(q, b)
    slope: Callable  # slope(q, b) -> lift and growth
    events: tuple[Event, ...]  # formula(q, push, b)
    signs: tuple[int, ...]  # of their functions before they happen
    follows: dict[str, str]  # the next region, by the event of a border


@lru_cache
def sliding(region: Region | None, restitution: str) -> Sliding:
    """Return the motion in a region of a law; None: under a law with a coefficient."""

    @formula
    def disc_push(q, b):
        by, mu = region.drag(*speeds(q)), b.friction.mu  # type: ignore[union-attr]
        return Push(-(mu * by.k * q.v_e), -(mu * by.k * q.v_2), -(mu * by.twist * q.turn))

    push = smooth_push if region is None else disc_push

    @formula
    def rates(q, b):
        by = push(q, b)
        per = 1 / (CLOCK_RATE * lift(by, b))
        slips = (b.ratio * per * rate for rate in slip_rates(by, b))
        power = by.e * q.v_e + by.t * q.v_2 + by.turn * q.turn
        impulses = per * by.e, per * by.t, per, per * by.turn
        return Motion._make((*slips, 1 / CLOCK_RATE + 0 * q.v_n, *impulses, per * q.v_n, per * power))

    @inlined
    def slope(q, b):
        by = push(q, b)
        return lift(by, b), growth(q, by, b)

    def restored(q, push, b):
        return getattr(q, RESTORED[restitution])

    def border(way: Border) -> Event:
        return Event(way.event, "", lambda q, push, b: way.beyond(speeds(q), b), way.direction, way.event)

    events, follows = [SLOWEST], {}
    if restitution in RESTORED:
        events.append(Event("restored", "restitution ends", restored, 1, "restored"))
    if region is not None:
        follows = {way.event: way.follows for way in region.borders if way.event != "slow"}
        events += [STOPS, *(border(way) for way in region.borders if way.event in follows)]
    form = Form("impact", Motion._make((ONE,) * len(Motion._fields)), rates, lambda q, b: q)
    return Sliding(form, push, slope, tuple(events), tuple(-event.direction for event in events), follows)


def held(q: Any, b: Any, until: Any, restitution: str) -> tuple[Any, str]:
    """Return the motion of a disc that has come to rest where v_n is `until`, or, without it, where
    restitution ends; and whether the disc sticks or slips on, as a point does: in closed form."""
    sticks, side = abs(b.ez) <= b.friction.mu * b.ee, 1 if b.ez > 0 else -1
    push = Push(-(b.ez / b.ee) if sticks else -(side * b.friction.mu), 0 * b.z, 0 * b.z)
    rise, along = lift(push, b), 0 * b.z if sticks else b.ratio * slip_rates(push, b)[0]
    if not rise > 0:
        return None, ""
    p = (until - q.v_n) / rise if until is not None else -q.p_n
    if until is None and restitution == "energetic":
        p = -2 * q.work_n / (q.v_n + (q.v_n**2 - 2 * rise * q.work_n) ** 0.5)
    v_n, v_e = q.v_n + rise * p, q.v_e + along * p
    q = q._replace(
        v_e=v_e,
        v_n=v_n,
        p_e=q.p_e + push.e * p,
        p_n=q.p_n + p,
        work_n=q.work_n + p * (q.v_n + v_n) / 2,
        work_t=q.work_t + push.e * p * (q.v_e + v_e) / 2,
    )
    return q, "stick" if sticks else "slip"


def unit_of(*values: Any) -> float:
    """Return a power of two near the largest of some numbers."""
    return math.ldexp(1.0, math.frexp(max(map(abs, map(float, values))))[1])

"""An impact as a motion: its equations, with the normal velocity instead of the time as clock.

`stages(law)` returns the equations by region of the law; `engine.impacts` integrates them and
changes from stage to stage, with the functions at the end. dv_A = (K F + (I^-1 T) x a) dp and dL =
(a x F + T) dp; F and T are the force and torque of the law in the phases of contact, per normal
force, and the axis stays. The clock is v_n, which rises; under a law that can hold the contact at
rest, the clock of sliding is sigma, dp = w dsigma, and the slip is its direction and the logarithm
of its size w, in which nothing is singular where sliding stops. The units of slip and of v_n are
powers of two near them, so that steps are as exact for slow impacts as for fast ones.

Symbols
    q         the motion, a `Motion`; b: its parameters, a `Blow`, with the body b.touch
    by        the action of the plane, an `Acts`: force and torque per normal impulse
    p         normal impulse; v_n: normal velocity of the contact point; w: speed of slip
    way       a border of a region of the law, see `disc_friction`
    a, K      the arm; acceleration of the contact point per force, see `response`
"""

from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from ..event import Event
from ..form import Form
from ..friction import has_parts
from ..operand import Vector, cross, dot, exp, log, minus, plus, times
from ..units import ONE
from .body import Turning, angular_velocity, arm
from .contact_phases import Acts, Speeds, disc_friction, region_of, smooth_friction
from .response import direction, gains, held, margin


CLOCK_RATE = 2.0**10
"""Of the time of a motion, relative to v_n: a step that leads nowhere takes 1e-10 of this time."""

BEGINS_AT, DISC_BEGINS_AT = 1e-10, 2e-8
"""Slip with which sliding of a point and of a disc begins within an impact with torques: the error
of the motion after it. A smaller one takes more steps where torques turn the force that holds the
contact.
"""

Blow: Any = namedtuple("Blow", "by goal speed ratio stops u L touch")
"""The parameters of an impact.

by, goal: a stage ends where by.(v_n, work_n, p_n) = goal, see ENDS. speed: the unit of slip [m/s].
ratio: the unit of v_n divided by that of slip. stops: logarithm of the slip, in its unit, at which
a contact is at rest. u: 3hat or a Frame. L: (3,), before the impact. touch: the body.
`engine.impacts` fills a Blow by position, twice; a change here is a change there.
"""

Motion: Any = namedtuple("Motion", "v_x v_y turn grown v_n p_x p_y p_n t_x t_y t_n work_n")
"""v_x, v_y, turn: slip, and velocity of the edge of a disc, in the unit of slip and divided by
exp(grown). v_n: normal velocity, in its unit. p_x, p_y, p_n: impulse of the force, t_x, t_y, t_n:
of the torque, by the unit of v_n. work_n: work of the normal force, by the square of this unit.
`rates` and `engine.impacts` fill a Motion by position.
"""


ENDS = {
    "newton": Vector(1.0, 0.0, 0.0),
    "energetic": Vector(0.0, 1.0, 0.0),
    "poisson": Vector(0.0, 0.0, 1.0),
}
"""The number by which a law of impact ends restitution, of (v_n, work_n, p_n): `Blow.by`.

The keys are `restitution.RESTITUTIONS`; `ImpactMotions.struck` has the goals in the same order.
"""
REACHED = Event(
    "reached",
    "the stage ends",
    lambda q, b: dot(b.by, Vector(q.v_n, q.work_n, q.p_n)) - b.goal,
    1,
    "reached",
)
STOPS = Event(
    "stops",
    "the contact neither slides nor turns",
    lambda q, b: q.grown - b.stops,
    -1,
    "stops",
)
REST = "rest"
FLAT_BIAS = Vector(0.0, 0.0, -1.0)
"""Minus the acceleration of the contact point: v_n rises by one."""


class Stage(NamedTuple):
    """The part of an impact in which the contact stays in one region of a law, or at rest."""

    form: Form
    acts: Callable  # acts(q, b) -> Acts, per normal impulse, or at rest per rise of v_n
    events: tuple[Event, ...]  # formula(q, b)
    follows: dict[str, Any]  # the `Border` that is reached, by the name of its event


def can_rest(law: Any) -> bool:
    """Return whether a law can hold the contact at rest."""
    return law.set_valued or bool(law.regions)


def speeds(q: Any) -> Speeds:
    """Return |v|^2 and U^2 of a motion, divided by exp(grown)^2, for the borders of regions.

    The borders that `stages` uses are conditions on |v|/U only, so the factor does not matter.
    """
    return Speeds(q.v_x * q.v_x + q.v_y * q.v_y, q.turn * q.turn)


def responses(b: Any, by: Acts) -> tuple[Vector, Vector]:
    """Return dv_A/dp [1/kg] and domega/dp, (3,) each, of the normal impulse p."""
    return gains(b.u, by.force, by.torque, b.touch)


@cache
def stages(law: Any) -> dict[str, Stage]:
    """Return the motions within an impact: by region of the law (or ""), and REST, if it can rest.

    Parameters
    ----------
    law
        The friction law, as the type of its record.
    """

    def stage(friction: Any, *ends: Event, **follows: Any) -> Stage:
        """Return the motion in one region of the law: its form, and the events that end it.

        `friction` is that of the region, None at rest; `follows` has the border for each of its
        events.
        """
        is_directed = bool(friction) and can_rest(law)

        def acts(q, b):
            """Return the `Acts` of the plane in a motion q: force and torque per normal impulse (at
            rest per rise of v_n), and the velocities of the contact.
            """
            none = 0 * q.v_n
            w = b.speed * (exp(q.grown) if is_directed else 1)
            p = Vector(q.p_x, q.p_y, q.p_n)
            twist = Vector(q.t_x, q.t_y, q.t_n)
            turned = plus(cross(arm(b.u, b.touch), p), twist)
            L = plus(b.L, times(b.speed * b.ratio, turned))  # the unit of v_n, and of impulses
            v = Vector(w * q.v_x, w * q.v_y, none)
            omega = angular_velocity(Turning(b.u, L), b.touch)
            if law.regions:  # `turn` is a variable: it keeps its digits where turning stops
                omega = omega._replace(z=w * q.turn / b.touch.friction.patch)
            if friction is None:
                force, torque = held(b.u, FLAT_BIAS, 0.0, omega, b.touch)
            else:
                force, torque = friction(omega, v, b.u.z, b.touch)
            return Acts(force, torque, v, omega)

        def rates(q, b):
            """Return the rates of the motion's variables by its clock.

            The clock is v_n; under a law that can hold the contact at rest, that of sliding is
            sigma, dp = w dsigma.
            """
            by = acts(q, b)
            none = 0 * q.turn
            across, turns = responses(b, by)
            spun = b.touch.friction.patch * turns.z if law.regions else none
            n = Vector(q.v_x, q.v_y, q.turn)
            slides = times(b.ratio, across._replace(z=spun))
            if is_directed:
                pace = exp(q.grown)
                grows = dot(slides, n) / dot(n, n)
                slides = minus(slides, times(grows, n))
            else:
                pace = 1 / across.z
                grows = none
                slides = times(pace if friction else none, slides)  # none at rest: slip stays 0
            # the order of `Motion`: slides and grows, then works
            works = across.z, *by.force, *by.torque, by.force.z * q.v_n
            every = *slides, grows, *(pace * one for one in works)
            return Motion._make(one / CLOCK_RATE for one in every)

        form = Form("impact", Motion._make((ONE,) * len(Motion._fields)), rates)
        return Stage(form, acts, (REACHED, *ends), follows)

    stops = (STOPS,) if can_rest(law) else ()
    known = {REST: stage(None)}
    for name, region in law.regions.items():
        # "slow" is a condition on w alone, which `speeds` lacks; it leads to the same region
        ways = {way.event: way for way in region.borders if way.event != "slow"}
        passing = (border(way) for way in ways.values())
        friction = disc_friction(region.drag, law.torque, edge_speed2)
        known[name] = stage(friction, *stops, *passing, **ways)
    return known if law.regions else known | {"": stage(smooth_friction, *stops)}


def edge_speed2(omega: Vector, b: Any) -> Any:
    """Return U^2 = (patch Omega_z)^2, the square of the speed of the disc's edge.

    It may be 0, other than `contact_phases.patch_speed2`, and is in the unit of the slip.
    """
    return (b.friction.patch * omega.z) ** 2


def border(way: Any) -> Event:
    """Return the event in which a motion leaves a region of the law by the border `way`."""
    function = lambda q, b: way.beyond(speeds(q), b.touch)  # noqa: E731
    return Event(way.event, "", function, way.direction, way.event)


def region_at(q: Any, b: Any) -> str:
    """Return the region of the law in which a motion q slides, "" without regions."""
    return region_of(speeds(q), b.touch)


def holding_margin(by: Acts, b: Any) -> Any:
    """Return by how much friction can hold the contact at rest, see `margin`.

    The result is negative if it cannot.
    """
    return margin(by.force, by.torque.z, b.touch.friction)


def slide(q: Any, by: Acts, b: Any) -> Any:
    """Return the motion q with the first slip of a contact that friction cannot hold at rest.

    `by` are the force and torque that would be needed to hold it, those of the stage REST.
    """
    law = b.touch.friction
    grown = b.stops + 1  # above the slip at which STOPS ends the stage
    if has_parts(law):
        grown = log((DISC_BEGINS_AT if law.regions else BEGINS_AT) / b.speed)
    v, edge = direction(by.force, by.torque.z, law)
    return q._replace(v_x=v.x, v_y=v.y, turn=edge, grown=grown)

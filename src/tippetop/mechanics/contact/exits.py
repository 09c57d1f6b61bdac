"""Jumps of a body whose contact may open: the phase that follows the end of another one.

Each jump has the signature jump(x, world) -> Next, see `form.Exit`: in goes the common state in
which a phase ended, in internal units, out come the name of the next phase, the common state in
which it begins, and rows of the table of impacts. The table JUMPS, and `begin` at the start of a
run, are the entrances; `opening.phases_of` attaches them to phases. Jumps are recorded as programs
(`engine.jump_programs`): each must be a function of its arguments alone.

Symbols
    x         the common state, a `body.Moving`: axis u, momentum L, velocity, height, integrals
    world     `body[k]`: the body b seen from ball k; `phases` by name; `phase` that ends; `rules`
              of impact; `left`: time until the run ends; struck(x, b, e_n): an impact of a ball;
              rates(phase, q, carried): of the integrals
    n         the result, a `Next`; cause: its word in the table of phases, one of REASONS
    ball, k   0: the sphere, 1: the ball of the stem
    v         velocity of the contact point, v_n its vertical part; of slip w: speed, beta: azimuth
    q         the state of a phase; F: force of the plane, N its normal part
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..dual import Dual, has_derivatives, parts_of, plain
from ..form import CLOCK, Next, Phase
from ..operand import Vector, atan2, cross, dot, leaves, plus, refill, sqrt, times
from ..units import JOULE, METRE_PER_SECOND, NEWTON_SECOND
from . import body as contact
from .body import BALLS, Moving, Touch, contact_velocity
from .contact_phases import (
    CONE,
    RESTS,
    STOPS_AT,
    brought_to_rest,
    frictions_of,
    horizontal2,
    phase_name,
    regions_of,
    rest_speed2,
    rolled,
    without_slip_on_both,
)
from .first_slip import first_directions, first_slip
from .frame import Asymmetric
from .present_body import present
from .response import (
    bias_vector,
    cone,
    direction,
    impulses,
    kicked,
    margin,
    resting,
    stopping,
    turn_held,
)
from .surroundings import joined_values, mean_gravity


CLOSES_AT = 1e-8
"""v_n below which an impact does not bounce: the error is its square."""

ON_PLANE = 1e-12
"""Gap of a ball that touches."""

BOTH_AT = 1e-6
"""v_n of both balls below which the body is on them; impulses take it: the error is its square."""

PRESSES = 1e-12
"""Least part of the weight that a ball carries."""

SOON = 0.1
"""A disc that passes its rest has its speed again within this part of the time in which the lack of
friction may vanish."""

MOST_STRIKES = 256
"""Impacts at one instant: balls that throw each other down strike ever more slowly."""

DIFFERENCE = 2.0**-16
"""Time, internal units, of a difference whose sign decides."""

SPAN, SLOW = 0.03, 0.5
"""Time over which a slow slide is one series: this part of 1/|omega|, and at most that of the time
in which gravity swings the body."""

NO_WAY = "the contact opens and closes at once: the model has no solution"
MAKES_ENERGY = (
    'restitution = "newton" made energy in an impact, which no impact does: use "energetic"'
)
BOTH = (
    "the body stands on its sphere and its stem, which is not followed under Coulomb's law itself"
)


IMPACT = contact.filled(
    ball=BALLS,
    v_n_before=METRE_PER_SECOND,
    v_n_after=METRE_PER_SECOND,
    speed_before=METRE_PER_SECOND,
    speed_after=METRE_PER_SECOND,
    impulse=NEWTON_SECOND,
    friction_impulse=NEWTON_SECOND,
    work=JOULE,
    mode=("slip", "stick", "reverse"),
)
"""A row of the table of impacts, filled with units: normal velocity, tangential speed, normal
impulse, that of friction, energy that the body gained, and how friction ended. `struck` fills it by
position; the position of a word in `mode` is its number in a store."""


# --- the balls ----------------------------------------------------------------------------------


def rise(x: Moving, b: Touch) -> Any:
    """Return v_n, the vertical velocity of the lowest point of a ball; negative if it falls.

    b is the body seen from this ball.
    """
    return contact_velocity(x, b).z


def horizontal_size(v: Vector) -> Any:
    """Return the length of the horizontal part of a vector, such as the speed of slip."""
    return sqrt(horizontal2(v))


def balls_on_plane(x: Moving, world: Any) -> list[int]:
    """Return the numbers k of the balls whose gap to the plane is zero, but for rounding."""
    return [k for k, b in enumerate(world.body) if contact.gap(x, b) <= ON_PLANE]


def both_rest(x: Moving, world: Any) -> bool:
    """Return whether both balls touch the plane and neither rises nor falls faster than BOTH_AT."""
    slow = (abs(rise(x, b)) < BOTH_AT for b in world.body)
    return len(balls_on_plane(x, world)) > 1 and all(slow)


def first_touch(n: Next, world: Any) -> Next:
    """Return n, changed: Jellett's integral of the ball that touches now becomes its reference.

    The integral is conserved for one ball only, so its drift is counted from the first touch. Rows
    read it as `jellett_taken`.
    """
    x = n.x
    b = world.body[world.phases[n.phase].ball]
    if isinstance(b, Asymmetric):
        return n
    now = contact.jellett_of(x.L.z, dot(x.L, x.u), b)
    lost = getattr(x.carried, "jellett_lost", 0)
    n.x = x._replace(carried=x.carried._replace(jellett_reference=now + lost))
    if series := n.series:  # rows during the jump have the reference too
        n.series = lambda t: (
            (after := series(t))[0],
            after[1]._replace(jellett_reference=now + lost),
        )
    return n


# --- what begins --------------------------------------------------------------------------------


def begin(x: Moving, world: Any) -> Next:
    """Return the phase in which a run begins: a flight, or as after a ball touches.

    It is `System.begin`.
    """
    there = {k: rise(x, world.body[k]) for k in balls_on_plane(x, world)}
    ball = min(there, key=there.__getitem__, default=0)
    if not there or there[ball] > CLOSES_AT:
        return first_touch(fly(x, world, ball, 1, "start"), world)
    return strike(x, world, ball, "start", CLOSES_AT)


def ended(x: Moving, ball: int, cause: str, status: str, message: str) -> Next:
    """Return the end of a run in the state x, with its status and the reason as a sentence.

    It has a phase, although the run ends, because `first_touch` and `opening` read it.
    """
    return Next(phase_name("flight", ball), x, cause, ends=status, message=message)


def fly(x: Moving, world: Any, ball: int, zeros: int, cause: str, others: int = 1) -> Next:
    """Return free flight until the first ball lands.

    `zeros` is the number of derivatives of the gap of `ball`, from the gap itself on, that vanish
    now, and `others` that of the other ball, if it touches too. The run ends if the next one is
    negative, or if all vanish up to the third.
    """
    roots = {}
    for k in balls_on_plane(x, world):
        count = zeros if k == ball else others
        while count < 4 and (rate := gap_rate(x, world, k, count)) == 0:
            count += 1
        if count == 4 or rate < 0:
            return ended(x, ball, cause, "stalled", NO_WAY)
        roots["land" if k == ball else "touch"] = count  # the events of `contact_phases.flight`
    lasts = longest_flight(x, world.body[0])
    return Next(phase_name("flight", ball), x, cause, zeros=roots, lasts=lasts)


def longest_flight(x: Moving, b: Touch) -> Any:
    """Return a time before which a ball lands, however the body turns.

    A step that goes far beyond it would find the landing less exactly.
    """
    v = x.velocity.z
    highest = x.height  # the centre of mass stays above the plane; of a ball, less
    if not b.outline:
        highest = abs(contact.gap(x, b)) + 2 * abs(b.c)  # if the body turns over
    g = mean_gravity(b)
    if b.around and b.around.shake:
        _, c, s, rate = b.around.shake
        # bounds of what vibration adds to the velocity, and to the height either way
        speed = (abs(c) + abs(s)) / rate
        v = abs(v) + speed
        highest = highest + 2 * speed / rate
    return (v + sqrt(v * v + 2 * g * highest)) / g * (1 + 1e-6)


def gap_rate(x: Moving, world: Any, ball: int, order: int) -> Any:
    """Return the first, second or third time derivative of the gap of a ball in flight.

    The second is the vertical acceleration of the contact point without a force there; the third
    is its central difference over `DIFFERENCE`, of which the sign alone is exact.
    """
    b = world.body[ball]
    if order == 1:
        return rise(x, b)
    if order == 2:
        return bias_vector(x, b).z
    flight = world.phases[phase_name("flight", ball)]
    _, _, series = with_constant_rates(x, world, flight)

    def gap_acceleration(time: float) -> Any:
        """Return the acceleration of the gap after a short time."""
        q, carried = series(time)
        later = flight.leave(q, b)._replace(carried=carried)
        return bias_vector(later, present(later, b)).z

    return (gap_acceleration(DIFFERENCE) - gap_acceleration(-DIFFERENCE)) / (2 * DIFFERENCE)


def on_plane(x: Moving, world: Any, ball: int, cause: str, zeros: int = 1) -> Next:
    """Return the phase after a ball touches the plane without rising.

    The body slides, rolls or leaves. If the other ball touches too, it leaves, and its gap has a
    root of multiplicity `zeros`.
    """
    b = world.body[ball]
    law = b.friction
    roots = {"touch": zeros} if len(balls_on_plane(x, world)) > 1 else {}
    if not law.set_valued or horizontal_size(contact_velocity(x, b)) > STOPS_AT:
        name = phase_name("slip", ball, *regions_of(x, b))
        phase = world.phases[name]
        if phase.reaction(phase.enter(x, b), b).force.z > 0:
            return on_disc(Next(name, x, cause, zeros=roots), world)
    else:
        # v_A, at most STOPS_AT, becomes exactly 0: as in `slide_on`
        x = x._replace(velocity=contact.centre_velocity(x, times(0, x.u), b))
        F = resting(x, b)[0]
        if F.z > 0 and cone(F, b) >= 0:
            return Next(phase_name("roll", ball), x, cause, zeros=roots)
        against = (atan2(-F.y, -F.x),) if F.z > 0 else ()
        slides = world.phases[phase_name("slip", ball)]
        for beta in (*first_directions(partial(pushed, slides, *plain((x, b)))), *against):
            # the first is taken; `against` is for the edge of the cone, if no other is found
            return slide(x, world, ball, beta, cause) or on_edge(x, ball, cause, roots)
    return fly(x, world, ball, 2, "opens-at-once", zeros)


def on_edge(x: Moving, ball: int, cause: str, roots: Any = ()) -> Next:
    """Return rolling on the edge of the friction cone, where only rounding makes it slide.

    `roots` are event functions of the phase that are zero now, and their multiplicity.
    """
    return Next(phase_name("roll", ball), x, cause, zeros={**dict(roots), CONE.name: 1})


def rest_on_both(x: Moving, world: Any, cause: str) -> Next:
    """Return the phase after both balls touch and neither rises.

    The body stays on both if both press on the plane, or on the one from which the other rises.
    """
    b = world.body[0]
    law = b.friction
    if not law.set_valued:
        x = brought_to_rest(x, frictions_of(law, regions_of(x, *world.body)), b)
        name = phase_name("both", 0, *regions_of(x, *world.body))  # of the changed x
        phase = world.phases[name]
        s = phase.form.scalars(phase.enter(x, b), b)
        if min(side.force.z for side in s.sides) > PRESSES * b.m * mean_gravity(b):
            return Next(name, x, cause)
    for ball in (0, 1):
        n = on_plane(x, world, ball, cause, 2)
        if not n.ends and opening(n, world) > 0:
            return n
    return ended(x, 0, cause, "ended", BOTH if law.set_valued else NO_WAY)


def opening(n: Next, world: Any) -> Any:
    """Return I1 times the second derivative of the other ball's gap at the start of the phase of n.

    The gap is `contact_phases.other_gap`, and z' = (L x 3hat)_z/I1. The other ball touches too, so
    it leaves the plane if the result is positive. In flight the result is infinite.
    """
    phase = world.phases[n.phase]
    if phase.label == "flight":
        return math.inf
    x = n.x
    b = world.body[phase.ball]
    rate = contact.turning(phase.form.rates(phase.enter(x, b), b))
    return b.lever * plus(cross(rate.L, x.u), cross(x.L, rate.u)).z


# --- impacts ------------------------------------------------------------------------------------


def strike(x: Moving, world: Any, ball: int, cause: str, least: float = 0.0) -> Next:
    """Return the phase after an impact of a ball, if it falls by more than `least`.

    The other ball strikes too if it is pressed into the plane, and so on, MOST_STRIKES times at
    most. Each impact is an event in the log and a row of the table of impacts, in the same order.
    """
    hits: list[Any] = []
    makes_energy = False
    other = ball
    pressed = rise(x, world.body[ball]) < -least and not both_rest(x, world)
    while pressed and not makes_energy and len(hits) < MOST_STRIKES:
        ball = other
        other = 1 - other
        x, hit, makes_energy = struck(x, world, ball)
        hits.append(hit)
        pressed = other in balls_on_plane(x, world) and rise(x, world.body[other]) < -CLOSES_AT
    if makes_energy:
        n = ended(x, ball, cause, "ended", MAKES_ENERGY)
    elif pressed:
        n = ended(x, ball, cause, "stalled", NO_WAY)
    elif hits and hits[-1].v_n_after > 0:
        n = fly(x, world, ball, 1, cause)
    elif both_rest(x, world):
        n = rest_on_both(x, world, cause)
    else:
        n = on_plane(x, world, ball, cause)
    n.logged = ("impact",) * len(hits)
    n.rows = {"impacts": tuple(hits)}
    return first_touch(n, world)


def struck(x: Moving, world: Any, ball: int) -> tuple[Moving, Any, bool]:
    """Return the state after an impact of a ball, its row for the table of impacts, and a flag.

    The flag is true if the impact made energy. Raises ArithmeticError if it has no solution, with
    which the run ends as stalled (see `form.Exit`).
    """
    b = world.body[ball]
    e_n = 0.0 if abs(rise(x, b)) < CLOSES_AT else world.rules.e_n
    v = contact_velocity(x, b)
    impact = world.struck(x, b, e_n)  # an `engine.impacts.Impact`
    p = impact.p
    x = kicked(x, b, p, impact.twist)
    after = contact_velocity(x, b)
    if e_n == 0:  # it does not rise by rounding
        x = x._replace(velocity=x.velocity._replace(z=x.velocity.z - after.z))
        after = after._replace(z=0.0)
    slides = (horizontal_size(v), horizontal_size(after))
    mode = IMPACT.mode.index(impact.mode)
    hit = type(IMPACT)(ball, v.z, after.z, *slides, p.z, horizontal_size(p), impact.gained, mode)
    return x, hit, impact.makes_energy


# --- slides that begin and end ------------------------------------------------------------------


def pushed(phase: Phase, x: Moving, b: Touch, beta: Any) -> tuple[Any, Any, Any]:
    """Return P, Q and the normal force of sliding in the direction beta.

    P = w' is the rate of the sliding speed w, Q = w beta'; they are computed at w = 1, so that
    beta' is Q. The state is that of `contact_phases.coulomb_slip`, filled by position.
    `first_directions` takes this function of beta, for all angles of a grid at once.
    """
    units = phase.form.units
    q = type(units)(*x.u, *x.L, beta, 1 + 0 * beta, *joined_values(units, x.carried))
    rates = phase.form.rates(q, b)
    return rates.w, rates.beta, phase.reaction(q, b).force.z


def with_constant_rates(x: Moving, world: Any, phase: Phase) -> tuple[Any, Any, Callable]:
    """Return the state of a phase at x, its rates, and series(t) with constant rates, of a Next."""
    b = world.body[phase.ball]
    q = phase.enter(x, b)
    rates = phase.form.rates(q, b)
    carried = world.rates(phase, q, x.carried)

    def moved(record: Any, rates: Any, time: Any) -> Any:
        """Return a record after a short time, each field being value + time rate."""
        return record._make(value + time * rate for value, rate in zip(record, rates, strict=True))

    return q, rates, lambda t: (moved(q, rates, t), moved(x.carried, carried, t))


def eighty_bits(value: Any) -> Any:
    """Return a number of any precision as a numpy longdouble."""
    high = float(value)
    return np.longdouble(high) + float(value - high)


def widened(record: Any) -> Any:
    """Return a record of records with all numbers as numpy longdoubles."""
    return refill(record, map(eighty_bits, leaves(record)))


SLOWEST = eighty_bits(1e-300)
"""Speed of a slide from rest on a table, which turns its direction as the forces at rest do."""


def slide(x: Moving, world: Any, ball: int, beta: Any, cause: str, w: Any = 0) -> Next | None:
    """Return the slow slide of a body with the speed w, or from rest, in the direction beta.

    It is a series, computed with numbers of 80 bits; None if nothing begins to slide. Where it ends
    slow, the phase ends immediately, by its exit `CLOCK`.
    """
    if has_derivatives((x, world.body, (w,))):
        return slide_of_duals(x, world, ball, beta, cause, w)
    name = phase_name("slip", ball)
    number = type(world.left)
    phase = world.phases[name]
    wide = world._replace(body=widened(world.body))
    x = widened(x)
    b = wide.body[ball]
    units = phase.form.units
    first = len(x.u) + len(x.L)  # index of the integrals in the numbers of the series

    def read(values: Any) -> tuple[Any, Any]:
        """Return the state q of the slip and the record of integrals, by numbers of the series.

        `first_slip` requires w and beta at the end of these; the state has beta, w, then copies.
        """
        *moved, w, beta = values
        carried = x.carried._make(moved[first:])
        return type(units)(*moved[:first], beta, w, *joined_values(units, carried)), carried

    def rates(world: Any, *values: Any) -> list:
        """Return the rates of the numbers of the series, in the order of `start`: at the end w', Q.

        The slide is found with the direction beta as the unknown: where w = 0, beta' = 0/0.
        """
        q, carried = read(values)
        b = world.body[ball]
        speed = np.maximum(q.w, SLOWEST)
        by = phase.form.rates(q._replace(w=speed), b)
        return [*by[:first], *world.rates(phase, q, carried), by.w, by.beta * speed]

    omega = contact.angular_velocity(x, b)
    weight = b.m * mean_gravity(b)
    span = min(SPAN / sqrt(dot(omega, omega)), SLOW * sqrt(b.I1 / (weight * contact.size(b))))

    def lasts(end: np.ndarray) -> bool:
        """Return whether the ball still presses on the plane, and the other one is above it."""
        q, _ = read(end)
        # the gap is `contact_phases.other_gap`, of which a change is a change here
        return bool(phase.reaction(q, b).force.z > 0 and b.clearance + b.lever * q.uz > 0)

    # axis, L, integrals, w, beta: the order that `read` and `rates` have
    start = np.array([*x.u, *x.L, *x.carried, eighty_bits(w), eighty_bits(beta)])
    slides = first_slip(wide.repeated((phase, type(x.carried)), rates), start, span, lasts)
    if slides is None:
        return None
    duration, at, is_slow = slides
    delay = number(min(duration, eighty_bits(world.left)))

    def series(time: Any) -> tuple[Any, Any]:
        """Return the records of the state and the integrals at a time since the slide's start."""
        return read(at(eighty_bits(time)))

    q, carried = (record._make(map(number, record)) for record in series(delay))
    end = phase.leave(q, world.body[ball])._replace(carried=carried)
    return Next(name, end, cause, delay, series, lasts=0 if is_slow else math.inf)


STEPS = -2, -1, 1, 2
WEIGHTS = np.array([1, -8, 8, -1]) / np.longdouble(12)
MOVE = 3e-5
"""Points of a difference, their weights, and their distance, relative to the largest derivative.

Its error is the fourth power, and that of rounding small where derivatives by time cancel.
"""


def slide_of_duals(x: Moving, world: Any, ball: int, beta: Any, cause: str, w: Any) -> Next | None:
    """Return a slow slide whose numbers have derivatives, as `slide`.

    The slide is repeated for numbers moved along their derivatives; differences give those of its
    end and of its duration.
    """
    given = x, world.body, (w,)
    wide = np.array([*map(eighty_bits, leaves(plain(given)))])
    way = np.array([parts_of(one, 1)[1] for one in leaves(given)], np.longdouble)
    size = MOVE / max(*abs(way), 1e-300)

    def begun(steps: int) -> Any:
        """Return the slide of moved numbers, with a duration and an end of 80 bits, or None."""
        x, body, (w,) = refill(given, iter(wide + steps * size * way))
        there = world._replace(body=body, left=eighty_bits(plain(world.left)))
        return slide(x, there, ball, plain(beta), cause, w)

    known, *others = map(begun, (0, *STEPS))
    if known is None:
        return None
    if None in others:
        raise ArithmeticError("a slow slide has no derivative")
    end, *ends = np.array([[n.delay, *leaves(n.x)] for n in (known, *others)])
    by = np.dot(WEIGHTS, ends) / size
    delay, *after = map(Dual, end.astype(float), by.astype(float))
    return replace(known, x=refill(known.x, iter(after)), delay=delay)


# --- exits of the phases ------------------------------------------------------------------------


def lift_off(x: Moving, world: Any) -> Next:
    """Return the flight after the normal force has vanished: the gap has a triple root."""
    return replace(fly(x, world, world.phase.ball, 3, "liftoff"), logged=("liftoff",))


def land(x: Moving, world: Any) -> Next:
    """Return the phase after a ball touches the plane.

    After a flight, of the balls on the plane, the one that falls fastest strikes.
    """
    if world.phase.label != "flight":
        return strike(x, world, 1 - world.phase.ball, "other-ball")
    # rounding may leave no ball on the plane: then the nearest one
    there = balls_on_plane(x, world) or [
        min(range(len(world.body)), key=lambda k: contact.gap(x, world.body[k]))
    ]
    return strike(x, world, min(there, key=lambda k: rise(x, world.body[k])), "landing")


def stay_on(x: Moving, world: Any, ball: int) -> Next:
    """Return the phase after one of two balls leaves the plane and `ball` stays.

    The gap of the leaving ball has a triple root if its load has just passed zero, and a double one
    if that load was negative from the start of the phase.
    """
    n = on_plane(x, world, ball, "other-leaves", 2)
    rises = opening(n, world)
    if rises < -CLOSES_AT:
        return ended(x, ball, "other-leaves", "ended", NO_WAY)
    if rises < CLOSES_AT:
        n.zeros = {**n.zeros, "touch": 3}
    return first_touch(n, world)


def stick(x: Moving, world: Any) -> Next:
    """Return the slip that goes on, without sliding, to the instant of rest just ahead.

    The event happens at the speed `STOPS_AT`; from there the rates are constant. `slide_on` then
    decides what follows.
    """
    phase = world.phase
    q, rates, series = with_constant_rates(x, world, phase)
    delay = -q.w / rates.w
    q_end, carried_end = series(delay)
    x = phase.leave(q_end, world.body[phase.ball])._replace(carried=carried_end)
    return Next(phase_name("slip", phase.ball), x, "", delay, series, lasts=0)


def slide_on(x: Moving, world: Any) -> Next:
    """Return the phase after a part of a slow slide: the next part, or what follows its end."""
    ball = world.phase.ball
    b = world.body[ball]
    v = contact_velocity(x, b)
    if horizontal_size(v) > STOPS_AT and (
        n := slide(x, world, ball, atan2(v.y, v.x), "", horizontal_size(v))
    ):
        return n
    x = x._replace(velocity=contact.centre_velocity(x, times(0, x.u), b))
    n = on_plane(x, world, ball, "stick")
    n.logged = ("stick" if world.phases[n.phase].label == "roll" else "reversal",)
    return n


def begin_slip(x: Moving, world: Any) -> Next:
    """Return the slip after rolling needs more friction than the law allows, |F_h| > mu N."""
    ball = world.phase.ball
    F = resting(x, world.body[ball])[0]
    n = slide(x, world, ball, atan2(-F.y, -F.x), "slip")
    return replace(n, logged=("slip",)) if n else on_edge(x, ball, "")


def go_on(x: Moving, world: Any, to: str, passed: str) -> Next:
    """Return the phase `to` after sliding has left a region of its law, or rest if it has stopped.

    `passed` is the event function of `to` with a root here. Where `to` is the present phase, which
    passes its rest, the function (that of RESTS) is negative from here on; `on_disc` reads it.
    """
    sides = {passed: -1} if world.phases[to] is world.phase else {}
    n = on_disc(Next(to, x, "", zeros={passed: 1}, sides=sides), world)
    n.logged = ("stick",) if n.cause == "rests" else ()
    return n


def roll_on_both(n: Next, world: Any) -> Next:
    """Return the phase after both contacts have stopped sliding and turning.

    The body rolls on both if friction can give the force; otherwise `n`, in which it passes its
    rest.
    """
    b = world.body[0]
    x = without_slip_on_both(n.x, b)
    F = rolled(x, b)[0]
    return (
        Next(phase_name("both", 0, "roll"), x, "rests")
        if horizontal_size(F) < b.friction.mu * F.z
        else n
    )


def give_way(x: Moving, world: Any) -> Next:
    """Return the phase after friction can no longer hold a disc at rest."""
    return replace(slide_from_rest(x, world, world.phase.ball, "gives"), logged=("slip",))


def on_disc(n: Next, world: Any) -> Next:
    """Return the next phase `n`, corrected under a law with regions.

    Event functions that begin beyond their zero are marked in `n.sides`; signs that are there
    already stay. If sliding and turning have stopped together, which the mark of RESTS shows, the
    disc rests, passes its rest, or begins to slide.
    """
    phase = world.phases[n.phase]
    b = world.body[phase.ball]
    if not b.friction.regions:
        return n
    s = phase.form.scalars(phase.enter(n.x, b), b)
    for event in phase.events:
        if event.name not in n.zeros and event.direction * event.formula(s, b) > 0:
            n.sides = {event.name: event.direction, **n.sides}
    if RESTS.name not in n.sides:
        return n
    return roll_on_both(n, world) if phase.label == "both" else at_rest(n, world)


def at_rest(n: Next, world: Any) -> Next:
    """Return the phase after sliding and turning of a disc have stopped together.

    A disc that friction cannot hold passes its rest if it soon leaves it again; otherwise it begins
    to slide with a small speed, so that its next rest is detected.
    """
    ball = world.phases[n.phase].ball
    b = world.body[ball]
    x = kicked(n.x, b, *stopping(n.x, b))
    F, torque = resting(x, b)
    left = margin(F, torque.z, b.friction)
    others = n.zeros if n.cause else {}  # without a cause, they belong to the phase that ends
    if left > 0:
        return Next(phase_name("rest", ball), x, n.cause or "rests", zeros=others)
    limit = b.friction.mu * F.z
    # acceleration of the contact per force, or of the disc's edge per torque/patch; friction lacks
    # -left * limit of these, for a time that is in proportion to `left` too
    gains = 1 / b.m if horizontal_size(F) > limit else b.friction.patch**2 / turn_held(x.u, b)[1]
    if sqrt(rest_speed2(b)) < SOON * left**2 * limit * gains:
        return n
    return slide_from_rest(x, world, ball, n.cause or "gives", others)


def slide_from_rest(x: Moving, world: Any, ball: int, cause: str, zeros: Any = ()) -> Next:
    """Return the phase in which a disc at rest that friction cannot hold begins to slide.

    Impulses give it twice the speed below which it rests.
    """
    b = world.body[ball]
    F, torque = resting(x, b)
    v, edge = direction(F, torque.z, b.friction)
    speed = 2 * sqrt(rest_speed2(b))
    x = kicked(x, b, *impulses(x.u, times(speed, v), speed * edge / b.friction.patch, b))
    name = phase_name("slip", ball, *regions_of(x, b))
    return on_disc(Next(name, x, cause, zeros=dict(zeros)), world)


JUMPS: Mapping[str, Callable] = {
    "liftoff": lift_off,
    **dict.fromkeys(("land", "touch", CLOCK), land),
    "stick": stick,
    "slip": begin_slip,
    "gives": give_way,
    "sphere-leaves": partial(stay_on, ball=1),
    "stem-leaves": partial(stay_on, ball=0),
}
"""The jumps after the events that end phases, by name of the event. For events after which the same
phase may go on, `opening.phases_of` adds `go_on` and `slide_on`.
"""

REASONS = (
    "start",
    "stick",
    "slip",
    "liftoff",
    "landing",
    "other-ball",
    "opens-at-once",
    "other-leaves",
    "rests",
    "gives",
)
"""Causes of phases; the position of a word is its number in a store."""

"""Every jump of a body whose contact may open: what follows the end of a phase, as a function of
the common state.

`world` is that of `form.Exit`, of which `body` is the body seen from each ball. [contact 2, 3, 4,
6]
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..form import CLOCK, Next
from ..friction import Law, named
from ..operand import Vector, cross, dot, plus, sqrt, times
from . import body as contact
from .body import Touch, contact_velocity
from .coulomb import cone, reaction_of_rolling_vector, slip_motion
from .double_contact import brought_to_rest, double_contact, jellett_lost, turn_on
from .first_slip import FirstSlip, first_directions, first_slip
from .response import bias_vector, jumps, mobility_inverse_times
from .single_contact import RESTS, STOPS_AT, region_of, stays_at_rest
from .state import LOST, Moving


BEGINS_AT = 1e-8
"""|v_A| with which sliding begins from rest outside the friction cone; its square is the error."""

CLOSES_AT = 1e-8
"""v_n below which an impact does not bounce: the error is its square."""

ON_PLANE = 1e-12
"""Gap of a ball that touches."""

BOTH_AT = 1e-6
"""v_n of both balls below which the body is on them; impulses take it: the error is its square."""

PRESSES = 1e-12
"""Least part of the weight that a ball carries."""

LEAVES_FOR = 1e-3
"""Internal time in which a ball that leaves cannot touch: its gap has a multiple root."""

ASKED_AFTER = 3e-3
"""Internal time after which a disc that passes its rest may be held by friction after all."""

MOST_STRIKES = 16
"""Impacts at one instant."""

SPAN, SLOW = 0.03, 0.5
"""Time over which sliding begins at the edge of the cone: this part of 1/|omega|, and at most that of
the time in which gravity swings the body."""

MOST_HALVINGS = 10

NO_WAY = "the contact opens and closes at once: the model has no solution"
MAKES_ENERGY = 'restitution = "newton" made energy in an impact, which no impact does: use "energetic"'
BOTH = "the body stands on its sphere and its stem at once, which is not followed under Coulomb's law itself"
AT_REST = "the contact's disc comes to rest, where friction can hold it; rolling without turning is not followed"


class Impact(NamedTuple):
    """A row of the table of impacts, internal units."""

    ball: Any
    v_n_before: Any  # normal velocity
    v_n_after: Any
    speed_before: Any  # tangential speed
    speed_after: Any
    impulse: Any  # normal
    friction_impulse: Any
    work: Any  # energy that the body gained
    mode: Any  # how friction ended


# --- the balls ------------------------------------------------------------------------------------


def phase_name(label: str, ball: int = 0, *regions: str) -> str:
    """Return the name of a phase, by its label, the ball and the regions of the law on each ball in
    contact."""
    return "-".join((*("stem",) * ball, label, *regions))


def law_of(world: Any) -> Law:
    """Return the law of the contact."""
    known = named(type(world.body[0].friction), world.system.laws)
    assert known is not None
    return known[1]


def point(x: Moving, b: Touch) -> Vector:
    """Return the velocity of the lowest point of a ball."""
    return contact_velocity(x.u, x.L, x.velocity, b)


def gap(x: Moving, b: Touch) -> float:
    """Return the height of a ball above the plane."""
    return float(contact.gap(x.height, x.u.z, b))


def size(v: Vector) -> Any:
    """Return the length of the horizontal part of a vector."""
    return sqrt(v.x * v.x + v.y * v.y)


def gained(x: Moving, **integrals: Any) -> Moving:
    """Return the state with more of some integrals."""
    more = {name: getattr(x.carried, name) + value for name, value in integrals.items()}
    return x._replace(carried=x.carried._replace(**more))


def first_touch(n: Next, world: Any) -> Next:
    """Return what follows where a ball comes into contact: from here on Jellett's integral is
    compared with its."""
    x = n.x
    now = contact.jellett_of(x.L.z, dot(x.L, x.u), world.body[world.phases[n.phase].ball])
    lost = getattr(x.carried, LOST[0], 0)
    n.x = x._replace(carried=x.carried._replace(jellett_reference=now + lost))
    return n


# --- what begins ----------------------------------------------------------------------------------


def begin(x: Moving, world: Any) -> Next:
    """Return the phase in which a run begins."""
    balls = range(len(world.body))
    touching = [k for k in balls if gap(x, world.body[k]) <= ON_PLANE]
    if not touching:
        return first_touch(fly(x, world, 0, 0, cause="start"), world)
    v_n = {k: float(point(x, world.body[k]).z) for k in touching}
    falls = min(touching, key=v_n.__getitem__)
    rests = [k for k in touching if v_n[k] <= CLOSES_AT]
    if v_n[falls] < -CLOSES_AT:
        n = strike(x, world, falls, "start")
    elif not rests:
        n = fly(x, world, falls, 1, cause="start")
    elif len(rests) == 2:
        n = rest_on_both(x, world, "start")
    else:
        n = on_plane(x, world, falls, "start")
    return first_touch(n, world)


def fly(x: Moving, world: Any, ball: int, zeros: int, **more: Any) -> Next:
    """Return free flight until the first ball lands; `zeros` of the gap of a ball and its
    derivatives vanish now."""
    gaps = [contact.gap(x.height, x.u.z, b) for b in world.body]
    known = [zeros if k == ball else int(float(gap) <= ON_PLANE) for k, gap in enumerate(gaps)]
    lasts = min(world.landing(x, *ball) for ball in zip(gaps, world.body, known, strict=True))
    ends = ("", "") if lasts > 0 else ("stalled", NO_WAY)
    return Next(phase_name("flight", ball), x, lasts=lasts, ends=ends[0], message=ends[1], **more)


def on_plane(x: Moving, world: Any, ball: int, cause: str) -> Next:
    """Return what follows where a ball touches the plane and its lowest point does not rise: the
    body slides, rolls or leaves."""
    b, law = world.body[ball], law_of(world)
    if not law.set_valued or size(point(x, b)) > STOPS_AT:
        name = phase_name("slip", ball, *((region_of(x, b, law.regions),) if law.regions else ()))
        phase = world.phases[name]
        if phase.reaction(phase.enter(x, b), b).force.z > 0:
            return on_disc(Next(name, x, cause, zeros=other_touches(x, world, ball)), world)
        return fly(x, world, ball, 2, cause="opens-at-once")
    none = 0 * b.m
    x = x._replace(velocity=contact.centre_velocity(x.u, x.L, Vector(none, none, none), b))
    F = reaction_of_rolling_vector(x.u, bias_vector(x.u, x.L, b), b)
    if F.z > 0 and cone(F.x, F.y, F.z, b.friction.mu) >= 0:
        return Next(phase_name("roll", ball), x, cause, zeros=other_touches(x, world, ball))
    n = first_direction(x, b)
    if n is None:
        return fly(x, world, ball, 2, cause="opens-at-once")
    n = Vector(np.sign(n.x), none, none) if world.system.opening.planar else n
    x, delay = run_in(x, world, ball, n)
    return Next(phase_name("slip", ball), x, cause, delay, zeros=other_touches(x, world, ball))


def other_touches(x: Moving, world: Any, ball: int) -> dict[str, int]:
    """Return the root of `touch` where the other ball is on the plane too, and leaves it."""
    others = (b for k, b in enumerate(world.body) if k != ball)
    return {"touch": 1} if any(gap(x, b) <= ON_PLANE for b in others) else {}


def rest_on_both(x: Moving, world: Any, cause: str) -> Next:
    """Return what follows where both balls touch and neither rises: the body stays on both, if both
    press, or on the one that does."""
    law, b = law_of(world), world.body[0]
    if not law.set_valued:
        regions = tuple(region_of(x, ball, law.regions) for ball in world.body if law.regions)
        sides = double_contact(tuple(law.regions[name] for name in regions), law.torque).sides
        name = phase_name("both", 0, *regions)
        after, both, p = brought_to_rest(x, sides, b)
        mean = times(
            0.5,
            plus(contact.angular_velocity(x.u, x.L, b), contact.angular_velocity(x.u, after.L, b)),
        )
        work = dot(p, times(0.5, plus(x.velocity, after.velocity))) + dot(turn_on(both), mean)
        x = gained(after, work=-work, impulse=p.z)
        if law.regions:
            x = gained(x, jellett_lost=jellett_lost(both))
        x = x._replace(velocity=x.velocity._replace(z=0 * p.z))
        phase = world.phases[name]
        s = phase.form.scalars(phase.enter(x, b), b)
        if min(s.force, s.stem_force) > PRESSES * b.m * b.g:
            return first_touch(Next(name, x, cause), world)
    for ball in (0, 1):
        n = on_plane(x, world, ball, cause)
        flies = world.phases[n.phase].label == "flight"
        if flies or opens(n, world):
            return first_touch(n if flies else left_alone(n, 2), world)
    message = BOTH if law.set_valued else NO_WAY
    return Next(phase_name("flight"), x, cause, ends="ended", message=message)


def opens(n: Next, world: Any) -> bool:
    """Return whether the other ball, which touches too, leaves the plane in a phase that begins: by
    its gap''."""
    phase = world.phases[n.phase]
    b = world.body[phase.ball]
    x, rate = n.x, phase.form.rates(phase.enter(n.x, b), b)
    turned = plus(cross(Vector(*rate[3:6]), x.u), cross(x.L, Vector(*rate[:3])))
    return bool((world.body[1 - phase.ball].c - b.c) * turned.z > 0)


def left_alone(n: Next, zeros: int) -> Next:
    """Return a phase on one ball where the other has just left: its gap and so many derivatives in
    all vanish."""
    if n.lasts is None or zeros == 3:
        n.zeros, n.lasts = {**n.zeros, "touch": zeros}, LEAVES_FOR
    return n


# --- impacts --------------------------------------------------------------------------------------


def strike(x: Moving, world: Any, ball: int, cause: str) -> Next:
    """Return what follows an impact of a ball, and of the other one, should that be pressed into
    the plane."""
    if both_touch(x, world):
        return rest_on_both(x, world, cause)
    if not point(x, world.body[ball]).z < 0:  # it touches without striking
        return on_plane(x, world, ball, cause)
    hits: list[Impact] = []
    n = Next(phase_name("flight", ball), x, cause, ends="stalled", message=NO_WAY)
    while len(hits) < MOST_STRIKES:
        x, hit, plastic, makes_energy = struck(x, world, ball)
        hits.append(hit)
        others = [k for k in range(len(world.body)) if k != ball]
        there = [k for k in others if gap(x, world.body[k]) <= ON_PLANE]
        pressed = [k for k in there if point(x, world.body[k]).z < -CLOSES_AT]
        if makes_energy:
            n = Next(phase_name("flight", ball), x, cause, ends="ended", message=MAKES_ENERGY)
        elif pressed:
            ball = pressed[0]
            continue
        elif not plastic:
            n = fly(x, world, ball, 1, cause=cause)
        elif both_touch(x, world):
            n = rest_on_both(x, world, cause)
        else:
            n = on_plane(x, world, ball, cause)
        break
    n.logged, n.rows = ("impact",) * len(hits), {"impacts": tuple(hits)}
    return first_touch(n, world)


def both_touch(x: Moving, world: Any) -> bool:
    """Return whether both balls touch the plane, and neither moves up or down."""
    return len(world.body) > 1 and all(
        gap(x, b) <= ON_PLANE and abs(float(point(x, b).z)) < BOTH_AT for b in world.body
    )


def struck(x: Moving, world: Any, ball: int) -> tuple[Moving, Impact, bool, bool]:
    """Return the body after an impact of a ball, the row of the impact, whether the ball stays on
    the plane, and whether the impact made energy. Raises ArithmeticError if it has no solution."""
    b, e_n = world.body[ball], world.rules.e_n
    closes = abs(float(point(x, b).z)) < CLOSES_AT
    plastic = closes or e_n == 0
    v, impact, after = world.struck(x, b, 0.0 if closes else e_n)
    lost = {LOST[0]: impact.twist * contact.arm(x.u, b).z} if hasattr(impact, "twist") else {}
    x = gained(x, work=-after.gained, impulse=after.p.z, **lost)
    velocity = after.velocity
    if plastic:
        velocity = velocity._replace(z=velocity.z - after.v.z)  # it does not rise by rounding
    v_n = float(v.z), 0.0 if plastic else float(after.v.z)
    speeds = float(size(v)), float(size(after.v))
    hit = Impact(
        ball,
        *v_n,
        *speeds,
        float(after.p.z),
        float(size(after.p)),
        float(after.gained),
        impact.mode,
    )
    return x._replace(L=after.L, velocity=velocity), hit, plastic, impact.makes_energy


# --- slides that begin and end --------------------------------------------------------------------


def first_direction(x: Moving, b: Touch) -> Vector | None:
    """Return the direction in which a contact at rest begins to slide, whose rolling force lies
    outside the friction cone; None if there is none."""

    def law(beta: np.ndarray) -> tuple[Any, Any, Any]:
        F, P, Q = slip_motion(x.u, x.L, Vector(np.cos(beta), np.sin(beta), 0 * beta), b)
        return P, Q, F.z

    angles = first_directions(law)
    return Vector(np.cos(angles[0]), np.sin(angles[0]), 0 * x.u.z) if len(angles) else None


def later(x: Moving, q: Any, world: Any, phase: Any, time: Any) -> Any:
    """Return the integrals after a time so short that their rates in a phase stay."""
    return moved(x.carried, world.rates(phase, q, x.carried), time)


def moved(record: Any, rates: Any, time: Any) -> Any:
    """Return a record after a time in which its rates stay."""
    return record._make(value + time * rate for value, rate in zip(record, rates, strict=True))


def run_in(x: Moving, world: Any, ball: int, n: Vector) -> tuple[Moving, Any]:
    """Return the first of a slide along n from rest, so short that its rates stay; and the time
    that it takes."""
    phase, b = world.phases[phase_name("slip", ball)], world.body[ball]
    F, P, _ = slip_motion(x.u, x.L, n, b)
    speed = min(type(P)(BEGINS_AT), P * world.left)
    delay = speed / P
    u = plus(x.u, times(delay, contact.axis_rate(x.u, x.L, b)))
    L = plus(x.L, times(delay, cross(contact.arm(x.u, b), F)))
    end = Moving(u, L, contact.centre_velocity(u, L, times(speed, n), b), contact.height(u.z, b))
    return end._replace(carried=later(x, phase.enter(end, b), world, phase, delay)), delay


def run_out(x: Moving, world: Any, v: Vector) -> tuple[Moving, Any]:
    """Return the last of a slide, which is so slow that its rates stay; and the time that it
    takes."""
    phase, b, w = world.phase, world.body[world.phase.ball], size(v)
    _, P, _ = slip_motion(x.u, x.L, Vector(v.x / w, v.y / w, 0 * w), b)
    delay, q = -w / P, phase.enter(x, b)
    end = phase.leave(moved(q, phase.form.rates(q, b), delay), b)
    x = end._replace(carried=later(x, q, world, phase, delay))
    v = point(x, b)
    p = mobility_inverse_times(x.u, times(-1, v), b)  # of rounding
    pushed, turned = jumps(x.u, p, b)
    x = x._replace(velocity=plus(x.velocity, pushed), L=plus(x.L, turned))
    return gained(x, work=-(dot(p, v) / 2)), delay


class Slide(NamedTuple):
    """The first moments of a slide, as a series."""

    first: FirstSlip
    sliding: Callable  # sliding(u, L, w, beta, b) -> the state of its phase
    b: Touch
    carried: Any

    def at(self, t: np.ndarray) -> tuple[Any, Any]:
        """Return the states and the integrals at times (n,) since its beginning."""
        state, w, beta = self.first.at(t)
        reference = self.carried.jellett_reference + 0 * w
        carried = self.carried._make(state[6:])._replace(jellett_reference=reference)
        return self.sliding(Vector(*state[:3]), Vector(*state[3:6]), w, beta, self.b), carried


def slide_from_cone(x: Moving, world: Any, phase: Any, sliding: Callable) -> Slide:
    """Return the first moments of a slide that begins at the edge of the friction cone."""
    b = world.body[phase.ball]

    def rates(state: np.ndarray, w: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, Any, Any]:
        u, L = Vector(*state[:3]), Vector(*state[3:6])
        F, P, Q = slip_motion(u, L, Vector(np.cos(beta), np.sin(beta), 0 * beta), b)
        more = world.rates(phase, sliding(u, L, w, beta, b), x.carried._make(state[6:]))
        moved = (*contact.axis_rate(u, L, b), *cross(contact.arm(u, b), F), *more)
        return np.array([np.broadcast_to(rate, w.shape) for rate in moved]), P, Q

    def turning(state: np.ndarray, beta: np.ndarray) -> Any:
        n = Vector(np.cos(beta), np.sin(beta), 0 * beta)
        return slip_motion(Vector(*state[:3]), Vector(*state[3:6]), n, b)[2]

    F = reaction_of_rolling_vector(x.u, bias_vector(x.u, x.L, b), b)
    omega = contact.angular_velocity(x.u, x.L, b)
    swing = sqrt(b.I1 / (b.m * b.g * b.R))
    span = min(SPAN / sqrt(dot(omega, omega)), SLOW * swing)
    state = np.array([*x.u, *x.L, *x.carried])
    for _ in range(MOST_HALVINGS):  # short enough for nothing else to happen to the contact
        first = first_slip(rates, turning, state, np.arctan2(-F.y, -F.x), span)
        slide = Slide(first, sliding, b, x.carried)
        q = slide.at(first.time[-1:])[0]
        if phase.reaction(q, b).force.z > 0 and b.clearance + b.lever * phase.leave(q, b).u.z > 0:
            break
        span = span / 2
    return slide


# --- exits of the phases --------------------------------------------------------------------------


def lift_off(x: Moving, world: Any) -> Next:
    """Return what follows where the normal force vanishes."""
    return fly(x, world, world.phase.ball, 3, cause="liftoff", logged=("liftoff",))


def land(x: Moving, world: Any) -> Next:
    """Return what follows a flight: of the balls on the plane, the one that falls fastest
    strikes."""
    gaps = [gap(x, b) for b in world.body]
    balls = [k for k in range(len(gaps)) if gaps[k] <= max(ON_PLANE, min(gaps))]
    return strike(x, world, min(balls, key=lambda k: float(point(x, world.body[k]).z)), "landing")


def change_ball(x: Moving, world: Any) -> Next:
    """Return what follows where the other ball touches the plane."""
    return strike(x, world, 1 - world.phase.ball, "other-ball")


def stay_on(x: Moving, world: Any, ball: int) -> Next:
    """Return what follows where one of two balls leaves the plane; this one stays."""
    n = on_plane(x, world, ball, "other-leaves")
    return first_touch(n if world.phases[n.phase].label == "flight" else left_alone(n, 3), world)


def stick(x: Moving, world: Any) -> Next:
    """Return what follows where sliding stops."""
    v = point(x, world.body[world.phase.ball])
    delay = 0 * v.x
    if size(v) > 0:
        x, delay = run_out(x, world, v)
    n = on_plane(x, world, world.phase.ball, "stick")
    n.logged = ("stick" if world.phases[n.phase].label == "roll" else "reversal",)
    n.logged_after, n.delay = delay, delay + n.delay
    return n


def begin_slip(x: Moving, world: Any, sliding: Callable) -> Next:
    """Return what follows where rolling needs more friction than there is."""
    name = phase_name("slip", world.phase.ball)
    phase = world.phases[name]
    slide = slide_from_cone(x, world, phase, sliding)
    delay = min(slide.first.time[-1], world.left)
    q, carried = (record._make(v[0] for v in record) for record in slide.at(np.array([delay])))
    x = phase.leave(q, slide.b)._replace(carried=carried)
    return Next(name, x, "slip", delay, slide, ("slip",))


def go_on(x: Moving, world: Any, to: str, passed: str = "", side: int = 0) -> Next:
    """Return the same motion in other words, or in the same: the event function `passed` has its
    root here, and goes to this side of it."""
    sides = {passed: side} if side else {}
    return on_disc(Next(to, x, zeros={passed: 1} if passed else {}, sides=sides), world)


def on_disc(n: Next, world: Any) -> Next:
    """Return a phase that begins, under a law with regions.

    Where sliding and turning stop together the run ends, unless friction cannot hold the disc: then
    it passes its rest and turns on, and may turn back unseen by a step.
    """
    phase = world.phases[n.phase]
    staying = [exit.event for exit in phase.exits if exit.to == (n.phase,) and exit.event != CLOCK]
    if n.ends or not staying:
        return n
    b = world.body[phase.ball]
    s = phase.form.scalars(phase.enter(n.x, b), b)
    for event in phase.events:
        if event.name in staying and event.direction * event.formula(s, b) > 0:
            n.sides = {event.name: event.direction, **n.sides}
    if RESTS.name in n.sides:
        if stays_at_rest(n.x, b):
            n.ends, n.message = "ended", AT_REST
        else:
            n.lasts = ASKED_AFTER
    return n

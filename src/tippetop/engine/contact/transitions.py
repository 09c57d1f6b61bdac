"""What follows the end of a phase: the table of the contact's phases, in one place. [contact 6]"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...mechanics.contact import ball as balls_
from ...mechanics.contact import coulomb
from ...mechanics.contact.ball import Ball
from ...mechanics.contact.first_slip import SPAN, SWEEPS, first_direction, leave_rolling
from ...mechanics.contact.flight import hop
from ...mechanics.contact.landing import first_landing
from ...mechanics.contact.phases.legs import STOPS_AT, Body, Kind
from ...mechanics.contact.struck import struck
from ...mechanics.friction import Frictionless, slip_coefficient
from ...mechanics.operand import Vector, cross, dot, plus, times
from ...mechanics.systems.with_contact import PLANAR, kinds_of
from ...mechanics.variables import INTEGRAL_SCALE
from ...problem import Problem
from ..status import Status
from .legs import Balls
from .smooth_impact import struck_smooth


BEGINS_AT = 1e-8  # |v_A| with which sliding begins from rest outside the friction cone; its square is the error
CLOSES_AT = 1e-8  # v_n below which an impact does not bounce: the error is its square
ON_PLANE = 1e-9  # gap of a ball that touches
MOST_STRIKES = 16  # of impacts at one instant


def _wide(value: Any) -> Any:
    """A number as flights take it: a double, or one of 80 bits."""
    return float(value) if isinstance(value, float) else np.longdouble(value)


def _rate(values: Any, nodes: int) -> np.ndarray:
    """The rate of an integral at nodes: at the first, where a contact is at rest, friction has no power."""
    rates = np.array(np.broadcast_to(values, (nodes,)))
    if nodes > 1 and not np.isfinite(rates[0]):
        rates[0] = 0
    return rates


class Moment(NamedTuple):
    """The body at one moment, internal units: axis, momentum, velocity and height of the centre of mass, integrals."""

    u: Vector
    L: Vector
    velocity: Vector
    height: Any
    carried: np.ndarray


@dataclass
class Strike:
    """An impact, internal units."""

    ball: int
    v_n: tuple[float, float]  # normal velocity before and after
    slide: tuple[float, float]  # tangential speed
    impulse: float  # normal
    friction_impulse: float
    work: float  # energy that the body gained
    mode: str
    plastic: bool  # whether the ball stays on the plane


@dataclass
class Between:
    """The short beginning of a slide that no step makes, at Chebyshev's nodes of its time."""

    q: np.ndarray  # (variables of the state, nodes)
    carried: np.ndarray  # (integrals, nodes)


@dataclass
class Change:
    """A phase that begins."""

    kind: str  # of legs.KINDS
    ball: int
    moment: Moment
    reason: str
    events: tuple[str, ...] = ()  # of the run, that happen now
    signs: dict[str, float] = field(default_factory=dict)  # of event functions that stay as they were
    when: Any = 0  # internal time from the end of the phase before to these events
    lag: Any = 0  # and to the beginning of this one
    landing: Any = None  # internal time to the landing of a flight
    between: Between | None = None  # what passes in the time `lag`
    takes: bool = False  # whether another ball is in contact from now on
    strikes: tuple[Strike, ...] = ()
    ends: Status | None = None


class Transitions:
    """Says what follows a phase.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    """

    def __init__(self, problem: Problem, balls: Balls):
        self.problem, self.balls, self.number = problem, balls, problem.number
        names = problem.variables.names[problem.variables.moving :]
        self.work, self.impulse = names.index("work"), names.index("impulse")
        self.rules, self.kinds = problem.contact, kinds_of(problem.system.name)

    def ball(self, index: int) -> Ball:
        """A ball as the formulas of its contact take it."""
        b: Body = self.balls[index]
        mu = b.friction.mu if self.balls.dry else 0 * b.m
        return Ball(b.m, b.I1, b.I3, b.g, mu, b.c, b.R)

    def gap(self, index: int, moment: Moment) -> Any:
        """Height of a ball above the plane."""
        return balls_.gap(moment.height, moment.u.z, self.ball(index))

    def point(self, index: int, moment: Moment) -> Vector:
        """Velocity of the lowest point of a ball."""
        return balls_.contact_velocity(moment.u, moment.L, moment.velocity, self.ball(index))

    # --- the phases' ends -----------------------------------------------------------------------------------------

    def at_start(self, moment: Moment) -> Change:
        """The phase in which a run begins."""
        gaps = [float(self.gap(k, moment)) for k in range(len(self.balls))]
        touching = [k for k, gap in enumerate(gaps) if gap <= ON_PLANE]
        if not touching:
            return self._flight(0, moment, "start", 0)
        ball = touching[-1]
        v_n = float(self.point(ball, moment).z)
        if v_n < -CLOSES_AT:
            return self._strike(ball, moment, {}, "start")
        if v_n > CLOSES_AT:
            return self._flight(ball, moment, "start", 1)
        return self._on_plane(ball, moment, "start", takes=True)

    def after(self, end: str, kind: str, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """What follows a phase.

        Parameters
        ----------
        end
            The event that ended it: stick, slip, liftoff, touch, landing.
        kind, ball
            The phase that ended.
        moment
            Where it ended.
        signs
            Of the functions of the axis.
        """
        if end == "stick":
            return self._stick(ball, moment, signs)
        if end == "slip":
            return self._slip(ball, moment, signs)
        if end == "liftoff":
            change = self._flight(ball, moment, "liftoff", 3)
            change.events, change.signs = ("liftoff",), signs
            return change
        struck_ball = 1 - ball if end == "touch" else self._lowest(moment)
        reason = "other-ball" if end == "touch" else "landing"
        return self._strike(struck_ball, moment, signs, reason, old=ball if end == "touch" else None)

    def _lowest(self, moment: Moment) -> int:
        return int(np.argmin([float(self.gap(k, moment)) for k in range(len(self.balls))]))

    def _stick(self, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """Sliding stops: what is left of it takes the time |v_A|/|P|."""
        kind, body, b = self.kinds["dry-slip"], self.balls[ball], self.ball(ball)
        v = self.point(ball, moment)
        w = self._size(v)
        if w > 0:
            moment, lag = self._run_out(kind, body, b, moment, v, w)
            moment = self._stopped(b, moment)
        else:
            lag = 0 * w
        change = self._on_plane(ball, moment, "stick")
        rests = change.kind == "roll"
        change.events, change.signs = ("stick" if rests else "reversal",), signs
        change.when, change.lag = lag, change.lag + lag
        return change

    def _run_out(self, kind: Kind, body: Body, b: Ball, moment: Moment, v: Vector, w: Any) -> tuple[Moment, Any]:
        """The last of a slide, |v_A| = w so small that its rates stay: the end, and the time to it."""
        n = Vector(v.x / w, v.y / w, 0 * w)
        bias = balls_.bias_vector(moment.u, moment.L, b)
        F = coulomb.slip_force_vector(moment.u, bias, n, b)
        P, _ = coulomb.along_and_across(balls_.contact_acceleration_vector(moment.u, bias, F, b), n)
        lag = -w / P
        q = kind.state(moment.u, moment.L, moment.velocity, moment.height, body)
        end = [x + lag * rate for x, rate in zip(q, kind.form.rates(q, body), strict=True)]
        says = kind.says(type(q)(*end), body)
        nodes = type(q)(*(np.array([x]) for x in q))
        carried = self._integrated(kind, body, nodes, moment.carried, np.array([[lag]]))[:, -1]
        return Moment(says.u, says.L, says.velocity, balls_.height(says.u.z, b), carried), lag

    def _stopped(self, b: Ball, moment: Moment) -> Moment:
        """The contact point brought to rest by the impulse that this takes: nothing of energy or Jellett's integral is
        lost."""
        v = balls_.contact_velocity(moment.u, moment.L, moment.velocity, b)
        p = balls_.mobility_inverse_times(moment.u, times(-1, v), b)
        velocity, L = plus(moment.velocity, times(1 / b.m, p)), plus(moment.L, cross(balls_.arm(moment.u, b), p))
        carried = moment.carried.copy()
        carried[self.work] = carried[self.work] - dot(p, v) / 2 * INTEGRAL_SCALE
        return moment._replace(L=L, velocity=velocity, carried=carried)

    def _run_in(self, ball: int, b: Ball, moment: Moment, n: Vector) -> tuple[Moment, Any]:
        """The first of a slide along n from rest, so short that its rates stay; and the time that it takes."""
        kind, body = self.kinds["dry-slip"], self.balls[ball]
        bias = balls_.bias_vector(moment.u, moment.L, b)
        F = coulomb.slip_force_vector(moment.u, bias, n, b)
        P, _ = coulomb.along_and_across(balls_.contact_acceleration_vector(moment.u, bias, F, b), n)
        speed = self.number(BEGINS_AT)
        lag = speed / P
        u = plus(moment.u, times(lag, balls_.axis_rate(moment.u, moment.L, b)))
        L = plus(moment.L, times(lag, cross(balls_.arm(moment.u, b), F)))
        velocity, height = balls_.centre_velocity(u, L, times(speed, n), b), balls_.height(u.z, b)
        q = kind.state(u, L, velocity, height, body)
        carried = self._integrated(kind, body, type(q)(*(np.array([x]) for x in q)), moment.carried, np.array([[lag]]))[
            :, -1
        ]
        return Moment(u, L, velocity, height, carried), lag

    def _slip(self, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """Rolling needs more friction than there is."""
        b, body, kind, span = self.ball(ball), self.balls[ball], self.kinds["dry-slip"], SPAN
        while True:  # short enough for nothing else to happen to the contact
            begun = leave_rolling(moment.u, moment.L, b, span)
            height, velocity = balls_.height(begun.u.z, b), balls_.centre_velocity(begun.u, begun.L, begun.v, b)
            q = kind.state(begun.u, begun.L, velocity, height, body)
            last = type(q)(*(x[-1] for x in q))
            if span < SPAN / 1000 or (
                float(kind.says(last, body).force.z) > 0 and float(body.clearance + body.lever * begun.u.z[-1]) > 0
            ):
                break
            span /= 2
        carried = self._integrated(kind, body, q, moment.carried, begun.time * begun.integrate)
        at_end = [Vector(*(x[-1] for x in v)) for v in (begun.u, begun.L, velocity)]
        moment = Moment(*at_end, height[-1], carried[:, -1].copy())
        between = Between(np.array([np.broadcast_to(x, begun.u.z.shape) for x in q]), carried)
        return Change("dry-slip", ball, moment, "slip", ("slip",), signs, lag=begun.time, between=between)

    def _integrated(self, kind: Kind, body: Body, q: Any, carried: np.ndarray, integrate: Any) -> np.ndarray:
        """The integrals at nodes of a short time, (integrals, nodes), from the states q there, and a matrix that
        integrates from the start."""
        form, variables = kind.form, self.problem.variables
        turning = form.orientation.integrals if self.problem.orientation and form.orientation else ()
        rates = {integral.name: integral.rate for integral in (*form.integrals, *turning)}
        start, nodes = carried / INTEGRAL_SCALE, len(integrate)
        values = [np.full(nodes, value) for value in start]
        for _ in range(SWEEPS):
            record = variables.carried(*values)
            with np.errstate(divide="ignore", invalid="ignore"):
                values = [
                    value + integrate @ _rate(rates[name](q, record, body), nodes)
                    if name in rates else np.full(nodes, value)
                    for name, value in zip(variables.carried._fields, start, strict=True)
                ]  # fmt: skip
        return np.array(values) * INTEGRAL_SCALE

    # --- what begins ----------------------------------------------------------------------------------------------

    def _flight(self, ball: int, moment: Moment, reason: str, zeros: int) -> Change:
        """Free flight, until the first ball lands; `zeros` of the gap, its speed and its bend vanish at the start."""
        hops = []
        for k in range(len(self.balls)):
            gap, mine = self.gap(k, moment), k == ball
            touches = float(gap) <= ON_PLANE
            known = zeros if mine else int(touches)
            numbers = (Vector(*map(_wide, v)) for v in (moment.u, moment.L))
            hops.append(hop(*numbers, _wide(moment.velocity.z), _wide(gap), self.ball(k), known))
        _, landing = first_landing(hops)
        if not landing > 0:
            return Change("flight", ball, moment, reason, landing=landing, ends=Status.STALLED)
        return Change("flight", ball, moment, reason, landing=landing)

    def _on_plane(self, ball: int, moment: Moment, reason: str, takes: bool = False) -> Change:
        """A ball touches the plane and its contact point does not rise: it slides, rolls, or leaves."""
        b, v = self.ball(ball), self.point(ball, moment)
        w = self._size(v)
        if not self.balls.dry or float(w) > STOPS_AT:
            kind = "dry-slip" if self.balls.dry else "slip"
            q = self.kinds[kind].state(moment.u, moment.L, moment.velocity, moment.height, self.balls[ball])
            if float(self.kinds[kind].says(q, self.balls[ball]).force.z) > 0:
                return Change(kind, ball, moment, reason, takes=takes)
            return self._flight(ball, moment, "opens-at-once", 2)
        none = 0 * w
        moment = moment._replace(velocity=balls_.centre_velocity(moment.u, moment.L, Vector(none, none, none), b))
        force = coulomb.reaction_of_rolling_vector(moment.u, balls_.bias_vector(moment.u, moment.L, b), b)
        if float(force.z) > 0 and float(coulomb.cone(force.x, force.y, force.z, b.mu)) >= 0:
            return Change("roll", ball, moment, reason, takes=takes)
        n = first_direction(moment.u, moment.L, b)
        if n is None:
            return self._flight(ball, moment, "opens-at-once", 2)
        n = Vector(np.sign(n.x), none, none) if self.problem.system.name in PLANAR else n
        begun, lag = self._run_in(ball, b, moment, n)
        return Change("dry-slip", ball, begun, reason, lag=lag, takes=takes)

    def _strike(
        self, ball: int, moment: Moment, signs: dict[str, float], reason: str, old: int | None = None
    ) -> Change:
        """An impact at a ball; then at the other one, should that be pressed into the plane."""
        strikes: list[Strike] = []
        while len(strikes) < MOST_STRIKES:
            moment, strike = self._struck(ball, moment)
            strikes.append(strike)
            others = [k for k in range(len(self.balls)) if k != ball and float(self.gap(k, moment)) <= ON_PLANE]
            pressed = [k for k in others if float(self.point(k, moment).z) < -CLOSES_AT]
            if not pressed:
                break
            ball = pressed[0]
        rises = not strikes[-1].plastic
        change = self._flight(ball, moment, reason, 1) if rises else self._on_plane(ball, moment, reason)
        change.takes, change.strikes = True, tuple(strikes)
        change.events = ("impact",) * len(strikes)
        change.signs = {name: sign for name, sign in signs.items() if name != "turning"}
        return change

    def _struck(self, index: int, moment: Moment) -> tuple[Moment, Strike]:
        b, v, u = self.ball(index), self.point(index, moment), moment.u
        across = self._size(u)
        e = Vector(u.x / across, u.y / across, 0 * across) if float(across) > 0 else self._direction(v)
        along, sideways = v.x * e.x + v.y * e.y, e.x * v.y - e.y * v.x
        assert self.rules is not None
        closes = abs(float(v.z)) < CLOSES_AT
        K = balls_.mobility(across, u.z, b)
        e_n, law = 0.0 if closes else self.rules.e_n, self.balls[index].friction
        if self.balls.dry or isinstance(law, Frictionless):
            result = struck(along, sideways, v.z, K, b.mu, e_n, self.rules.restitution)
        else:
            result = struck_smooth(
                along, sideways, v.z, K, lambda v2: slip_coefficient(v2, u.z, law), e_n, self.rules.restitution
            )
        p = Vector(result.p_e * e.x - result.p_2 * e.y, result.p_e * e.y + result.p_2 * e.x, result.p_z)
        velocity = plus(moment.velocity, times(1 / b.m, p))
        L = plus(moment.L, cross(balls_.arm(u, b), p))
        after = balls_.contact_velocity(u, L, velocity, b)
        gained = (dot(p, v) + dot(p, after)) / 2
        carried = moment.carried.copy()
        carried[self.work] = carried[self.work] - gained * INTEGRAL_SCALE
        carried[self.impulse] = carried[self.impulse] + p.z * INTEGRAL_SCALE
        plastic = closes or self.rules.e_n == 0
        if plastic:
            velocity = velocity._replace(z=velocity.z - after.z)  # it does not rise by rounding
        strike = Strike(
            index, (float(v.z), float(after.z)), (float(self._size(v)), float(self._size(after))), float(p.z),
            float(self._size(p)), float(gained), result.mode, plastic,
        )  # fmt: skip
        return Moment(u, L, velocity, moment.height, carried), strike

    def _direction(self, v: Vector) -> Vector:
        w = self._size(v)
        one, none = 0 * w + 1, 0 * w
        return Vector(v.x / w, v.y / w, none) if float(w) > 0 else Vector(one, none, none)

    def _size(self, v: Vector) -> Any:
        return np.sqrt(v.x * v.x + v.y * v.y)

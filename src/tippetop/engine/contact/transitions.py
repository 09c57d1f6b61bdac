"""What follows the end of a phase: the table of the contact's phases, in one place. [contact 6]"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...mechanics.contact import ball as balls_
from ...mechanics.contact import coulomb
from ...mechanics.contact.ball import Ball
from ...mechanics.contact.first_slip import FirstSlip
from ...mechanics.contact.flight import hop
from ...mechanics.contact.landing import first_landing
from ...mechanics.contact.phases.drilling import DRILLING_KINDS, FOLLOWS, region_kind
from ...mechanics.contact.phases.legs import STOPS_AT, Body, Kind
from ...mechanics.operand import Vector, cross, dot, plus, times
from ...mechanics.systems.with_contact import PLANAR
from ...mechanics.variables import INTEGRAL_SCALE
from ..status import Status
from .beginning import direction, slide_from_cone, states
from .impacts import CLOSES_AT, Impacts, Moment, Strike


BEGINS_AT = 1e-8  # |v_A| with which sliding begins from rest outside the friction cone; its square is the error
BOTH_AT = 1e-5  # v_n at which one ball takes over from the other below which both are on the plane at once
NO_WAY = "the contact opens and closes at once: the model has no solution"
MAKES_ENERGY = 'restitution = "newton" made energy in an impact, which no impact does: use "energetic"'
BOTH = "the body stands on its sphere and its stem at once, which is not followed"
ON_PLANE = 1e-9  # gap of a ball that touches
MOST_STRIKES = 16  # of impacts at one instant


def _wide(value: Any) -> Any:
    """A number as flights take it: a double, or one of 80 bits."""
    return float(value) if isinstance(value, float) else np.longdouble(value)


@dataclass
class Change:
    """A phase that begins."""

    kind: str  # of legs.KINDS
    ball: int
    moment: Moment
    reason: str
    events: tuple[str, ...] = ()  # of the run, that happen now
    signs: dict[str, float] = field(default_factory=dict)  # of event functions that continue as they were
    when: Any = 0  # internal time from the end of the phase before to these events
    lag: Any = 0  # and to the beginning of this one
    landing: Any = None  # internal time to the landing of a flight
    between: FirstSlip | None = None  # what passes in the time `lag`
    takes: bool = False  # whether another ball is in contact from now on
    strikes: tuple[Strike, ...] = ()
    ends: Status | None = None
    sentence: str = ""  # why the run ends


class Transitions(Impacts):
    """Says what follows a phase.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """The kinds of phases that the run may have."""
        if self.balls.dry:
            return "dry-slip", "roll", "flight"
        return tuple(DRILLING_KINDS) if self.balls.drills else ("slip", "flight")

    # --- the phases' ends -----------------------------------------------------------------------------------------

    def at_start(self, moment: Moment) -> Change:
        """The phase in which a run begins."""
        gaps = [float(self.gap(k, moment)) for k in range(len(self.balls))]
        touching = [k for k, gap in enumerate(gaps) if gap <= ON_PLANE]
        if not touching:
            return self._flight(0, moment, "start", 0)
        v_n = {k: float(self.point(k, moment).z) for k in touching}
        falls = min(touching, key=v_n.__getitem__)
        if v_n[falls] < -CLOSES_AT:
            return self._strike(falls, moment, {}, "start")
        rests = [k for k in touching if v_n[k] <= CLOSES_AT]
        if not rests:
            return self._flight(falls, moment, "start", 1)
        if len(rests) == 2:
            return Change("flight", falls, moment, "start", ends=Status.ENDED, sentence=BOTH)
        return self._on_plane(falls, moment, "start", takes=True)

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
        if (kind, end) in FOLLOWS:  # the same phase in other words
            return Change(FOLLOWS[kind, end], ball, moment, "", signs=signs)
        if end == "stick":
            return self._stick(ball, moment, signs)
        if end == "slip":
            return self._slip(ball, moment, signs)
        if end == "liftoff":
            change = self._flight(ball, moment, "liftoff", 3)
            change.events, change.signs = ("liftoff",), signs
            return change
        struck_ball = 1 - ball if end == "touch" else self._landed(moment)
        reason = "other-ball" if end == "touch" else "landing"
        return self._strike(struck_ball, moment, signs, reason)

    def _landed(self, moment: Moment) -> int:
        """The ball that lands: of those on the plane the one that falls fastest."""
        gaps = [float(self.gap(k, moment)) for k in range(len(self.balls))]
        there = [k for k, gap in enumerate(gaps) if gap <= max(ON_PLANE, min(gaps))]
        return min(there, key=lambda k: float(self.point(k, moment).z))

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
        carried = self._later(kind, body, q, moment.carried, lag)
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
        carried = self._later(kind, body, q, moment.carried, lag)
        return Moment(u, L, velocity, height, carried), lag

    def _slip(self, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """Rolling needs more friction than there is."""
        b, body, kind = self.ball(ball), self.balls[ball], self.kinds["dry-slip"]
        carried, rate = moment.carried / INTEGRAL_SCALE, self._rates(kind, body)
        first = slide_from_cone(kind, body, b, moment.u, moment.L, carried, rate)
        end = states(kind, body, first, first.time[-1:])[:, 0]
        says = kind.says(type(kind.form.units)(*end[: len(kind.form.units)]), body)
        carried = end[len(kind.form.units) :] * INTEGRAL_SCALE
        moment = Moment(says.u, says.L, says.velocity, says.height, carried)
        return Change("dry-slip", ball, moment, "slip", ("slip",), signs, lag=first.time[-1], between=first)

    def _rates(self, kind: Kind, body: Body) -> Callable:
        """rates(q, carried) of the integrals of a row, (k, n), in a phase."""
        form, variables = kind.form, self.problem.variables
        turning = form.orientation.integrals if self.problem.orientation and form.orientation else ()
        by_name = {integral.name: integral.rate for integral in (*form.integrals, *turning)}

        def rates(q: Any, carried: np.ndarray) -> np.ndarray:
            record = variables.carried(*carried)
            shape = carried.shape[1:]
            return np.array(
                [
                    np.broadcast_to(by_name[name](q, record, body), shape) if name in by_name else np.zeros(shape)
                    for name in variables.carried._fields
                ]
            )

        return rates

    def _later(self, kind: Kind, body: Body, q: Any, carried: np.ndarray, time: Any) -> np.ndarray:
        """The integrals after a time so short that their rates stay."""
        whole = carried / INTEGRAL_SCALE
        return (whole + time * self._rates(kind, body)(q, whole)) * INTEGRAL_SCALE

    # --- what begins ----------------------------------------------------------------------------------------------

    def _flight(self, ball: int, moment: Moment, reason: str, zeros: int) -> Change:
        """Free flight, until the first ball lands; `zeros` of the gap, its speed and its bend vanish at the start."""
        hops = []
        for k in range(len(self.balls)):
            gap, mine = self.gap(k, moment), k == ball
            touches = float(gap) <= ON_PLANE
            known = zeros if mine else int(touches)
            u, L = (Vector(*map(_wide, v)) for v in (moment.u, moment.L))
            hops.append(hop(u, L, _wide(moment.velocity.z), _wide(gap), self.ball(k), known))
        _, landing = first_landing(hops)
        if not landing > 0:
            return Change("flight", ball, moment, reason, landing=landing, ends=Status.STALLED, sentence=NO_WAY)
        return Change("flight", ball, moment, reason, landing=landing)

    def _on_plane(self, ball: int, moment: Moment, reason: str, takes: bool = False) -> Change:
        """A ball touches the plane and its contact point does not rise: it slides, rolls, or leaves."""
        b, v = self.ball(ball), self.point(ball, moment)
        w = self._size(v)
        if not self.balls.dry or float(w) > STOPS_AT:
            kind = "dry-slip" if self.balls.dry else "slip"
            if self.balls.drills:
                kind = region_kind(moment.u, moment.L, moment.velocity, self.balls[ball])
            q = self.kinds[kind].state(moment.u, moment.L, moment.velocity, moment.height, self.balls[ball])
            if float(self.kinds[kind].says(q, self.balls[ball]).force.z) > 0:
                return Change(kind, ball, moment, reason, takes=takes)
            return self._flight(ball, moment, "opens-at-once", 2)
        none = 0 * w
        moment = moment._replace(velocity=balls_.centre_velocity(moment.u, moment.L, Vector(none, none, none), b))
        force = coulomb.reaction_of_rolling_vector(moment.u, balls_.bias_vector(moment.u, moment.L, b), b)
        if float(force.z) > 0 and float(coulomb.cone(force.x, force.y, force.z, b.mu)) >= 0:
            return Change("roll", ball, moment, reason, takes=takes)
        n = direction(moment.u, moment.L, b)
        if n is None:
            return self._flight(ball, moment, "opens-at-once", 2)
        n = Vector(np.sign(n.x), none, none) if self.problem.system.name in PLANAR else n
        moment, lag = self._run_in(ball, b, moment, n)
        return Change("dry-slip", ball, moment, reason, lag=lag, takes=takes)

    def _strike(self, ball: int, moment: Moment, signs: dict[str, float], reason: str) -> Change:
        """An impact at a ball; then at the other one, should that be pressed into the plane."""
        strikes: list[Strike] = []
        v_n = float(self.point(ball, moment).z)
        both = self.balls.stem and all(float(self.gap(k, moment)) <= ON_PLANE for k in (0, 1))
        if both and v_n > -BOTH_AT:
            return Change("flight", ball, moment, reason, ends=Status.ENDED, sentence=BOTH)
        if not v_n < 0:  # it touches without striking
            return self._on_plane(ball, moment, reason)
        while len(strikes) < MOST_STRIKES:
            moment, strike = self._struck(ball, moment)
            strikes.append(strike)
            if strike.makes_energy:
                events = ("impact",) * len(strikes)
                return Change(
                    "flight",
                    ball,
                    moment,
                    reason,
                    events,
                    strikes=tuple(strikes),
                    ends=Status.ENDED,
                    sentence=MAKES_ENERGY,
                )
            others = [k for k in range(len(self.balls)) if k != ball and float(self.gap(k, moment)) <= ON_PLANE]
            pressed = [k for k in others if float(self.point(k, moment).z) < -CLOSES_AT]
            if not pressed:
                break
            ball = pressed[0]
        else:
            return Change("flight", ball, moment, reason, ends=Status.STALLED, sentence=NO_WAY)
        rises = not strikes[-1].plastic
        change = self._flight(ball, moment, reason, 1) if rises else self._on_plane(ball, moment, reason)
        change.takes, change.strikes = True, tuple(strikes)
        change.events = ("impact",) * len(strikes)
        change.signs = {name: sign for name, sign in signs.items() if name != "turning"}
        return change

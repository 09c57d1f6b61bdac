"""What follows the end of a phase: the table of the contact's phases, in one place. [contact 6]"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...mechanics.contact import coulomb
from ...mechanics.contact.body import centre_velocity
from ...mechanics.contact.first_slip import FirstSlip
from ...mechanics.contact.phases.both import BOTH_FOLLOWS, STAYS
from ...mechanics.contact.phases.drilling import (
    DRILLING_KINDS,
    FOLLOWS,
    RESTS,
    region_kind,
    stays_at_rest,
)
from ...mechanics.contact.phases.dry import STOPS_AT
from ...mechanics.contact.response import bias_vector
from ...mechanics.operand import Vector
from ...mechanics.systems.with_contact import PLANAR
from ...mechanics.variables import INTEGRAL_SCALE
from ..status import Status
from .beginning import direction, slide_from_cone, states
from .impacts import CLOSES_AT, Moment, Strike
from .sliding import Sliding
from .standing import ON_PLANE, Standing


LEAVES_FOR = 1e-3  # internal time: the gap of a ball that leaves as its force vanishes has a triple root
NO_WAY = "the contact opens and closes at once: the model has no solution"
MAKES_ENERGY = 'restitution = "newton" made energy in an impact, which no impact does: use "energetic"'
BOTH = "the body stands on its sphere and its stem at once, which is not followed under Coulomb's law itself"
AT_REST = "the contact's disc comes to rest, where friction can hold it; rolling without turning is not followed"
ASKED_AFTER = 3e-3  # internal time: whether friction holds a disc that passes its rest; some thousand steps
MOST_STRIKES = 16  # of impacts at one instant


ALIKE = FOLLOWS | BOTH_FOLLOWS
BACK = {f"{ball}{there}": f"{ball}{back}" for ball in ("", "stem-")
        for there, back in (("faster", "slower"), ("slower", "faster"))}  # fmt: skip
"""By the event in which a region of friction that drills ends, the event of the way back."""
WITHIN = {word for (kind, word), follows in ALIKE.items() if kind == follows}
"""Events that end a step and nothing else."""


@dataclass
class Change:
    """A phase that begins."""

    kind: str  # of legs.KINDS
    ball: int
    moment: Moment
    reason: str
    events: tuple[str, ...] = ()  # of the run, that happen now
    signs: dict[str, float] = field(default_factory=dict)  # of event functions that continue as they were
    passed: str = ""  # the event function that is on its zero, because the phase before ended beyond it
    functions: dict[str, float] | None = None  # the event functions where it begins, if they are known
    when: Any = 0  # internal time from the end of the phase before to these events
    lag: Any = 0  # and to the beginning of this one
    landing: Any = None  # internal time to the landing of a flight, or to the end of any other phase
    waits: float = 0.0  # internal time in which the other ball, that has just left, cannot touch
    between: FirstSlip | None = None  # what passes in the time `lag`
    takes: bool = False  # whether another ball is in contact from now on
    strikes: tuple[Strike, ...] = ()
    ends: Status | None = None
    sentence: str = ""  # why the run ends


class Transitions(Sliding, Standing):
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
        """The kinds of phases on one ball or none that the run may have."""
        if self.balls.dry:
            return "dry-slip", "roll", "flight"
        return tuple(DRILLING_KINDS) if self.balls.drills else ("slip", "flight")

    @property
    def standing(self) -> tuple[str, ...]:
        """The kinds of standing on both balls that a run may have: of friction that drills, one for each region."""
        if self.balls.dry or not self.balls.stem:
            return ()
        return tuple(f"both-{name}-{name}" for name in self.balls.regions) or ("both",)

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
            return self._standing(moment, "start")
        return self._on_plane(falls, moment, "start", takes=True)

    def after(self, end: str, kind: str, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """What follows a phase.

        Parameters
        ----------
        end
            The event that ended it: stick, slip, rests, liftoff, touch, landing, one of STAYS; clear: the other ball
            has gone.
        kind, ball
            The phase that ended.
        moment
            Where it ended.
        signs
            Of the functions of the axis.
        """
        if (kind, end) in ALIKE:  # the same phase in other words
            return self._on_disc(Change(ALIKE[kind, end], ball, moment, "", signs=signs, passed=BACK.get(end, end)))
        if end in ("clear", RESTS.name) or (end == "landing" and kind != "flight"):  # the latter: to be asked again
            passed = end if end == RESTS.name else ""
            return self._on_disc(Change(kind, ball, moment, "", signs=signs, passed=passed))
        if end in STAYS:
            change = self._on_plane(STAYS[end], moment, "other-leaves", takes=True)
            change.waits = LEAVES_FOR
            return change
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
        if not self.balls.stem:
            return 0
        gaps = [float(self.gap(k, moment)) for k in range(len(self.balls))]
        there = [k for k, gap in enumerate(gaps) if gap <= max(ON_PLANE, min(gaps))]
        return min(there, key=lambda k: float(self.point(k, moment).z))

    def _stick(self, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """Sliding stops: what is left of it takes the time |v_A|/|P|."""
        kind, body = self.kinds["dry-slip"], self.balls[ball]
        v = self.point(ball, moment)
        w = self._size(v)
        if w > 0:
            moment, lag = self._run_out(kind, body, moment, v, w)
            moment = self._stopped(body, moment)
        else:
            lag = 0 * w
        change = self._on_plane(ball, moment, "stick")
        rests = change.kind == "roll"
        change.events, change.signs = ("stick" if rests else "reversal",), signs
        change.when, change.lag = lag, change.lag + lag
        return change

    def _on_disc(self, change: Change) -> Change:
        """A phase under way. Where sliding and turning stop at once the run ends, unless friction cannot hold the disc:
        then it passes its rest and turns on, and may turn back before anybody sees it."""
        if change.kind not in DRILLING_KINDS or change.kind == "flight":
            return change
        kind, ball, moment = change.kind, change.ball, change.moment
        change.functions = change.functions or self.functions(kind, ball, moment)
        if change.passed == RESTS.name or change.functions[RESTS.name] < 0:
            if stays_at_rest(moment.u, moment.L, moment.velocity, self.balls[ball]):
                change.ends, change.sentence = Status.ENDED, AT_REST
            else:
                change.landing = ASKED_AFTER
        return change

    def _slip(self, ball: int, moment: Moment, signs: dict[str, float]) -> Change:
        """Rolling needs more friction than there is."""
        body, kind = self.balls[ball], self.kinds["dry-slip"]
        carried, rate = moment.carried / INTEGRAL_SCALE, self._rates(kind, body)
        first = slide_from_cone(kind, body, moment.u, moment.L, carried, rate)
        lag = min(first.time[-1], self.left)
        end = states(kind, body, first, np.array([lag]))[:, 0]
        says = kind.says(type(kind.form.units)(*end[: len(kind.form.units)]), body)
        carried = end[len(kind.form.units) :] * INTEGRAL_SCALE
        moment = Moment(says.u, says.L, says.velocity, says.height, carried)
        return Change("dry-slip", ball, moment, "slip", ("slip",), signs, lag=lag, between=first)

    # --- what begins ----------------------------------------------------------------------------------------------

    def _flight(self, ball: int, moment: Moment, reason: str, zeros: int) -> Change:
        """Free flight, until the first ball lands; `zeros` of the gap, its speed and its bend vanish at the start."""
        times = []
        for k in range(len(self.balls)):
            gap = self.gap(k, moment)
            known = zeros if k == ball else int(float(gap) <= ON_PLANE)
            times.append(self.landings.of(moment.u, moment.L, moment.velocity.z, gap, self.balls[k], known))
        landing = min(times)
        if not landing > 0:
            return Change("flight", ball, moment, reason, landing=landing, ends=Status.STALLED, sentence=NO_WAY)
        return Change("flight", ball, moment, reason, landing=landing)

    def _standing(self, moment: Moment, reason: str) -> Change:
        """Both balls touch and neither rises: the body stays on both, if both press, or on the one that does."""
        if not self.balls.dry:
            moment, name = self._at_rest(moment)
            if name:
                return Change(name, 0, moment, reason, takes=True)
        for ball in (0, 1):
            change = self._on_plane(ball, moment, reason, takes=True)
            if change.kind == "flight" or self._opens(change.kind, ball, change.moment):
                change.waits = LEAVES_FOR if change.landing is None else 0
                return change
        return Change("flight", 0, moment, reason, ends=Status.ENDED, sentence=BOTH if self.balls.dry else NO_WAY)

    def _on_plane(self, ball: int, moment: Moment, reason: str, takes: bool = False) -> Change:
        """A ball touches the plane and its contact point does not rise: it slides, rolls, or leaves."""
        body = self.balls[ball]
        if not self.balls.dry or float(self._size(self.point(ball, moment))) > STOPS_AT:
            kind = "dry-slip" if self.balls.dry else "slip"
            if self.balls.drills:
                kind = region_kind(moment.u, moment.L, moment.velocity, body)
            functions = self.functions(kind, ball, moment)
            if functions["liftoff"] > 0:
                return self._on_disc(Change(kind, ball, moment, reason, functions=functions, takes=takes))
            return self._flight(ball, moment, "opens-at-once", 2)
        none = 0 * body.m
        moment = moment._replace(velocity=centre_velocity(moment.u, moment.L, Vector(none, none, none), body))
        force = coulomb.reaction_of_rolling_vector(moment.u, bias_vector(moment.u, moment.L, body), body)
        if float(force.z) > 0 and float(coulomb.cone(force.x, force.y, force.z, body.friction.mu)) >= 0:
            return Change("roll", ball, moment, reason, takes=takes)
        n = direction(moment.u, moment.L, body)
        if n is None:
            return self._flight(ball, moment, "opens-at-once", 2)
        n = Vector(np.sign(n.x), none, none) if self.problem.system.name in PLANAR else n
        moment, lag = self._run_in(ball, moment, n)
        return Change("dry-slip", ball, moment, reason, lag=lag, takes=takes)

    def _strike(self, ball: int, moment: Moment, signs: dict[str, float], reason: str) -> Change:
        """An impact at a ball; then at the other one, should that be pressed into the plane."""
        strikes: list[Strike] = []
        v_n = float(self.point(ball, moment).z)
        if self._rests_on_both(moment):
            return self._standing(moment, reason)
        if not v_n < 0:  # it touches without striking
            return self._on_plane(ball, moment, reason)
        while len(strikes) < MOST_STRIKES:
            moment, strike = self._struck(ball, moment, v_n)
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
            v_n = float(self.point(ball, moment).z)
        else:
            return Change("flight", ball, moment, reason, ends=Status.STALLED, sentence=NO_WAY)
        rises = not strikes[-1].plastic
        if rises:
            change = self._flight(ball, moment, reason, 1)
        elif self._rests_on_both(moment):
            change = self._standing(moment, reason)
        else:
            change = self._on_plane(ball, moment, reason)
        change.takes, change.strikes = True, tuple(strikes)
        change.events = ("impact",) * len(strikes)
        change.signs = {name: sign for name, sign in signs.items() if name != "turning"}
        return change

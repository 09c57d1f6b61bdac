"""Drives a run from phase to phase: an ordinary driver for each, and a rule that says what follows.

To whoever asks it is a driver like any other; its states are rows (`mechanics.contact.phases.row.Row`).
"""

import threading
from typing import Any

import numpy as np

from ...mechanics.contact.body import jellett_of
from ...mechanics.contact.phases.row import PHASES
from ...mechanics.doubledouble import parts_of, sum_of
from ...mechanics.operand import dot
from ...mechanics.systems.with_contact import leg
from ...mechanics.units import SECOND
from ...mechanics.variables import INTEGRAL_SCALE, Variables
from ...problem import Problem
from ..driver import Driver, Extremes, Passages, Request, Slice, Wanted
from ..expressions import equations_of_motion
from ..status import Status
from ..tallies import SIGN, event_rows, new_tallies
from .balls import Balls
from .between import fill_between
from .expected import expect
from .gathered import NOBODY, Gathered
from .impacts import Moment, moment_of
from .legs import Followed
from .tables import Tables
from .transitions import Change, Transitions


MOST_CHANGES = 10_000  # of phase in a run
PER_SLICE = 64  # changes: a slice ends after them, so that nobody waits for it; by no clock, for stores say where
DRILLS = 1  # so many where friction drills: an impact of a patch that hardly turns may take seconds
CHATTER = 1e-12  # internal time: phases so short, three in a row, lead nowhere
QUIET = np.errstate(invalid="ignore", divide="ignore", over="ignore")
"""Formulas of a phase are asked of states of another, such as the region of a patch that drills; what is no number in
the motion itself ends the run."""


class ContactDriver:
    """Makes the steps of a run whose contact changes its phase.

    Parameters
    ----------
    problem
        The run.
    stop
        Set it to give up while equations are being compiled.

    Attributes
    ----------
    first
        The row at the start, (1, variables).
    sentence
        Why the contact ended the run; empty where it did not.
    ended
        How the contact ends the run before its first step; None: it does not.
    """

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        self.problem, self.stop, self.balls = problem, stop, Balls(problem)
        events = problem.system.events
        self.tallies = new_tallies(event_rows(events, [(0, 1, 1.0, 0.0)] * len(events), ()), 1)
        self.variables = len(problem.variables.names)
        self.transitions = Transitions(problem, self.balls)
        self.end = problem.number(problem.until) / problem.number(float(problem.scales.of(SECOND)))
        self.phases: dict[tuple[str, int], Followed] = {}
        self.force, self.tables = Extremes(), Tables(problem)
        self.changes = self.short = 0
        self.per_slice = DRILLS if self.balls.drills else PER_SLICE
        self.taken: Any = problem.number(0)
        self.wanted, self.sentence = Wanted(), ""
        start = problem.start()
        self.transitions.left = self.end
        moment = moment_of(start)
        self.moment = moment  # at the start
        try:
            change = self.transitions.at_start(moment)
        except ArithmeticError as error:
            change = Change("flight", 0, moment, "start", ends=Status.STALLED, sentence=str(error))
        change.takes = True
        self.ended, self.sentence = change.ends, change.sentence
        self._enter(change, (problem.number(change.lag), problem.number(0)), problem.number(0))
        self.first = self.present()

    # --- the phase that is under way ------------------------------------------------------------------------------

    @property
    def kind(self) -> str:
        """The kind of the present phase."""
        return self.phase.name

    @property
    def ball(self) -> int:
        """The number of the ball in contact, or last in contact."""
        return self.phase.ball

    @property
    def inner(self) -> Driver:
        """The driver of the present phase."""
        return self.phase.driver

    @property
    def is_called(self) -> bool:
        """Whether Python calls heyoka for each step of the present phase."""
        return self.inner.is_called

    @property
    def tally(self) -> Any:
        """What the observer knows of the present phase."""
        return self.inner.tally

    @property
    def at_start(self) -> np.ndarray:
        """No event function says that a run ends at once: the phase of the start is chosen."""
        return np.ones(len(self.problem.system.events))

    @QUIET
    def prepare(self) -> None:
        """Compiles the equations of the phases that most runs have."""
        moment = self.moment
        for kind in self.transitions.names:
            how = self.transitions.kinds[kind]
            q = how.state(moment.u, moment.L, moment.velocity, moment.height, self.balls[0])
            self._followed(kind, self.ball, q)

    def equations(self) -> list[tuple]:
        """The equations of every phase that the run may have, by name."""
        lines = []
        for name in (*self.transitions.names, *self.transitions.standing):
            system = leg(self.problem.system.name, name)
            variables = Variables(next(iter(system.forms.values())), self.problem.orientation)
            friction = type(self.balls[0].friction)
            lines += equations_of_motion(system, variables, friction).rates
        return lines

    def rows(self, states: np.ndarray) -> np.ndarray:
        """States (n, variables) of the present phase as rows."""
        output = Gathered(self.problem, self.balls, NOBODY)
        output.of(self.phase, self.carried, self.taken)
        output.sample(states)
        output.give()
        return output.sampled()

    def present(self) -> np.ndarray:
        """The row of the present state, (1, variables)."""
        return self.rows(self.inner.state[None, : self.inner.variables])

    def _enter(self, change: Change, clock: tuple[Any, Any], since: Any = None) -> None:
        """Takes up a phase at a time of the clock; it began then, or somewhat earlier at `since`."""
        moment, ball, number = change.moment, change.ball, self.problem.number
        q = self.transitions.state(change.kind, ball, moment)
        self.phase = phase = self._followed(change.kind, ball, q)
        if change.reason:
            began = float(clock[0] if since is None else since)
            self.tables.begin(PHASES.index(phase.kind.phase), ball, began, change)
        if change.takes:
            lost = moment.carried[self.transitions.lost] / INTEGRAL_SCALE if self.transitions.lost >= 0 else 0
            self.taken = number(jellett_of(moment.L.z, dot(moment.L, moment.u), self.balls[ball])) + lost
        self.carried = moment.carried
        driver = phase.driver
        state = np.zeros(len(driver.state), dtype=number)
        state[: len(q)] = q
        phase.carried.into_state(self.carried, state)
        driver.put(state, clock)
        expect(phase, change, lambda: self.transitions.functions(change.kind, change.ball, moment))
        landing, self.waits = change.landing, None
        if change.waits:
            self.waits = landing = clock[0] + number(change.waits)
        elif landing is not None:
            landing = clock[0] + number(landing)
        self._watch(phase)
        self._until(landing, driver)
        driver.tally["t"] = float(clock[0])
        self.began = float(clock[0])

    def _followed(self, name: str, ball: int, q: Any) -> Followed:
        """The phase of a kind, on a ball; q is a state that it may have."""
        if (name, ball) not in self.phases:
            self.phases[name, ball] = Followed(self.problem, name, ball, self.balls, q, self.stop)
            self.phases[name, ball].driver.wanted = self.wanted
        return self.phases[name, ball]

    def _watch(self, phase: Followed) -> None:
        """Looks for the other ball, unless it has just left."""
        if not self.balls.stem:
            return
        for record, name in zip(phase.driver.rows.events, phase.names, strict=True):
            if name == "touch":
                record["watched"] = self.waits is None
                record["ends"] = Status.ENDED.code if self.waits is None else 0

    def _until(self, landing: Any, driver: Driver) -> None:
        """Sets the end of a phase: that of the run, or a landing before it."""
        self.landing = landing
        self.lands = landing is not None and landing < self.end
        driver.end_at(landing if self.lands else self.end)

    def _signs(self) -> dict[str, float]:
        """On which side of their zeros the functions of the axis are now, by name."""
        known = self.inner.tallies.functions[SIGN, :, 0].tolist()
        return {name: known[k] for k, name in self.phase.axis}

    # --- steps ----------------------------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps, through as many phases as they take."""
        output, steps, status = Gathered(self.problem, self.balls, request), 0, None
        while True:
            output.of(self.phase, self.carried, self.taken)
            if not self.clock[0] < self.end:  # a phase begins where the run ends, and takes no step
                when, status, state = self.end, Status.FINISHED, self.inner.state[None, : self.inner.variables]
                self.tally["upto"] = 0.0
                break
            piece = self.inner.advance(output, most - steps)
            steps += piece.steps
            when, status, state, ending = piece.time, piece.status, piece.last, self._ending(piece)
            output.sample(piece.samples)
            output.passed(piece.passages, len(piece.passages.times) - (ending is not None))
            if status is None or not (self.lands or ending is not None):
                break
            if status not in (Status.FINISHED, Status.LIFTOFF, Status.ENDED):
                break
            status = self._change(ending, state[0], when, output)
            full = steps >= most or self.changes % self.per_slice == 0
            if status is not None or (full and self.clock[0] < self.end):
                break
        if status is not None:
            self.tables.end(float(when), str(status.value))
        last = self.present() if status is None else self.rows(state)
        output.give()
        passages = output.passages()
        self._count(passages)
        return Slice(steps, when, last, output.sampled(), passages, status, self.tables.take())

    def _count(self, passages: Passages) -> None:
        """Put what the events of the run keep of passages into its tallies."""
        number, kept = 0, self.tallies.kept[:, 0]
        for e, event in enumerate(self.problem.system.events):
            mine = passages.events == e
            times = passages.times.astype(float)
            if event.lasting and mine.any():
                self.tallies.lane["lasts_since"] = times[mine][-1]
            for of_event in event.kept:
                meant = times[mine & (passages.signs == of_event.direction) if of_event.direction else mine]
                if of_event.what == "count":
                    kept[number] += len(meant)
                elif len(meant) and (of_event.what == "last" or np.isnan(kept[number])):
                    kept[number] = meant[-1 if of_event.what == "last" else 0]
                number += 1

    def _ending(self, piece: Slice) -> str | None:
        """The event that ended the present phase; None if none did."""
        if piece.status in (None, Status.FINISHED) or not len(piece.passages.events):
            return None
        event = self.phase.events[int(piece.passages.events[-1])]
        return event.name if event.ends and piece.status != Status.FALLEN else None

    def _change(self, ending: str | None, last: np.ndarray, when: Any, output: Gathered) -> Status | None:
        """What follows the end of a phase in a state (variables,); gives how it ends the run, or None."""
        moment = self._moment(last)
        self.changes += 1
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        signs, name = self._signs(), ending or ("landing" if self.waits is None else "clear")
        now = self.problem.number(when)
        self.transitions.left = self.end - now
        try:
            change = self.transitions.after(name, self.kind, self.ball, moment, signs)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        self.force = self.extremes()
        for event in change.events:
            output.note(event, now + change.when, last)
        if change.ends is not None:
            self.sentence = change.sentence
            self.tables.struck(float(when), change)
            return change.ends
        if ending == "liftoff" and self.problem.on_liftoff == "stop":
            return Status.LIFTOFF
        if self.short > 2:
            self.sentence = f"the contact changes its phase more often than every {CHATTER * self.tables.second:.1g} s"
        elif self.changes > MOST_CHANGES:
            self.sentence = f"the contact has changed its phase {MOST_CHANGES} times"
        if self.sentence:
            return Status.STALLED
        time = min(now + change.lag, self.end)
        self._enter(change, (time, 0 * time), now + change.when)
        if change.between is not None:
            fill_between(self, change, now, output)
        if change.strikes:
            before, after = (known.get("turning") for known in (signs, self._signs()))  # None: theta stays
            if before and after and before != after:  # theta has a corner, which ends a swing
                output.note("turning", now, last, after)
        return None

    def _moment(self, state: np.ndarray) -> Moment:
        """What a state (variables,) of the present phase says of the body; doubles become Python's numbers."""
        phase = self.phase
        numbers = state[: len(phase.record._fields)]
        place = phase.kind.place(phase.record(*(numbers.tolist() if state.dtype == float else numbers)), phase.body)
        return Moment._make((*place, phase.carried.into_rows(state[None], self.carried[None])[0]))

    # --- what is known of it --------------------------------------------------------------------------------------

    def extremes(self) -> Extremes:
        """Of the normal force so far, internal units."""
        a, b = self.force, self.inner.extremes()
        if (b.least > a.least and b.most < a.most) or self.inner.ranged < 0:
            return a
        low, high = (a if a.least <= b.least else b), (a if a.most >= b.most else b)
        return Extremes(low.least, low.t_least, high.most, high.t_most)

    @property
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""
        return self.inner.clock

    @property
    def state(self) -> np.ndarray:
        """All that the present phase integrates."""
        return self.inner.state

    def snapshot(self) -> dict[str, Any]:
        """What a run needs to continue bit by bit."""
        return {
            **self.inner.snapshot(),
            "kind": self.kind,
            "ball": self.ball,
            "carried": [parts_of(value) for value in self.carried],
            "taken": parts_of(self.taken),
            "force": list(self.force),
            "changes": [self.changes, self.short, self.began],
            "waits": self.waits is not None,
            "landing": None if self.landing is None else parts_of(self.landing),
            "under_way": self.tables.under_way,
            "counted": [list(self.tallies.lane[0].item()), self.tallies.kept[:, 0].tolist()],
        }

    @QUIET
    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continues from a snapshot, of which state and time come in the working precision. Raises ValueError if it is
        of another run."""
        number = self.problem.number
        carried = np.array([sum_of(parts, number) for parts in kept["carried"]], dtype=number)
        moment = moment_of(self.present()[0])._replace(carried=carried)
        self.taken = sum_of(kept["taken"], number)
        landing = None if kept["landing"] is None else sum_of(kept["landing"], number)
        self._enter(Change(kept["kind"], kept["ball"], moment, "start"), clock)
        self.inner.restore(kept, state, clock)
        self.waits = landing if kept["waits"] else None
        self._watch(self.phase)
        self._until(landing, self.inner)
        self.force = Extremes(*kept["force"])
        self.changes, self.short, self.began = kept["changes"]
        self.tables = Tables(self.problem)
        self.tables.under_way = kept["under_way"]
        self.tallies.lane[0], self.tallies.kept[:, 0] = tuple(kept["counted"][0]), kept["counted"][1]

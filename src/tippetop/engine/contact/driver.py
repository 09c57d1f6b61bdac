"""Drives a run from phase to phase: an ordinary driver for each, and a rule that says what follows.

To whoever asks it is a driver like any other; its states are rows (`mechanics.contact.phases.row.Row`).
"""

from typing import Any

import numpy as np

from ...mechanics.contact.ball import jellett
from ...mechanics.contact.phases.row import PHASES
from ...mechanics.doubledouble import parts_of, sum_of
from ...mechanics.events import ON_ZERO
from ...mechanics.systems.with_contact import kinds_of
from ...mechanics.units import SECOND
from ...mechanics.variables import INTEGRAL_SCALE
from ...problem import Problem
from ..expressions import equations_of_motion
from ..slices import Driver, Extremes, Passages, Request, Slice
from ..status import Status
from ..tallies import SIGN, reset
from .between import fill_between
from .impacts import moment_of
from .legs import Balls, Carried, new_leg, rows_of
from .passages import RunPassages
from .tables import Tables
from .transitions import Change, Transitions


MOST_CHANGES = 10_000  # of phase in a run
CHATTER = 1e-12  # internal time: phases so short, three in a row, lead nowhere
QUIET = np.errstate(invalid="ignore", divide="ignore", over="ignore")
"""Formulas of a phase are asked of states of another, such as the region of a patch that drills; what is no number in
the motion itself ends the run."""


class _Asked:
    """Passes the rows of a leg on to whoever asked for rows of the run."""

    def __init__(self, driver: "ContactDriver", request: Request):
        self.driver, self.request, self.steps = driver, request, request.steps

    def wanted(self) -> np.ndarray:
        return self.request.wanted()

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        self.request.take(times, self.driver.rows(states))


class ContactDriver:
    """Makes the steps of a run whose contact changes its phase.

    Parameters
    ----------
    problem
        The run.
    make
        make(leg) -> the ordinary driver of a phase.

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
    def __init__(self, problem: Problem, make: Any):
        self.problem, self.make = problem, make
        self.variables = len(problem.variables.names)
        self.balls, self.kinds = Balls(problem), kinds_of(problem.system.name)
        self.transitions = Transitions(problem, self.balls)
        self.end = problem.number(problem.until) / problem.number(float(problem.scales.of(SECOND)))
        self.drivers: dict[tuple[str, int], tuple[Driver, Carried]] = {}
        self.force, self.tables = Extremes(), Tables(problem)
        self.changes = self.short = 0
        self.taken: Any = problem.number(0)
        self.times, self.sentence = np.zeros(0), ""
        start = problem.start()
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
    def inner(self) -> Driver:
        """The driver of the present phase."""
        return self.drivers[self.kind, self.ball][0]

    @property
    def compiled(self) -> Any:
        """What the present phase is compiled to."""
        return self.inner.compiled

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
            if (kind, self.ball) not in self.drivers:
                how = self.kinds[kind]
                self._add(kind, self.ball, how.state(moment.u, moment.L, moment.velocity, moment.height, self.balls[0]))

    def equations(self) -> list[tuple]:
        """The equations of every phase that the run may have, by name."""
        lines = []
        for name in (*self.transitions.names, *self.transitions.standing):
            system = new_leg(self.problem, name, self.balls[0], np.zeros(1)).system
            variables = type(self.problem.variables)(next(iter(system.forms.values())), self.problem.orientation)
            friction = type(self.balls[0].friction)
            lines += equations_of_motion(system, variables, friction).rates
        return lines

    def rows(self, states: np.ndarray) -> np.ndarray:
        """States (n, variables) of the present phase as rows."""
        kind, carried = self.kinds[self.kind], self.drivers[self.kind, self.ball][1]
        integrals = carried.into_rows(states, self.carried)
        return rows_of(kind, self.ball, self.balls, states, integrals, self.taken, self.problem.number)

    def present(self) -> np.ndarray:
        """The row of the present state, (1, variables)."""
        return self.rows(self.inner.state[None, : self.inner.variables])

    def _enter(self, change: Change, clock: tuple[Any, Any], since: Any = None) -> None:
        """Takes up a phase at a time of the clock; it began then, or somewhat earlier at `since`."""
        self.kind, self.ball, moment = change.kind, change.ball, change.moment
        if change.reason:
            began = float(clock[0] if since is None else since)
            self.tables.begin(PHASES.index(self.kinds[self.kind].phase), self.ball, began, change)
        kind, body, number = self.kinds[self.kind], self.balls[self.ball], self.problem.number
        q = kind.state(moment.u, moment.L, moment.velocity, moment.height, body)
        if change.takes:
            lost = moment.carried[self.transitions.lost] / INTEGRAL_SCALE if self.transitions.lost >= 0 else 0
            self.taken = number(jellett(moment.u, moment.L, self.transitions.ball(self.ball))) + lost
        self.carried = moment.carried
        if (self.kind, self.ball) not in self.drivers:
            self._add(self.kind, self.ball, q)
        driver, carried = self.drivers[self.kind, self.ball]
        state = np.zeros(len(driver.state), dtype=number)
        state[: len(q)] = q
        carried.into_state(self.carried, state)
        driver.put(state, clock)
        driver.times = self.times
        self._expect(driver, q, change.signs)
        landing, self.waits = change.landing, None
        if change.waits:
            self.waits = landing = clock[0] + number(change.waits)
        elif landing is not None:
            landing = clock[0] + number(landing)
        self._watch(driver)
        self._until(landing, driver)
        driver.tally["t"] = float(clock[0])
        self.began = float(clock[0])

    def _add(self, kind: str, ball: int, q: Any) -> None:
        """Makes the ordinary driver of a phase, of a state that it may have."""
        first = np.zeros(len(q) + self._integrals(), dtype=self.problem.number)
        first[: len(q)] = q
        part = new_leg(self.problem, kind, self.balls[ball], first)
        part = new_leg(self.problem, kind, self.balls[ball], first[: len(part.variables.names)])
        with np.errstate(
            invalid="ignore", divide="ignore"
        ):  # of friction that drills the state may be of another region
            self.drivers[kind, ball] = self.make(part), Carried(self.problem, part)

    def _watch(self, driver: Driver) -> None:
        """Looks for the other ball, unless it has just left."""
        records, events = driver.rows.events, driver.problem.system.events
        for record, event in zip(records, events, strict=True):
            if event.name == "touch":
                record["watched"] = self.waits is None
                record["ends"] = Status.ENDED.code if self.waits is None else 0

    def _until(self, landing: Any, driver: Driver) -> None:
        """Sets the end of a phase: that of the run, or a landing before it."""
        self.landing = landing
        self.lands = landing is not None and landing < self.end
        driver.end_at(landing if self.lands else self.end)

    def _integrals(self) -> int:
        return len(self.problem.variables.names) - self.problem.variables.moving

    def _expect(self, driver: Driver, q: Any, signs: dict[str, float]) -> None:
        """Says on which side of their zeros the event functions begin."""
        body = self.balls[self.ball]
        scalars = driver.problem.form.scalars(q, body)
        events = driver.problem.system.events
        values = np.array([float(event.formula(scalars, body)) for event in events])
        at = np.where(values > 0, 1.0, -1.0)
        on_zero = np.abs(values) < ON_ZERO
        for k, event in enumerate(events):
            if event.name in signs:  # it continues from the phase before
                at[k], on_zero[k] = signs[event.name], False
            elif event.name in ("stick", "slip"):
                at[k], on_zero[k] = at[k] if event.direction == 0 else 1.0, False
            elif event.name in ("faster", "slower") and abs(values[k]) < ON_ZERO:
                at[k], on_zero[k] = -float(event.direction), True
            elif event.name == "touch" and on_zero[k]:
                at[k] = 1.0
        reset(driver.tallies, driver.rows, 0, at, on_zero)

    def _signs(self) -> dict[str, float]:
        """On which side of their zeros the functions of the axis are now, by name."""
        inner = self.inner
        names = [event.name for event in inner.problem.system.events]
        return {
            name: float(inner.tallies.functions[SIGN, k, 0])
            for k, name in enumerate(names)
            if name in ("turning", "equator", "inverted")
        }

    # --- steps ----------------------------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Makes at most so many steps, through as many phases as they take."""
        asked, log, samples, steps = _Asked(self, request), RunPassages(self.problem), [], 0
        while True:
            piece = self.inner.advance(asked, most - steps)
            steps += piece.steps
            when, status, ending = piece.time, piece.status, self._ending(piece)
            count, first = len(piece.passages.times) - (ending is not None), len(piece.samples)
            passages = Passages(*(column[:count] for column in piece.passages))
            rows = self.rows(np.concatenate([piece.samples, passages.states, piece.last]))
            last = rows[-1:]
            samples.append(rows[:first])
            log.add(passages, self.inner.problem.system, rows[first:-1])
            if status is None or not (self.lands or ending is not None):
                break
            if status not in (Status.FINISHED, Status.LIFTOFF, Status.ENDED):
                break
            status = self._change(ending, last, when, log, request)
            if status is not None or steps >= most:
                break
        if status is not None:
            self.tables.end(float(when), str(status.value))
        last = self.present() if status is None else last
        return Slice(steps, when, last, np.concatenate(samples), log.passages(), status, self.tables.take())

    def _ending(self, piece: Slice) -> str | None:
        """The event that ended the present phase; None if none did."""
        if piece.status in (None, Status.FINISHED) or not len(piece.passages.events):
            return None
        event = self.inner.problem.system.events[int(piece.passages.events[-1])]
        return event.name if event.ends and piece.status != Status.FALLEN else None

    def _change(
        self, ending: str | None, last: np.ndarray, when: Any, log: "RunPassages", request: Request
    ) -> Status | None:
        """What follows the end of a phase; gives how it ends the run, or None."""
        moment = moment_of(last[0])
        self.changes += 1
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        signs, name = self._signs(), ending or ("landing" if self.waits is None else "clear")
        try:
            change = self.transitions.after(name, self.kind, self.ball, moment, signs)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        self._merge_force()
        self.times = self.inner.times
        time = self.problem.number(when) + change.lag
        for event in change.events:
            row_after = last if event == "liftoff" else None
            log.note(event, self.problem.number(when) + change.when, last if row_after is None else row_after)
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
        self._enter(change, (time, 0 * time), self.problem.number(when) + change.when)
        if change.between is not None:
            fill_between(self, change, self.problem.number(when), log, request)
        before, after = (known.get("turning") for known in (signs, self._signs()))  # None: theta stays
        if (
            change.strikes and before and after and before != after
        ):  # theta has a corner, which ends a swing as a turning does
            log.note("turning", self.problem.number(when), last, after)
        return None

    # --- what is known of it --------------------------------------------------------------------------------------

    def _merge_force(self) -> None:
        self.force = self.extremes()

    def extremes(self) -> Extremes:
        """Of the normal force so far, internal units."""
        a, b = self.force, self.inner.extremes()
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
        }

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
        self._watch(self.inner)
        self._until(landing, self.inner)
        self.force = Extremes(*kept["force"])
        self.changes, self.short, self.began = kept["changes"]
        self.tables = Tables(self.problem)
        self.tables.under_way = kept["under_way"]

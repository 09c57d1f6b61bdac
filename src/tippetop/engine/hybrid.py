"""One run of a system of several phases: an ordinary driver for each, and jumps from one to another.

Jumps are functions of the common state, which every phase can be read as; the driver knows neither balls nor laws.
"""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..mechanics.events import ON_ZERO as BELOW
from ..mechanics.events import Event
from ..mechanics.form import CLOCK, Next, Phase
from ..mechanics.moment import moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..mechanics.variables import INTEGRAL_SCALE, Variables
from ..problem import Problem
from .driver import Driver, Extremes, Passages, Request, Slice, Wanted, extremes_of
from .expressions import Formulas
from .phase_tables import PhaseTables
from .sampled import Sampler
from .status import Status
from .tallies import COUNT, LAST, ON_ZERO, SIGN, EventRows, event_rows, mark_bounded, new_tallies


MOST_CHANGES = 10_000  # of phase in a run
PER_SLICE = 64  # changes: a slice ends after them, so that nobody waits for it; by no clock, for stores say where
CHATTER = 1e-12  # internal time: phases so short, three in a row, lead nowhere
QUIET = np.errstate(invalid="ignore", divide="ignore", over="ignore")
"""Jumps evaluate formulas outside their region; a motion that is not finite ends the run."""


@lru_cache(maxsize=256)
def formulas_of_phase(system: System, phase: Phase, body: Any, friction: Any) -> Formulas:
    """Return the formulas of a phase, whose parameters are a record of type `body` with this record of a law."""
    form = phase.form
    of_phases = {event.name for other in system.phases.values() for event in other.events}
    common = tuple(event for event in system.events if event.formula and event.name not in of_phases)
    own = tuple(event for event in phase.events if event.formula is not None and not event.sampled)
    events = (*own, *common)
    template = body(*(friction._make(friction._fields) if name == "friction" else 1.0 for name in body._fields))
    folds = {name: value for name, value in system.folds(form).items() if name in body._fields}

    def functions(q: Any, carried: Any, b: Any) -> list:
        state = form.scalars(q, b)
        values = [event.formula(state, b) for event in own]
        if common:
            whole, first = system.read(phase, q, carried, b) if system.read else (phase.leave(q, b), b)
            read = moment(system, system.phase.form, whole, carried, first)
            values += [event.formula(read, first) for event in common]
        return values

    return Formulas(form, events, functions, lambda values: refill(template, values)._replace(**folds))


class Track:
    """A phase that a run may have, and the driver that follows it.

    Parameters
    ----------
    run
        The run.
    name
        Of the phase.
    """

    def __init__(self, run: "HybridDriver", name: str):
        from .taylor import code_for, kind_of_driver

        problem = run.problem
        self.name, self.phase = name, run.phases[name]
        phase = self.phase
        self.b = phase.parameters(run.body)
        self.exits = {exit.event: exit.jump for exit in phase.exits}
        self.formulas = formulas_of_phase(problem.system, phase, self.b.__class__, self.b.friction.__class__)
        code = code_for(problem, self.formulas, run.stop)
        variables = Variables(phase.form, problem.orientation)
        self.moving, self.record = variables.moving, type(phase.form.units)
        of_run, names = run.carried._fields, variables.names[variables.moving :]
        self.mine = np.array([variables.moving + k for k, name in enumerate(names) if name in of_run], int)
        self.theirs = np.array([of_run.index(name) for name in names if name in of_run], int)
        self.events = self.formulas.events
        self.numbers = [run.numbers[event.name] for event in self.events]
        self.records = self._records(run, code.rows.events)
        rows = run.rows._replace(events=self.records, axis=code.rows.axis)
        start, functions = np.zeros(len(variables.names), problem.number), np.zeros(len(rows.events))
        self.driver: Driver = kind_of_driver(problem)(
            code,
            rows,
            leaves(self.b),
            start,
            functions,
            run.end,
            run.tallies,
            self.numbers[code.lasting] if code.lasting >= 0 else -1,
        )
        self.driver.wanted = run.row_times
        sampled = [event for event in phase.events if event.sampled]
        self.sampler = Sampler(self.driver, leaves(self.b), sampled, self._value) if sampled else None

    def _value(self, state: np.ndarray, event: Event) -> Any:
        """Return the value of an event in a state of the phase."""
        return event.formula(self.phase.form.scalars(self.record(*state[: self.moving].tolist()), self.b), self.b)

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the events of the run, of which those of this phase are looked for."""
        records = run.rows.events.copy()
        for flag in ("extremes", "watched", "ranged"):
            records[flag] = False
        records["ends"], records["leader"] = 0, -1
        kept = records[["first", "last"]].copy()
        for k, (number, event) in enumerate(zip(self.numbers, self.events, strict=True)):
            records[number] = mine[k]
            records[number]["watched"] = not event.sense or event.name in run.problem.events
            leader = mine[k]["leader"]
            records[number]["leader"] = self.numbers[leader] if leader >= 0 else -1
            for place in ("first", "last"):  # jumps log their events themselves
                records[number][place] = 0 if event.name in self.exits else kept[number][place]
        mark_bounded(records)
        return records

    def state(self, x: Any, whole: np.ndarray) -> np.ndarray:
        """Return the variables of the phase in a common state, and the integrals of the run, scaled."""
        q = self.phase.enter(x, self.b)
        state = np.zeros(len(self.driver.state), dtype=whole.dtype)
        state[: len(q)] = q
        state[self.mine] = whole[self.theirs]
        return state

    def integrals(self, state: np.ndarray, carried: np.ndarray) -> np.ndarray:
        """Return the integrals of the run, scaled, of which the phase has moved some."""
        whole = carried.copy()
        whole[self.theirs] = state[self.mine]
        return whole

    def common(self, state: np.ndarray, carried: np.ndarray, record: Any) -> Any:
        """Return the common state of the variables of the phase; doubles become floats, which formulas take faster."""
        numbers = state[: self.moving]
        q = self.record(*(numbers.tolist() if state.dtype == float else numbers))
        whole = self.integrals(state, carried)
        integrals = whole * whole.dtype.type(1 / INTEGRAL_SCALE)
        x = self.phase.leave(q, self.b)
        if not hasattr(x, "carried"):
            return x
        return x._replace(carried=record(*(integrals.tolist() if state.dtype == float else integrals)))


@dataclass(eq=False)
class Part:
    """States of a phase, (n, variables), that become rows of the run."""

    track: Track
    carried: np.ndarray  # the integrals of the run, scaled, of which the phase moves some: (k,), or (n, k) of all
    states: np.ndarray
    rows: Any = None


class HybridDriver:
    """Makes the steps of a run through its phases.

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
        Why a jump ended the run; empty where none did.
    ended
        How a jump ends the run before its first step; None: it does not.
    """

    ended: Status | None = None
    sentence = ""
    track: Track

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        system, number = problem.system, problem.number
        self.problem, self.stop, self.number = problem, stop, number
        self.variables = len(problem.variables.names)
        self.end = number(problem.until) / number(float(problem.scales.of(SECOND)))
        self.body, self.phases = _assembled(problem)
        self.carried = problem.variables.carried
        events = {event.name: event for event in system.events}
        for phase in self.phases.values():
            events = {event.name: event for event in phase.events} | events
        every = [*system.events, *(event for name, event in events.items() if name not in system.kinds)]
        self.rows: EventRows = event_rows(every, [(0, 1, 1.0, 0.0)] * len(every), ())
        self.numbers = {event.name: k for k, event in enumerate(every)}
        in_phases = [event for phase in self.phases.values() for event in phase.events]
        for event in in_phases:
            self.rows.events[self.numbers[event.name]]["extremes"] |= bool(event.extremes)
        self.lasting = {event.name for event in every if event.lasting}
        self.tallies = new_tallies(self.rows, 1)
        self.tallies.functions[SIGN] = 0.0  # not known
        self.row_times, self.tables = Wanted(), PhaseTables(problem)
        self.tracks: dict[str, Track] = {}
        self.changes = self.short = 0
        self.live: set[str] = set()
        self.parts: list[Part] = []
        self.world = SimpleNamespace(
            body=self.body, system=system, rules=problem.contact, phases=self.phases, phase=None, left=self.end,
            rates=self._rates,
        )  # fmt: skip
        if problem.contact is not None:
            from .impacts import Impacts

            self.world.struck = Impacts(problem, self.body[0].friction, stop).struck
        start = problem.start()
        q, carried = problem.variables.split(start.tolist() if start.dtype == float else start)
        self.whole = start[problem.variables.moving :].copy()
        x = system.common.leave(q, carried) if system.common else system.phase.leave(q, self.body)
        try:
            n = system.begin(x, self.world) if system.begin else Next(next(iter(self.phases)), x, "start")
        except ArithmeticError as error:
            n = Next(next(iter(self.phases)), x, "start", ends="stalled", message=str(error))
        self._enter(n, number(0), None)
        if n.ends:
            self.ended, self.sentence = Status(n.ends), n.message
        self.first = self.present()

    # --- phases ---------------------------------------------------------------------------------------------------

    def track_of(self, name: str) -> Track:
        """Return the phase of this name, compiled when it is first entered."""
        if name not in self.tracks:
            self.tracks[name] = Track(self, name)
        return self.tracks[name]

    def prepare(self) -> None:
        """Compile the phases that the present one may lead to, and those after them."""
        waiting = [self.track.name]
        while waiting:
            track = self.track_of(waiting.pop())
            following = {name for exit in track.phase.exits for name in exit.to}
            waiting += [name for name in following if name not in self.tracks]

    def equations(self) -> list[tuple]:
        """Return the equations of every phase: pairs of a variable and its rate."""
        return [pair for name in self.phases for pair in self.track_of(name).driver.equations()]

    def _rates(self, phase: Phase, q: Any, carried: Any, b: Any = None) -> list:
        """Return the rates of the integrals of the run in a state of a phase; 0 for those that it does not move. `b` is
        the body in the numbers of the state, if they are others."""
        integrals = Variables(phase.form, self.problem.orientation).integrals
        rates = {integral.name: integral.rate for integral in integrals}
        b = b or phase.parameters(self.body)
        return [rates[name](q, carried, b) if name in rates else 0.0 for name in carried._fields]

    def _enter(self, n: Next, now: Any, before: np.ndarray | None) -> None:
        """Take up what follows a state `before` of the present phase, at an internal time."""
        old = None if before is None else (self.track, self.whole, before)
        track = self.track = self.track_of(n.phase)
        self.world.phase = track.phase
        if n.cause != "":
            self.tables.begin(track.phase, float(now + n.logged_after), n.cause or "")
        self.tables.add(float(now), n.rows)
        time = min(now + self.number(n.delay), self.end)
        if hasattr(n.x, "carried"):
            self.whole = np.array([self.number(value) * INTEGRAL_SCALE for value in n.x.carried], dtype=self.number)
        state = track.state(n.x, self.whole)
        track.driver.put(state, (time, 0 * time))
        self.waits = n.delay > 0 and n.series is None
        self._begin_events(n, track, state, now, old)
        lane = self.tallies.lane
        lane["status"], lane["upto"], lane["tiny"], lane["steps"] = Status.RUNNING.code, 1.0, 0, 0
        lane["t"] = self.began = float(time)
        self._set_clock(None if n.lasts is None else time + self.number(n.lasts))

    def _set_clock(self, clock: Any) -> None:
        """Set the end of the phase."""
        self.clocked = clock is not None and clock < self.end
        self.until = clock
        self.track.driver.end_at(clock if self.clocked else self.end)

    def _begin_events(self, n: Next, track: Track, state: np.ndarray, now: Any, old: Any) -> None:
        """Write on which side of their zeros the event functions of a phase begin."""
        functions, live = self.tallies.functions, set()
        q = track.record(*(state[: track.moving].tolist() if state.dtype == float else state[: track.moving]))
        values = track.formulas.functions(q, self._integrals(), track.b)
        if n.series is not None:
            self._fill(n, track, now)
        for number, event, value in zip(track.numbers, track.events, values, strict=True):
            name, value = event.name, float(value)
            by_value, zero = 1.0 if value > 0 else -1.0, 0
            if name in track.exits:
                sign = n.sides.get(name, by_value if event.direction == 0 else -event.direction)
                zero = -n.zeros.get(name, 0)
            elif name in self.live:
                known = functions[SIGN, number, 0]
                sign = known if abs(value) < BELOW else by_value
                if sign != known and n.series is not None:
                    self._note_along(n, track, event, known, now)
                elif sign != known and old and (event.sense or (event.lasting and sign == event.direction)):
                    self._note(name, now, Part(old[0], old[1], old[2][None]), int(sign))  # of theta: it has a corner
            else:
                sign, zero = by_value, abs(value) < BELOW
            if name not in track.exits:
                live.add(name)
            functions[SIGN, number, 0], functions[ON_ZERO, number, 0] = sign, zero
        self.live = live

    def _integrals(self) -> Any:
        """Return the integrals of the run as they are now, whole again."""
        return self.carried._make(self.whole * self.number(1 / INTEGRAL_SCALE))

    # --- steps ----------------------------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Make at most so many steps, through as many phases as they take."""
        self.request, self.steps, self.parts = request, request.steps, []
        self.asked: list[tuple[np.ndarray, Part]] = []
        self.samples: list[Part] = []
        self.log: list[tuple[Passages, Part]] = []
        steps, status = 0, None
        while True:
            if not self.clock[0] < self.end:  # a phase begins where the run ends, and takes no step
                when, status, state = self.end, Status.FINISHED, self.state[None, :]
                self.tally["upto"] = 0.0
                break
            driver = self.track.driver
            if self.waits:
                self._rows_before()
            sampled = self._sample()
            piece = driver.advance(self, 1 if self.track.sampler else most - steps)
            steps += piece.steps
            when, status, state = piece.time, piece.status, piece.last
            ending = sampled if sampled and piece.status is Status.FINISHED else self._ending(piece)
            if len(piece.samples):
                self.samples.append(self._part(piece.samples))
            count = len(piece.passages.times) - (ending not in (None, CLOCK, sampled))
            if count:
                passages = Passages(*(column[:count] for column in piece.passages))
                self.log.append((passages, self._part(passages.states)))
            if ending is None and (status is not None or steps >= most or not self.track.sampler):
                break
            if ending is None:
                continue
            status = self._jump(ending, state[0], when)
            full = steps >= most or self.changes % PER_SLICE == 0
            if status is not None or (full and self.clock[0] < self.end):
                break
        if status is not None:
            self.tables.end(float(when))
        last = self.present() if status is None else self._rows([self._part(state)])[0]
        passages = self._hand_over()
        return Slice(steps, when, last, self._joined(self.samples), passages, status, self.tables.take())

    def _sample(self) -> str:
        """Let the phase end where a sampled event happens in its next step. Return that event, or nothing."""
        driver, sampler = self.track.driver, self.track.sampler
        if not sampler:
            return ""
        driver.end_at(self.until if self.clocked else self.end)
        first = sampler.next()
        if not first or not first[1] < driver.end:
            return ""
        driver.end_at(first[1])
        return str(first[0])

    def _ending(self, piece: Slice) -> str | None:
        """Return the exit by which the present phase ends; None if it does not, or ends the run."""
        if piece.status is Status.FINISHED:
            return CLOCK if self.clocked else None
        if piece.status is None or not len(piece.passages.events):
            return None
        number = int(piece.passages.events[-1])
        event = self.track.events[self.track.numbers.index(number)]
        ends = self.track.driver.rows.events[number]["ends"]
        return event.name if ends and event.name in self.track.exits else None

    def _jump(self, ending: str, state: np.ndarray, when: Any) -> Status | None:
        """Take up what follows the end of a phase in a state (variables,). Return how it ends the run, or None."""
        self.changes += 1
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        now = self.number(when)
        self.world.left = self.end - now
        track = self.track
        x = track.common(state, self.whole, self.carried)
        self.whole = track.integrals(state, self.whole)
        try:
            n = track.exits[ending](x, self.world)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        part = self._part(state[None])
        for name in n.logged:
            self._note(name, now + n.logged_after, part, 1)
        if n.ends:
            self.sentence = n.message
            self.tables.add(float(when), n.rows)
            return Status(n.ends)
        if ending == Status.LIFTOFF.value and self.problem.on_liftoff == "stop":
            return Status.LIFTOFF
        if self.short > 2:
            self.sentence = f"the contact changes its phase more often than every {CHATTER * self.tables.second:.1g} s"
        elif self.changes > MOST_CHANGES:
            self.sentence = f"the contact has changed its phase {MOST_CHANGES} times"
        if self.sentence:
            return Status.STALLED
        self._enter(n, now, state)
        return None

    # --- rows -----------------------------------------------------------------------------------------------------

    def wanted(self) -> np.ndarray:
        """Internal times of the next rows, or room for so many."""
        return self.request.wanted()

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Take states of the present phase that were asked for."""
        self.asked.append((times, self._part(np.array(states))))

    def _part(self, states: np.ndarray, carried: np.ndarray | None = None) -> Part:
        return Part(self.track, self.whole if carried is None else carried, states)

    def _note(self, name: str, time: Any, part: Part, sign: int) -> None:
        """Log an event that no step has logged, in a state of a phase."""
        number = self.numbers[name]
        times = np.array([time], dtype=self.number)
        self.log.append((Passages(times, np.array([number]), np.array([sign]), np.zeros(1, bool), part.states), part))
        if name in self.lasting:
            self.tally["lasts_since"] = float(time)
        first, last = (int(self.rows.events[number][place]) for place in ("first", "last"))
        for place in range(first, last):
            what, direction = self.rows.numbers[place]
            kept = self.tallies.kept[:, 0]
            if direction * sign < 0:
                continue
            if what == COUNT:
                kept[place] += 1
            elif what == LAST or np.isnan(kept[place]):
                kept[place] = float(time)

    def _series(self, n: Next, track: Track, t: np.ndarray) -> Part:
        """Return states at times since the beginning of a jump that takes time."""
        q, carried = n.series(t)
        states, whole = (
            np.array([[self.number(one) for one in np.broadcast_to(value, t.shape)] for value in record]).T
            for record in (q, carried)
        )
        whole = whole * self.number(INTEGRAL_SCALE)
        return Part(track, whole, states)

    def _rows_before(self) -> None:
        """Give the rows that are wanted of a jump that is too short for a series: the state at its end."""
        self.waits = False
        while not self.steps:
            self.row_times.ask(self)
            left = self.row_times.left
            count = int(np.searchsorted(left, self.began))
            if count:
                self.asked.append((left[:count], self._part(np.repeat(self.state[None, :], count, axis=0))))
            self.row_times.made += count
            if count < len(left) or not count:
                break

    def _fill(self, n: Next, track: Track, now: Any) -> None:
        """Give the rows that are wanted of a jump that takes time."""
        while not self.steps:
            self.row_times.ask(self)
            left = self.row_times.left
            count = int(np.searchsorted(left, float(now + n.delay)))
            if count:
                since = left[:count].astype(self.number) - now
                t = np.array([min(max(one, 0 * n.delay), n.delay) for one in since])
                self.asked.append((left[:count], self._series(n, track, t)))
            self.row_times.made += count
            if count < len(left) or not count:
                break

    def _note_along(self, n: Next, track: Track, event: Event, known: float, now: Any) -> None:
        """Log an event that happens in a jump that takes time."""
        k = track.events.index(event)

        def function(t: Any) -> float:
            q, carried = n.series(np.array([t]))
            q = track.record(*(value[0] if np.ndim(value) else value for value in q))
            return float(track.formulas.functions(q, carried, track.b)[k])

        t = zero_of(function, known, n.delay)
        self._note(event.name, now + t, self._series(n, track, np.array([t])), -int(known))

    def _rows(self, parts: list[Part]) -> list[np.ndarray]:
        """Return the rows of parts: those of one phase are made together."""
        alike: dict[Track, list[Part]] = {}
        for part in parts:
            if part.rows is None:
                alike.setdefault(part.track, []).append(part)
        split, system = self.problem.variables.carried, self.problem.system
        for track, some in alike.items():
            lengths = [len(part.states) for part in some]
            n = sum(lengths)
            carried, states = np.empty((n, len(self.whole)), self.number), np.empty((n, track.moving), self.number)
            first = 0
            for part, length in zip(some, lengths, strict=True):
                some_rows = slice(first, first + length)
                states[some_rows] = part.states[:, : track.moving]
                carried[some_rows] = part.carried
                if part.carried.ndim == 1:
                    carried[some_rows, track.theirs] = part.states[:, track.mine]
                first += length
            q = track.record(*states.T)
            with_units = split(*(carried * self.number(1 / INTEGRAL_SCALE)).T)
            record = system.row(track.phase, q, with_units, self.body) if system.row else track.phase.leave(q, track.b)
            rows = np.empty((n, self.variables), self.number)
            moving = self.variables - len(self.whole)
            for k, value in enumerate(record[:moving]):
                rows[:, k] = value
            rows[:, moving:] = carried
            first = 0
            for part, length in zip(some, lengths, strict=True):
                part.rows, first = rows[first : first + length], first + length
        return [part.rows for part in parts]

    def _hand_over(self) -> Passages:
        """Make rows of all that waits, give those that were asked for, and return the passages."""
        self._rows([*(part for _, part in self.asked), *self.samples, *(part for _, part in self.log)])
        if self.asked:
            times = np.concatenate([times for times, _ in self.asked])
            self.request.take(times, self._joined([part for _, part in self.asked]))
        none = np.zeros(0, int)
        empty = np.zeros(0, self.number), none, none, none > 0
        columns = [empty, *(passages[:-1] for passages, _ in self.log)]
        rows = self._joined([part for _, part in self.log])
        return Passages._make((*map(np.concatenate, zip(*columns, strict=True)), rows))

    def _joined(self, parts: list[Part]) -> np.ndarray:
        rows = self._rows(parts)
        return np.concatenate(rows) if rows else np.zeros((0, self.variables), self.number)

    # --- where the run is -----------------------------------------------------------------------------------------

    @property
    def tally(self) -> Any:
        """What the observer knows of the run."""
        return self.tallies.lane[0]

    @property
    def at_start(self) -> np.ndarray:
        """No event function ends the run at once: the phase of the start is chosen."""
        return np.ones(len(self.problem.system.events))

    @property
    def is_called(self) -> bool:
        """Whether Python calls heyoka for each step of the present phase."""
        return self.track.driver.is_called

    @property
    def clock(self) -> tuple[Any, Any]:
        """Internal time, in double length."""
        return self.track.driver.clock

    @property
    def state(self) -> np.ndarray:
        """All that the present phase integrates."""
        return self.track.driver.state

    def present(self) -> np.ndarray:
        """Return the row of the present state, (1, variables)."""
        return self._rows([self._part(self.state[None, :].copy())])[0]

    def extremes(self) -> Extremes:
        """Return those of the normal force so far, internal units."""
        known = [extremes_of(track.driver.rows.events, self.tallies) for track in self.tracks.values()]
        known = [one for one in known if np.isfinite(one.least)]
        if not known:
            return Extremes()
        low, high = min(known, key=lambda one: one.least), max(known, key=lambda one: one.most)
        return Extremes(low.least, low.t_least, high.most, high.t_most)

    @property
    def width(self) -> int:
        """The greatest number of variables of a phase."""
        orientation = self.problem.orientation
        return max(len(Variables(p.form, orientation).names) + len(self.rows.events) for p in self.phases.values())

    def snapshot(self) -> dict[str, Any]:
        """Return what a run needs to continue bit by bit: lists of the same lengths in every phase, but for `state`."""
        under_way = self.tables.under_way or [math.nan] * 4
        phase = [list(self.phases).index(self.track.name), self.changes, self.short, self.began]
        phase += [self.until is not None, self.waits]
        return {
            **self.track.driver.snapshot(),
            "phase": [*phase, *under_way, *(name in self.live for name in self.numbers)],
            "carried": [*self.whole, self.number(0) if self.until is None else self.until],
        }

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot, of which state and time come in the working precision."""
        phase, self.changes, self.short, self.began, has_clock, self.waits, *rest = kept["phase"]
        under_way, live = rest[:4], rest[4:]
        self.track = track = self.track_of(list(self.phases)[int(phase)])
        self.world.phase = track.phase
        *whole, until = kept["carried"]
        self.whole = np.array(whole, dtype=self.number)
        track.driver.restore(kept, state[: len(track.driver.state)], clock)
        self.live = {name for name, is_live in zip(self.numbers, live, strict=True) if is_live}
        self._set_clock(until if has_clock else None)
        self.tables = PhaseTables(self.problem)
        self.tables.under_way = None if math.isnan(under_way[0]) else [under_way[0], *map(int, under_way[1:])]


def _assembled(problem: Problem) -> tuple[Any, Mapping[str, Phase]]:
    """Return the body of a run as its phases take it, and the phases."""
    system = problem.system
    if system.assembled is None:
        return problem.internal_body, system.phases

    def internal(value: float, unit: Any) -> Any:
        return problem.number(problem.exact(value) * (problem.exact(1) / problem.exact(problem.scales.of(unit))))

    return system.assembled(problem.internal_body, problem.contact, internal)


def zero_of(function: Any, sign: float, end: Any) -> Any:
    """Return where a function that begins with a sign has its zero, in [0, end]."""
    low, high = 0 * end, end
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if function(middle) * sign > 0 else (low, middle)
    return high

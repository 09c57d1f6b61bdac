"""One run of a system of several phases: an ordinary driver for each, and jumps from one to
another.

Jumps are functions of the common state, which every phase can be read as; the driver does not
depend on balls or laws.
"""

import math
import threading
import weakref
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanics.event import ON_ZERO as BELOW
from ..mechanics.event import Event
from ..mechanics.form import CLOCK, Exit, Next, Phase
from ..mechanics.moment import moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..mechanics.variables import INTEGRAL_SCALE, Variables
from ..problem import Problem
from .changes import Changes
from .driver import (
    PASSAGES,
    RUNNING,
    STATUSES,
    STEPS_PER_SLICE,
    Driver,
    Extremes,
    Passages,
    Place,
    Request,
    Shared,
    Slice,
    Wanted,
    extremes_of,
    view,
)
from .expressions import Formulas
from .impacts import ImpactMotions, Kind, Pieces, kind_of
from .loop import MOST_COEFFICIENTS, Rows
from .phase_tables import PhaseTables
from .python_events import Sampler, zero_of
from .status import Status
from .tallies import (
    ON_ZERO,
    SIGN,
    event_rows,
    new_log,
    new_samples,
    new_tallies,
)
from .wide import WideDriver


MOST_CHANGES = 10_000  # of phase in a run
# End a slice after this many changes. A fixed count, not a time limit, keeps stores reproducible.
PER_SLICE = 256
CHATTER = 1e-12  # internal time: phases so short, three in a row, lead nowhere
ROOT, SLOPE, NEAR = 1e-6, 1e-3, 1e-6
"""Least value of an event function, of order one, that is no root; least rate of one that has a
multiple root; and the time over which the rate is taken.
"""
QUIET = np.errstate(invalid="ignore", divide="ignore", over="ignore")
"""Jumps evaluate formulas outside their region; a motion that is not finite ends the run."""


@lru_cache(maxsize=256)
def formulas_of_phase(system: System, phase: Phase, body: Any, friction: Any) -> Formulas:
    """Return the formulas of a phase, whose parameters are a record of type `body` with this record
    of a law.
    """
    form = phase.form
    own = [event for event in phase.events if event.formula and not event.sampled]
    of_phases = {event.name for other in system.phases.values() for event in other.events}
    common = [event for event in system.events if event.formula and event.name not in of_phases]
    template = body(
        *(friction._make(friction._fields) if name == "friction" else 1.0 for name in body._fields)
    )
    folds = {name: value for name, value in system.folds(form).items() if name in body._fields}

    def functions(q: Any, carried: Any, b: Any) -> list:
        state = form.scalars(q, b)
        values = [event.formula(state, b) for event in own]
        if common:
            whole, first = (
                system.read(phase, q, carried, b) if system.read else (phase.leave(q, b), b)
            )
            read = moment(system, system.phase.form, whole, carried, first)
            values += [event.formula(read, first) for event in common]
        return values

    events = *own, *common
    return Formulas(
        form, events, functions, lambda values: refill(template, values)._replace(**folds)
    )


class World(NamedTuple):
    """Context of a jump in addition to the state: see `form.Exit`."""

    body: Any
    system: System
    rules: Any
    phases: Mapping[str, Phase]
    phase: Phase | None
    left: Any
    variables: Variables  # of the rows of the run
    struck: Any  # of a body whose contact may open: see `exits`

    def rates(self, phase: Phase, q: Any, carried: Any, b: Any = None) -> list:
        """Return the rates of the integrals of the run in a state of a phase; 0 for those that it
        does not move. `b` is the body in the numbers of the state, if they are others.
        """
        integrals = Variables(phase.form, self.variables.orientation).integrals
        rates = {integral.name: integral.rate for integral in integrals}
        b = b or phase.parameters(self.body)
        return [rates[name](q, carried, b) if name in rates else 0.0 for name in carried._fields]


@lru_cache(maxsize=256)
def jump_of(
    system: System,
    phases: tuple[tuple[str, Phase], ...],
    name: str,
    exit: Exit,
    variables: Variables,
    rules: Any,
    impacts: Kind | None,
    *_: type,
) -> Callable:
    """Return the jump of a phase by an exit, as a function of numbers: of the state, the integrals
    when the phase began, the time that is left, what follows the motion of an impact, and the body,
    whose types tell apart what this function keeps.
    """
    known, phase = dict(phases), dict(phases)[name]
    events, of_phase = events_of(system, known), Variables(phase.form, variables.orientation)
    record = type(phase.form.units)

    def jump(state: Sequence, whole: tuple, left: Any, piece: Any, body: Any) -> tuple:
        struck = ImpactMotions(*impacts, piece).struck if impacts else None
        world = World(body, system, rules, known, phase, left, variables, struck)
        x = phase.leave(record(*state[: of_phase.moving]), phase.parameters(body))
        own = zip(of_phase.integrals, state[of_phase.moving :], strict=False)
        now = variables.carried(*whole)._replace(**{one.name: value for one, value in own})
        carried = now._make(value / INTEGRAL_SCALE for value in now)
        if hasattr(x, "carried"):
            x = x._replace(carried=carried)
        n = exit.jump(x, world)
        if fault := fault_of(n, exit, x, events):
            raise InputError([f"{where_of(exit.event, name, system)} must {fault}."])
        return (n, (), (), ()) if n.ends else begun(n, carried, world)

    jump.calls, jump.program = 0, None  # type: ignore[attr-defined]
    return jump


def begun(n: Next, carried: Any, world: World) -> tuple[Next, tuple, tuple, tuple]:
    """Return how a phase begins: what a jump returns, the variables of the phase, the integrals of
    the run, scaled, and the values of the event functions.
    """
    to, carried = world.phases[n.phase], getattr(n.x, "carried", carried)
    b = to.parameters(world.body)
    q = type(to.form.units)(*to.enter(n.x, b))
    kinds: Any = type(b), type(b.friction)
    functions = formulas_of_phase(world.system, to, *kinds).functions
    moved = Variables(to.form, world.variables.orientation).integrals
    state = *q, *(getattr(carried, one.name) * INTEGRAL_SCALE for one in moved)
    whole = tuple(value * INTEGRAL_SCALE for value in carried)
    return n, state, whole, tuple(functions(q, carried, b))


def events_of(system: System, phases: Mapping[str, Phase]) -> dict[str, Event]:
    """Return the events of a run, by name."""
    events = {event.name: event for event in system.events}
    in_phases = {event.name: event for phase in phases.values() for event in phase.events}
    return events | in_phases | events


def where_of(event: str, phase: str, system: System) -> str:
    """Return the words for a jump."""
    return f"the jump by `{event}` from phase `{phase}` of `{system.name}`"


class Track:
    """A phase that a run may have, and where its steps are made.

    Parameters
    ----------
    run
        The run.
    name
        Of the phase.
    """

    def __init__(self, run: "HybridDriver", name: str):
        from .taylor import code_for

        problem = run.problem
        self.name, self.phase, self.at = name, run.phases[name], [*run.phases].index(name)
        phase = self.phase
        self.b = phase.parameters(run.body)
        kinds: Any = type(self.b), type(self.b.friction)
        given: Any = problem.variables, problem.contact, run.impacts, *kinds
        phases = tuple(run.phases.items())
        stops = problem.on_liftoff == "stop"
        exits = [one for one in phase.exits if not (stops and one.event == Status.LIFTOFF.value)]
        self.exits: dict[str, Any] = {
            exit.event: jump_of(problem.system, phases, name, exit, *given) for exit in exits
        }
        self.formulas = formulas_of_phase(problem.system, phase, *kinds)
        code = code_for(problem, self.formulas, run.stop)
        variables = Variables(phase.form, problem.orientation)
        self.moving, self.width = variables.moving, len(variables.names)
        self.record: Any = type(phase.form.units)
        self.integrals = [run.carried._fields.index(one.name) for one in variables.integrals]
        self.events = {run.numbers[event.name]: event for event in self.formulas.events}
        self.ways = {k: one.name for k, one in self.events.items() if one.name in self.exits}
        self.live = self.events.keys() - self.ways.keys()
        numbers = [*self.events, -1]
        records = self._records(run, code.rows.events)
        rows = run.all_events._replace(events=records, axis=code.rows.axis)
        self.place = Place(code, run.stepper_of(code), rows, numbers[code.lasting], run.shared)
        run.take(self.place, leaves(self.b))
        if run.copies:
            run.copies.follow(self.at, self.place.loop)
        sampled = [event for event in phase.events if event.sampled]
        self.sampler = Sampler(run, self, sampled) if sampled else None

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the events of the run, of which those of this phase, `mine`, are looked for."""
        records = np.zeros_like(run.all_events.events)
        for (number, event), of_phase in zip(self.events.items(), mine, strict=True):
            records[number] = run.entered[number] = of_phase
            record, kept = records[number], run.all_events.events[number][["first", "last"]].item()
            if number in self.ways:  # its jump logs
                kept, record["ends"] = (0, 0), record["ends"] or Status.ENDED.code
            record["first"], record["last"] = kept
            record["watched"] = not event.sense or event.name in run.problem.events
        return records

    def value(self, event: Event, state: np.ndarray) -> float:
        """Return the value of an event of the phase in a state."""
        q = self.record._make(state[: self.moving].tolist())
        return float(event.formula(self.phase.form.scalars(q, self.b), self.b))


class HybridDriver(Driver):
    """Makes the steps of a run through its phases.

    Parameters
    ----------
    problem
        The run.
    stop
        Set it to give up while equations are being compiled.
    """

    way = "start", ""  # the event and the phase of the present jump
    track: Track

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        system, number = problem.system, float if problem.precision == "double" else problem.number
        self.problem, self.stop, self.number = problem, stop, number  # floats are faster
        self.end = number(problem.until) / number(float(problem.scales.of(SECOND)))
        self.body, self.phases = _assembled(problem)
        self.variables, self.carried = len(problem.variables.names), problem.variables.carried
        self.at_start = np.ones(len(system.events))  # the phase of the start is chosen
        events = events_of(system, self.phases)
        self.numbers = {name: k for k, name in enumerate(events)}
        self.lasting = {name for name, event in events.items() if event.lasting}
        rows = event_rows(list(events.values()), [(0, 1, 1.0, 0.0)] * len(events), ())
        for event in (event for phase in self.phases.values() for event in phase.events):
            rows.events[self.numbers[event.name]]["extremes"] |= bool(event.extremes)
        self.all_events, width = rows, self.width
        self.entered = np.zeros_like(rows.events)  # those of the phases that have begun
        self.shared = Shared(
            new_tallies(rows, 1),
            new_log(PASSAGES + len(events) * MOST_COEFFICIENTS, width),
            new_samples(STEPS_PER_SLICE + 2, width),
        )
        functions = self.shared.tallies.functions
        functions[SIGN] = 0.0  # not known
        self.signs, self.zeros = (view(functions[kind, :, 0]) for kind in (SIGN, ON_ZERO))
        self.wanted, self.tables = Wanted(width - len(events)), PhaseTables(problem)
        self.tracks: dict[str, Track] = {}
        self.changes = self.short = 0
        # the phases of a slice: their places, and the numbers of rows, passages and samples before
        # and the integrals in which they begin
        self.spans: list[list[Any]] = []
        self.states = np.empty((self.wanted.variables, 0), number)  # of the rows
        self.copies = self.impacts = self.piece = struck = None
        if problem.contact is not None:
            self.impacts = kind_of(problem, self.body[0].friction)
            self.piece = Pieces(self.impacts, stop)
            struck = ImpactMotions(*self.impacts, self.piece).struck
            self.copies = Changes(self, CHATTER, PER_SLICE) if number is float else None
        start = problem.start()
        q, carried = problem.variables.split(start.tolist())
        x = system.common.leave(q, carried) if system.common else system.phase.leave(q, self.body)
        given = self.body, system, problem.contact, self.phases, None, self.end
        world = World(*given, problem.variables, struck)
        n = Next(next(iter(self.phases)), x, "start")
        try:
            n = system.begin(x, world) if system.begin else n
        except ArithmeticError as error:
            n.ends, n.message = "stalled", str(error)
        if n.ends:
            self.ended, self.sentence, n.ends = Status(n.ends), n.message, ""
        self._enter(self._called(begun, n, carried, world), number(0), None)
        self.first = self.present()

    # --- phases ----------------------------------------------------------------------------------

    def track_of(self, name: str) -> Track:
        """Return the phase of this name, compiled when it is first entered."""
        if name not in self.tracks:
            self.tracks[name] = Track(self, name)
        return self.tracks[name]

    def equations(self) -> list[tuple]:
        """Return the equations of every phase: pairs of a variable and its rate."""
        codes = (self.track_of(name).place.compiled for name in self.phases)
        return [pair for code in codes for pair in code.integrator.sys]

    def follow(self, track: Track, whole: Sequence, began: float) -> None:
        """Make the next steps in a phase that begins with these integrals, at an internal time."""
        self.track, self.whole, self.began = track, whole, began
        self.work_in(track.place)

    def _enter(self, begun: tuple, now: Any, before: Track | None) -> None:
        """Take up what follows a phase `before`, at an internal time."""
        n, state, whole, values = begun
        if before and not math.isfinite(self._called(sum, state)):
            raise ArithmeticError(
                f"{self._where()} must lead to a finite state, but leads to {n.x!r:.60}"
            )
        is_new, track = n.phase not in self.tracks, self.track_of(n.phase)
        time = min(now + self.number(n.delay), self.end)
        self.follow(track, whole, float(time))
        if self.copies and is_new:
            for ending, jump in track.exits.items():
                if jump.program:  # of another run
                    self.copies.teach(ending, (state, whole, 0.0, None, self.body))
        if n.cause != "":
            names = track.name, track.phase, n.cause or self.way[0]
            self.tables.begin(float(now + n.logged_after), self.tables.row_of(*names))
        self.tables.add(float(now), n.rows)
        self.put(state, (time, 0 * time))
        self._begin_events(n, state, values, now, before)
        self.begin()
        self.time[0] = self.began
        self.until = math.nan if n.lasts is None else time + self.number(n.lasts)

    def _begin_events(
        self, n: Next, state: Sequence, values: Sequence, now: Any, before: Track | None
    ) -> None:
        """Write on which side of their zeros the event functions of a phase begin."""
        track, signs, zeros = self.track, self.signs, self.zeros
        known = before.live if before else ()
        if n.series is not None:
            self._begin_span()
            self._fill(lambda times: self._series(n, times.astype(self.number) - now))
        for (number, event), value in zip(track.events.items(), values, strict=True):
            sign, zero = 1.0 if value > 0 else -1.0, 0
            if number in track.ways:
                sign = n.sides.get(event.name, -event.direction or sign)
                zero = -n.zeros.get(event.name, 0)
                if zero:
                    self._check_root(number, values, -zero, state)
            elif number not in known:
                zero = abs(value) < BELOW
            elif sign != (was := signs[number]):
                if abs(value) < BELOW:
                    sign = was
                elif n.series is not None:
                    self._note_along(n, track, event, was, now)
                elif before and (event.sense or (event.lasting and sign == event.direction)):
                    self._note(event.name, now, self.last, int(sign))  # of theta: it has a corner
            signs[number], zeros[number] = sign, zero
        if n.series is None:
            self._begin_span()

    def _check_root(self, number: int, values: Sequence, count: int, state: Sequence) -> None:
        """Raise InputError where an event function has no root of this multiplicity in a state of
        the present phase: its value, and its slope if there is more than one root, are zero.
        """
        track = self.track
        k, q = [*track.events].index(number), track.record._make(state[: track.moving])
        missed = not abs(values[k]) < ROOT
        if count > 1 and not missed:
            rates = track.phase.form.rates(q, track.b)
            near = (one + NEAR * rate for one, rate in zip(q, rates, strict=True))
            carried = self.carried(*(value / INTEGRAL_SCALE for value in self.whole))
            ahead = track.formulas.functions(track.record(*near), carried, track.b)[k]
            missed = not abs(ahead - values[k]) < SLOPE * NEAR
        if missed:
            there = (
                f"in `zeros`, but {track.events[number].name!r} has no root of multiplicity "
                f"{count} where phase `{track.name}` begins"
            )
            raise InputError([f"{self._where()} must give multiplicities of roots {there}."])

    # --- steps -----------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Make at most `most` steps, through as many phases as they take."""
        self.request, self.spans = weakref.proxy(request), []
        self.forget()
        self.given = self.wanted.made[0]
        self._begin_span()
        steps, status, when = 0, None, self.end
        while self.clock[0] < self.end:
            self._fill(lambda times: np.repeat(self.state[None, :], len(times), axis=0))
            sampled = self._sample()
            steps += self.drive(1 if self.track.sampler else most - steps)
            track, code, ending = self.track, self.status[0], None
            when, self.last = self.reached()
            self.last = self.last[: track.width].copy()
            status = None if code == RUNNING else STATUSES[code]
            if status is Status.FINISHED:
                ending = sampled or (CLOCK if self.until < self.end else None)
            elif self.upto[0] < 1.0 and (
                ending := track.ways.get(self.log.event[self.logged[0] - 1])
            ):
                self.drop()  # the jump logs it
            if ending is not None:
                status = self._jump(ending, when)
            if (
                status is not None
                or steps >= most
                or (self.changes % PER_SLICE == 0 if ending else not track.sampler)
            ):
                break
        if status is None:
            self.last = self.state[: self.track.width].copy()
            if not self.clock[0] < self.end:  # a phase begins where the run ends, and takes no step
                when, status = self.end, Status.FINISHED
                self.tally["upto"] = 0.0
        if status is not None:
            self.tables.end(float(when))
        return self._slice(steps, when, status)

    def _sample(self) -> str:
        """Put the end of the next steps at that of the phase, or where a sampled event happens in
        the next one.

        Return that event, or nothing.
        """
        end = self.until if self.until < self.end else self.end
        sampler = self.track.sampler
        name, when = (sampler and sampler.next()) or ("", end)
        if not when < end:
            name, when = "", end
        self.end_at(when)
        return name

    def _jump(self, ending: str, when: Any) -> Status | None:
        """Take up what follows the end of a phase in its last state.

        Return how it ends the run, or None.
        """
        self.changes, self.way = self.changes + 1, (ending, self.track.name)
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        now, track, state = self.number(when), self.track, self.last
        given = tuple(state.tolist()), self.whole, self.end - now, self.piece, self.body
        try:
            begun = self._called(track.exits[ending], *given)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        if self.copies:
            self.copies.teach(ending, given)
        n: Next = begun[0]
        for name in n.logged:
            self._note(name, now + n.logged_after, state, 1)
        if n.ends:
            self.sentence = n.message or f"{self._where()} ends the run"
            self.tables.add(float(when), n.rows)
            return Status.of_event(n.ends)
        if self.short > 2:
            often = f"more often than every {CHATTER * self.tables.second:.1g} s"
            self.sentence = (
                f"phases change {often}, at last from `{track.name}` to `{n.phase}` by `{ending}`"
            )
        elif self.changes > MOST_CHANGES:
            self.sentence = (
                f"phases have changed {MOST_CHANGES} times, at last to `{n.phase}` by `{ending}`"
            )
        if self.sentence:
            return Status.STALLED
        if self.request.steps and self.upto[0] < 1.0:  # the loop keeps the ends of steps
            self._add(np.array([when]), state[None])
        try:
            self._enter(begun, now, track)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.NON_FINITE
        return None

    def _where(self) -> str:
        """Return the words for the present jump."""
        return where_of(*self.way, self.problem.system)

    def _called(self, function: Callable, *given: Any) -> Any:
        """Call a function of a system.

        Raise ArithmeticError for numbers that it cannot take, InputError for another failure.
        """
        try:
            return function(*given)
        except Exception as error:
            if type(error) in (ArithmeticError, InputError):  # it has a message for the user
                raise
            failure = f"{self._where()} fails: {type(error).__name__}: {error}"
            raise (
                ArithmeticError(failure)
                if isinstance(error, ArithmeticError)
                else InputError([failure])
            ) from error

    # --- rows ------------------------------------------------------------------------------------

    def _begin_span(self) -> None:
        """Note that rows, passages and samples belong to the present phase from now on."""
        counts = self.wanted.made[0], self.logged[0], self.sampled_so_far[0]
        self.spans.append([self.track.at, *counts, self.whole])

    def ask(self) -> None:
        if self.wanted.made[0] > self.given:
            self._hand_over()
        super().ask()
        states, self.given = self.wanted.rows.states, 0
        self.states = states if self.number is float else np.empty(states.shape, self.number)
        for span in self.spans:
            span[1] = 0

    def _hand_over(self, *others: tuple[int, int, np.ndarray]) -> list[np.ndarray]:
        """Give the rows that exist, and return those of other states: see `_rows`."""
        made = slice(self.given, self.wanted.made[0])
        rows, *rest = self._rows((1, made.start, self.states[:, made]), *others)
        if len(rows):
            self.request.take(self.wanted.rows.times[made], rows)
        self.given = made.stop
        return rest

    def make(self, rows: Rows, most: int) -> int:
        if self.copies is None or self.request.steps or self.track.sampler:
            return super().make(rows, most)
        changes = min(PER_SLICE - self.changes % PER_SLICE, MOST_CHANGES - self.changes)
        return self.copies.drive(most, changes)

    def give(self, first: int) -> None:
        if self.number is not float:
            states = self.states_of(self.wanted.rows, first).T
            self.states[: len(states), first : self.wanted.made[0]] = states[: len(self.states)]

    def _add(self, times: np.ndarray, states: np.ndarray) -> None:
        """Add rows that no step makes: times, and states of the present phase (k, variables)."""
        made, count = self.wanted.made, len(self.states)
        part = slice(made[0], made[0] + len(times))
        self.wanted.rows.times[part], made[0] = times, part.stop
        self.states[: states.shape[1], part] = states[:, :count].T

    def _note(self, name: str, time: Any, state: np.ndarray, sign: int) -> None:
        """Log an event that no step has logged, in a state of the phase of the last span."""
        number = self.numbers[name]
        self.note(time, number, sign, state)
        if name in self.lasting:
            self.tally["lasts_since"] = float(time)
        self.loop.keep(self.all_events.events[number], float(time), sign)

    def _series(self, n: Next, since: np.ndarray) -> np.ndarray:
        """Return states at times since the beginning of a jump that takes time."""
        t = np.array([min(max(one, 0 * n.delay), n.delay) for one in since])
        q, carried = n.series(t)
        moved = [carried[k] * INTEGRAL_SCALE for k in self.track.integrals]
        states = [
            [self.number(one) for one in np.broadcast_to(value, t.shape)] for value in (*q, *moved)
        ]
        return np.array(states).T

    def _fill(self, states_at: Callable[[np.ndarray], np.ndarray]) -> None:
        """Give the rows that are wanted before the time at which the present phase makes its first
        step.
        """
        while not self.request.steps:
            if self.wanted.is_made:
                self.ask()
            times = self.wanted.rows.times[self.wanted.made[0] :]
            if count := int(np.searchsorted(times, self.began)):
                self._add(times[:count], states_at(times[:count]))
            if count < len(times) or not count:
                break

    def _note_along(self, n: Next, track: Track, event: Event, known: float, now: Any) -> None:
        """Log an event that happens in a jump that takes time."""
        k = track.formulas.events.index(event)

        def function(t: Any) -> float:
            q, carried = n.series(np.array([t]))
            q = track.record(*(value[0] if np.ndim(value) else value for value in q))
            return float(track.formulas.functions(q, carried, track.b)[k])

        t = zero_of(lambda t: function(t) * known, 0 * n.delay, n.delay)
        self._note(event.name, now + t, self._series(n, np.array([t]))[0], -int(known))

    def _rows(self, *parts: tuple[int, int, np.ndarray]) -> list[np.ndarray]:
        """Return the rows of states.

        Parameters
        ----------
        parts
            What they are: rows (1), passages (2) or samples (3) of a slice, from this number on;
            and the states (variables, k).
        """
        system, number, record = self.problem.system, self.number, self.carried
        which, states = [], np.concatenate([states for *_, states in parts], axis=1)
        for kind, first, some in parts:
            numbers = first + np.arange(some.shape[1])
            begin = [span[kind] for span in self.spans]
            which.append(np.searchsorted(begin, numbers, side="right") - 1)
        of_span = np.concatenate(which)
        places, *_, begun = zip(*self.spans, strict=True)
        at, wholes = np.array(places)[of_span], np.array(begun).T
        rows, moving = np.empty((self.variables, len(at)), number), self.variables - len(wholes)
        for track in self.tracks.values():
            mine = np.flatnonzero(at == track.at)
            if not len(mine):
                continue
            state, whole = states[: track.width].take(mine, 1), wholes.take(of_span[mine], 1)
            whole[track.integrals] = state[track.moving :]
            q, carried = track.record(*state[: track.moving]), whole * number(1 / INTEGRAL_SCALE)
            values = (
                system.row(track.phase, q, record(*carried), self.body)
                if system.row
                else track.phase.leave(q, track.b)
            )
            for row, value in zip(rows, (*values[:moving], *whole), strict=True):
                row[mine] = value
        return np.split(rows.T, np.cumsum([*map(len, which[:-1])]))

    def _slice(self, steps: int, when: Any, status: Status | None) -> Slice:
        """Give the rows that exist, and return what else the steps have found."""
        *columns, logged = self.passages()
        n, samples = self.wanted.variables, self.sampled()
        logged, samples, last = self._hand_over(
            (2, 0, logged[:, :n].T),
            (3, 0, samples[:, :n].T),
            (1, self.wanted.made[0], np.resize(self.last, (n, 1))),
        )
        passages = Passages._make([*(column.copy() for column in columns), logged])
        return Slice(steps, when, last, samples, passages, status, self.tables.take())

    # --- where the run is ------------------------------------------------------------------------

    def last_rows(self) -> dict[str, dict[str, np.ndarray]]:
        """End the phase that is under way; return its row."""
        self.tables.end(float(self.clock[0]))
        return self.tables.take()

    def present(self) -> np.ndarray:
        """Return the row of the present state, (1, variables)."""
        self.spans = [[self.track.at, 0, 0, 0, self.whole]]
        return self._rows((1, 0, self.state[:, None]))[0]

    def extremes(self) -> Extremes:
        return extremes_of(self.entered, self.tallies)

    @property
    def width(self) -> int:
        """The greatest number of variables of a phase."""
        forms = (Variables(p.form, self.problem.orientation) for p in self.phases.values())
        return max(len(one.names) for one in forms) + len(self.numbers)

    def snapshot(self) -> dict[str, Any]:
        """Return what a run needs to continue bit by bit: lists of the same lengths in every phase,
        but for `state`.
        """
        counts = self.track.at, self.changes, self.short
        return {
            **super().snapshot(),
            "phase": [*counts, self.began, *self.tables.under_way],
            "carried": [*self.whole, self.number(self.until)],
        }

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot, of which state and time come in the working precision."""
        *counts, began = kept["phase"][:4]
        at, self.changes, self.short = map(int, counts)
        *whole, until = kept["carried"].tolist()
        self.follow(self.track_of([*self.phases][at]), tuple(whole), began)
        super().restore(kept, state[: len(self.state)], clock)
        self.until = until
        self.tables = PhaseTables(self.problem)
        self.tables.under_way = kept["phase"][4:]


class WideHybridDriver(HybridDriver, WideDriver):
    """Makes the steps of a run through its phases in numbers wider than doubles."""


def _assembled(problem: Problem) -> tuple[Any, Mapping[str, Phase]]:
    """Return the body of a run as its phases take it, and the phases."""
    system = problem.system
    if system.assembled is None:
        return problem.internal_body, system.phases

    def internal(value: float, unit: Any) -> Any:
        return problem.number(
            problem.exact(value) * (problem.exact(1) / problem.exact(problem.scales.of(unit)))
        )

    return system.assembled(problem.internal_body, problem.contact, internal)


def fault_of(n: Any, exit: Exit, x: Any, events: Collection[str]) -> str:
    """Return what the result of a jump must be and is not; empty if it can follow the state `x`."""
    if not isinstance(n, Next):
        return f"return a Next, but returns {n!r:.60}"
    if n.phase not in exit.to and not n.ends:
        return f"lead to {' or '.join(exit.to)}, as its Exit declares, but leads to {n.phase!r}"
    if type(n.x) is not type(x):
        return f"return a state as it takes ({type(x).__name__}), but returns {n.x!r:.60}"
    for what, names in (("logged", n.logged), ("zeros", n.zeros), ("sides", n.sides)):
        for name in names:
            if name not in events:
                return f"have events of the system in `{what}`, but has {name!r}"
    if n.zeros and min(n.zeros.values()) < 1:
        return f"have multiplicities of roots in `zeros`, at least 1, but has {dict(n.zeros)}"
    return ""

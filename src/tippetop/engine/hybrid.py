"""One run of a system of several phases: an ordinary driver for each, and jumps from one to
another.

Jumps are functions of the common state, which every phase can be read as; the driver does not
depend on balls or laws.
"""

import math
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache, partial
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
    Request,
    Shared,
    Slice,
    Wanted,
    extremes_of,
    view,
)
from .expressions import Formulas
from .loop import MOST_COEFFICIENTS
from .phase_tables import PhaseTables
from .sampled import Sampler, zero_of
from .status import Status
from .tallies import (
    COUNT,
    LAST,
    ON_ZERO,
    SIGN,
    EventRows,
    event_rows,
    mark_bounded,
    new_log,
    new_samples,
    new_tallies,
)


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
    events = events_of_phase(system, phase)
    own = [event for event in events if event in phase.events]
    common = events[len(own) :]
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

    return Formulas(
        form, events, functions, lambda values: refill(template, values)._replace(**folds)
    )


class World(NamedTuple):
    """What jumps know besides the state: see `form.Exit`."""

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


class Begun(NamedTuple):
    """How a phase begins: what a jump returns, and what follows from it."""

    n: Next
    state: tuple = ()  # of the phase: its variables
    whole: tuple = ()  # the integrals of the run, scaled
    values: tuple = ()  # of the event functions


@lru_cache(maxsize=256)
def jump_of(
    system: System,
    phases: tuple[tuple[str, Phase], ...],
    name: str,
    exit: Exit,
    variables: Variables,
    rules: Any,
    impacts: Any,
    *_: type,
) -> Callable:
    """Return the jump of a phase by an exit, as a function of numbers: of the state, the integrals
    when the phase began, the time that is left, what follows the motion of an impact, and the body,
    whose types tell apart what this function keeps.
    """
    known, phase = dict(phases), dict(phases)[name]
    events, of_phase = events_of(system, known), Variables(phase.form, variables.orientation)
    record = type(phase.form.units)

    def jump(state: Sequence, whole: tuple, left: Any, piece: Any, body: Any) -> Begun:
        struck = partial(impacts.struck, piece) if impacts else None
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
        return Begun(n) if n.ends else begun(n, carried, world)

    jump.calls, jump.program = 0, None  # type: ignore[attr-defined]
    return jump


def begun(n: Next, carried: Any, world: World) -> Begun:
    """Return how a phase begins."""
    to, carried = world.phases[n.phase], getattr(n.x, "carried", carried)
    b = to.parameters(world.body)
    q = type(to.form.units)(*to.enter(n.x, b))
    kinds: Any = type(b), type(b.friction)
    functions = formulas_of_phase(world.system, to, *kinds).functions
    moved = Variables(to.form, world.variables.orientation).integrals
    state = *q, *(getattr(carried, one.name) * INTEGRAL_SCALE for one in moved)
    whole = tuple(value * INTEGRAL_SCALE for value in carried)
    return Begun(n, state, whole, tuple(functions(q, carried, b)))


def events_of(system: System, phases: Mapping[str, Phase]) -> dict[str, Event]:
    """Return the events of a run, by name."""
    events = {event.name: event for event in system.events}
    in_phases = {event.name: event for phase in phases.values() for event in phase.events}
    return events | in_phases | events


def events_of_phase(system: System, phase: Phase) -> tuple[Event, ...]:
    """Return the events that the loop looks for in a phase: its own, and common ones."""
    of_phases = {event.name for other in system.phases.values() for event in other.events}
    own = (event for event in phase.events if event.formula is not None and not event.sampled)
    return *own, *(
        event for event in system.events if event.formula and event.name not in of_phases
    )


def where_of(event: str, phase: str, system: System) -> str:
    """Return the words for a jump."""
    return f"the jump by `{event}` from phase `{phase}` of `{system.name}`"


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
        kinds = self.b.__class__, self.b.friction.__class__
        given = problem.variables, problem.contact, run.impacts and run.impacts.kind, *kinds
        phases = tuple(run.phases.items())
        self.exits: dict[str, Any] = {
            exit.event: jump_of(problem.system, phases, name, exit, *given) for exit in phase.exits
        }
        stops = {Status.LIFTOFF.value} if problem.on_liftoff == "stop" else set()
        self.pure = {exit.event for exit in phase.exits if exit.is_pure} - stops
        self.formulas = formulas_of_phase(problem.system, phase, *kinds)
        code = code_for(problem, self.formulas, run.stop)
        variables = Variables(phase.form, problem.orientation)
        self.moving, self.record, self.width = (
            variables.moving,
            type(phase.form.units),
            len(variables.names),
        )
        self.integrals = [
            run.carried._fields.index(integral.name) for integral in variables.integrals
        ]
        self.events = self.formulas.events
        self.numbers = [run.numbers[event.name] for event in self.events]
        self.ways = {
            number: event.name
            for number, event in zip(self.numbers, self.events, strict=True)
            if event.name in self.exits
        }
        self.live = {*self.numbers} - {*self.ways}
        rows = run.rows._replace(events=self._records(run, code.rows.events), axis=code.rows.axis)
        self.driver: Driver = kind_of_driver(problem)(
            code,
            rows,
            leaves(self.b),
            np.zeros(self.width, problem.number),
            np.zeros(len(rows.events)),
            run.end,
            run.shared,
            self.numbers[code.lasting] if code.lasting >= 0 else -1,
        )
        self.place = list(run.phases).index(name)
        if run.copies:
            run.copies.loop.follow(self.place, self.driver.loop)
        if run.tracks:
            self.driver.share(next(iter(run.tracks.values())).driver)
        sampled = [event for event in phase.events if event.sampled]
        self.sampler = (
            Sampler(self.driver, leaves(self.b), sampled, self._value) if sampled else None
        )

    def _value(self, state: np.ndarray, event: Event) -> Any:
        """Return the value of an event in a state of the phase."""
        return event.formula(self.phase.form.scalars(self.q(state), self.b), self.b)

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the events of the run, of which those of this phase are looked for."""
        records = run.rows.events.copy()
        for flag in ("extremes", "watched", "ranged", "ends"):
            records[flag] = 0
        records["leader"] = -1
        for number, event, record in zip(self.numbers, self.events, mine, strict=True):
            kept = (
                records[number][["first", "last"]].item()
                if event.name not in self.exits
                else (0, 0)
            )  # jumps log
            records[number] = record
            records[number]["first"], records[number]["last"] = kept
            if event.name in self.exits:
                records[number]["ends"] = record["ends"] or Status.ENDED.code
            records[number]["watched"] = not event.sense or event.name in run.problem.events
            leader = record["leader"]
            records[number]["leader"] = self.numbers[leader] if leader >= 0 else -1
        mark_bounded(records)
        return records

    def q(self, state: np.ndarray) -> Any:
        """Return the record of a state; doubles become floats, which formulas take faster."""
        return self.record._make(state[: self.moving].tolist())


class Block(NamedTuple):
    """Rows that were asked for together."""

    times: np.ndarray
    states: np.ndarray  # (variables, rows) in the precision of the run
    made: Any  # the number of rows that exist
    first: int  # of the present slice


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
    way = "start", ""  # the event and the phase of the present jump
    track: Track

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        system, number = problem.system, float if problem.precision == "double" else problem.number
        self.problem, self.stop, self.number = (
            problem,
            stop,
            number,
        )  # floats are faster than NumPy's
        self.variables = len(problem.variables.names)
        self.end = number(problem.until) / number(float(problem.scales.of(SECOND)))
        self.body, self.phases = _assembled(problem)
        self.carried = problem.variables.carried
        events = events_of(system, self.phases)
        in_phases = [event for phase in self.phases.values() for event in phase.events]
        self.rows: EventRows = event_rows(
            list(events.values()), [(0, 1, 1.0, 0.0)] * len(events), ()
        )
        self.numbers = {name: k for k, name in enumerate(events)}
        for event in in_phases:
            self.rows.events[self.numbers[event.name]]["extremes"] |= bool(event.extremes)
        numbers = [(place, *number) for place, number in enumerate(self.rows.numbers.tolist())]
        self.kept = [
            numbers[first:last] for first, last in self.rows.events[["first", "last"]].tolist()
        ]
        self.lasting = {name for name, event in events.items() if event.lasting}
        width = self.width
        most = PASSAGES + len(self.rows.events) * MOST_COEFFICIENTS
        self.shared = Shared(
            new_tallies(self.rows, 1), new_log(most, width), new_samples(STEPS_PER_SLICE + 2, width)
        )
        self.tallies = self.shared.tallies
        self.tallies.functions[SIGN] = 0.0  # not known
        self.counts = [view(one.filled) for one in self.shared[1:]]
        self.wanted, self.tables = Wanted(width - len(self.rows.events)), PhaseTables(problem)
        self.tracks: dict[str, Track] = {}
        self.changes = self.short = 0
        self.live: set[int] = set()
        self.signs, self.zeros = (
            view(self.tallies.functions[kind, :, 0]) for kind in (SIGN, ON_ZERO)
        )
        self.rooted: set[tuple] = (
            set()
        )  # roots that jumps have named rightly: the exit, the next phase, the event
        self.blocks: list[Block] = []
        # the phases of a slice: track, integrals, and how many states there are
        self.spans: list[tuple[Track, Sequence, tuple]] = []
        self.copies = Changes(self, CHATTER, PER_SLICE) if number is float else None
        self.impacts = None
        if problem.contact is not None:
            from .impacts import Impacts

            self.impacts = Impacts(problem, self.body[0].friction, stop)
        start = problem.start()
        q, carried = problem.variables.split(start.tolist())
        self.whole = tuple(start[problem.variables.moving :].tolist())
        x = system.common.leave(q, carried) if system.common else system.phase.leave(q, self.body)
        struck = self.impacts and self.impacts.struck
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

    def _enter(self, begun: Begun, now: Any, before: Track | None) -> None:
        """Take up what follows a phase `before`, at an internal time."""
        n, state, whole, values = begun
        if before and not math.isfinite(self._called(sum, state)):
            raise ArithmeticError(
                f"{self._where()} must lead to a finite state, but leads to {n.x!r:.60}"
            )
        is_new = n.phase not in self.tracks
        self.track = track = self.track_of(n.phase)
        if self.copies and is_new:
            for ending in track.pure:
                if track.exits[ending].program:  # of another run
                    self.copies.teach(ending, (state, whole, 0.0, None, self.body))
        driver = track.driver
        if n.cause != "":
            cause = n.cause or self.way[0]
            self.tables.begin(track.name, track.phase, float(now + n.logged_after), cause)
        self.tables.add(float(now), n.rows)
        time = min(now + self.number(n.delay), self.end)
        driver.put(state, (time, 0 * time))
        self.whole, self.waits, self.began = whole, n.delay > 0 and n.series is None, float(time)
        counts = self._counts()
        self._begin_events(n, state, values, now, before)
        self.spans.append((track, whole, counts))
        driver.begin()
        driver.time[0] = self.began
        self._set_clock(None if n.lasts is None else time + self.number(n.lasts))

    def _set_clock(self, clock: Any) -> None:
        """Set the end of the phase."""
        self.clocked = clock is not None and clock < self.end
        self.until = clock
        self.track.driver.end_at(clock if self.clocked else self.end)

    def _begin_events(
        self, n: Next, state: Sequence, values: Sequence, now: Any, before: Track | None
    ) -> None:
        """Write on which side of their zeros the event functions of a phase begin."""
        track, live, signs, zeros = self.track, self.live, self.signs, self.zeros
        if n.series is not None:
            self._fill(
                float(now + n.delay), lambda times: self._series(n, times.astype(self.number) - now)
            )
        for number, event, value in zip(track.numbers, track.events, values, strict=True):
            sign, zero = 1.0 if value > 0 else -1.0, 0
            if number in track.ways:
                sign = n.sides.get(event.name, -event.direction or sign)
                zero = -n.zeros.get(event.name, 0)
                if zero and (self.way, track.name, number) not in self.rooted:
                    self._check_root(number, values, -zero, state)
            elif number not in live:
                zero = abs(value) < BELOW
            elif sign != (known := signs[number]):
                if abs(value) < BELOW:
                    sign = known
                elif n.series is not None:
                    self._note_along(n, track, event, known, now)
                elif before and (event.sense or (event.lasting and sign == event.direction)):
                    # of theta: it has a corner
                    self._note(event.name, now, before, self.last, int(sign))
            signs[number], zeros[number] = sign, zero
        self.live = track.live

    def _check_root(self, number: int, values: Sequence, count: int, state: Sequence) -> None:
        """Raise InputError where an event function has no root of this multiplicity in a state of
        the present phase: its value, and its slope if there is more than one root, are zero. Once
        for an exit.
        """
        track = self.track
        self.rooted.add((self.way, track.name, number))
        k, q = track.numbers.index(number), track.record._make(state[: track.moving])
        missed = not abs(values[k]) < ROOT
        if count > 1 and not missed:
            near = (
                one + NEAR * rate
                for one, rate in zip(q, track.phase.form.rates(q, track.b), strict=True)
            )
            carried = self.carried(*(value / INTEGRAL_SCALE for value in self.whole))
            ahead = track.formulas.functions(track.record(*near), carried, track.b)[k]
            missed = not abs(ahead - values[k]) < SLOPE * NEAR
        if missed:
            there = (
                f"in `zeros`, but {track.events[k].name!r} has no root of multiplicity {count} "
                f"where phase `{track.name}` begins"
            )
            raise InputError([f"{self._where()} must give multiplicities of roots {there}."])

    # --- steps -----------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Make at most `most` steps, through as many phases as they take."""
        self.request, self.blocks = request, []
        self.track.driver.forget()
        self._new_block(request.steps or self.wanted.is_made)
        self.spans = [(self.track, self.whole, self._counts())]
        steps, status = 0, None
        while self.clock[0] < self.end:
            if self.waits:
                self.waits = False
                self._fill(
                    self.began,
                    lambda times: np.repeat(
                        self.state[None, : self.track.width], len(times), axis=0
                    ),
                )
            sampled, logged = self._sample(), self.counts[0][0]
            steps += self._drive(1 if self.track.sampler else most - steps)
            track, driver = self.track, self.track.driver
            when, last = driver.reached()
            self.last, code = last[: track.width].copy(), driver.status[0]
            status = None if code == RUNNING else STATUSES[code]
            ending = (
                sampled if sampled and status is Status.FINISHED else self._ending(status, logged)
            )
            if ending not in (None, CLOCK, sampled):  # the jump logs it
                driver.drop()
            if ending is not None:
                status = self._jump(ending, when)
            if (
                status is not None
                or steps >= most
                or (self.changes % PER_SLICE == 0 if ending else not track.sampler)
            ):
                break
        if status is None:
            track, self.last = self.track, self.state[: self.track.width].copy()
            if not self.clock[0] < self.end:  # a phase begins where the run ends, and takes no step
                when, status = self.end, Status.FINISHED
                self.tally["upto"] = 0.0
        if status is not None:
            self.tables.end(float(when))
        return self._slice(steps, when, track, status)

    def _sample(self) -> str:
        """Let the phase end where a sampled event happens in its next step.

        Return that event, or nothing.
        """
        driver, sampler = self.track.driver, self.track.sampler
        if not sampler:
            return ""
        driver.end_at(self.until if self.clocked else self.end)
        first = sampler.next()
        if not first or not first[1] < driver.end:
            return ""
        driver.end_at(first[1])
        return str(first[0])

    def _ending(self, status: Status | None, logged: int) -> str | None:
        """Return the exit by which the present phase ends, at the end of the run too; None if it
        does not, or ends the run. Before its last steps the log had this length.
        """
        at = self.track.driver.logged[0]
        if status is not None and at > logged:
            way = self.track.ways.get(int(self.shared.log.event[at - 1]))
            if way is not None:
                return way
        return CLOCK if status is Status.FINISHED and self.clocked else None

    def _jump(self, ending: str, when: Any) -> Status | None:
        """Take up what follows the end of a phase in its last state.

        Return how it ends the run, or None.
        """
        self.changes, self.way = self.changes + 1, (ending, self.track.name)
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        now, track, state = self.number(when), self.track, self.last
        piece = self.impacts and self.impacts.piece
        given = tuple(state.tolist()), self.whole, self.end - now, piece, self.body
        try:
            begun = self._called(track.exits[ending], *given)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        if self.copies and ending in track.pure:
            self.copies.teach(ending, given)
        n = begun.n
        for name in n.logged:
            self._note(name, now + n.logged_after, track, state, 1)
        if n.ends:
            self.sentence = n.message or f"{self._where()} ends the run"
            self.tables.add(float(when), n.rows)
            return Status.of_event(n.ends)
        if ending == Status.LIFTOFF.value and self.problem.on_liftoff == "stop":
            return Status.LIFTOFF
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
        if self.request.steps and track.driver.upto[0] < 1.0:  # the loop keeps the ends of steps
            self._give(np.array([when]), state[None])
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

    def _new_block(self, is_made: bool = True) -> None:
        """Go on with the rows that are wanted; with further ones, if these are made."""
        if is_made:
            self.wanted.ask(self.request)
        rows, made = self.wanted.rows, self.wanted.made
        states = rows.states if self.number is float else np.empty(rows.states.shape, self.number)
        self.blocks.append(Block(rows.times, states, made, made[0]))

    def _counts(self) -> tuple[int, int, int]:
        """Return the numbers of rows, passages and samples of this slice."""
        rows = sum(block.made[0] - block.first for block in self.blocks)
        return rows, self.counts[0][0], self.counts[1][0]

    def _drive(self, most: int) -> int:
        """Make at most `most` steps of the present phase and their rows.

        Return the number of steps.
        """
        wanted, steps = self.wanted, 0
        while True:
            track, driver = self.track, self.track.driver
            first = wanted.made[0]
            left = most - steps if driver.status[0] == RUNNING else 0
            if self.copies and self.copies.loop.kept and not (self.request.steps or track.sampler):
                for one in self.tracks.values():
                    one.driver.loop.fill(wanted.rows)
                changes = PER_SLICE - self.changes % PER_SLICE
                changes = min(changes, MOST_CHANGES - self.changes)
                begun = track.place, self.began, self.whole
                steps += self.copies.loop.drive(*begun, left, changes)
                self._take_changes(self.copies)
            else:
                steps += driver.make(wanted.rows, left)
            made = wanted.made[0]
            if self.number is not float and made > first:
                states = driver.states_of(wanted.rows, first).T
                self.blocks[-1].states[: len(states), first:made] = states
            if made == first or not wanted.is_made:
                return steps
            self._new_block()

    def _take_changes(self, copies: Changes) -> None:
        """Take the changes of phase that the loop has made."""
        before = self._counts()[0] - self.wanted.made[0]
        for time, n, exit, track, counts, whole, rows in copies.taken():
            if n.cause != "":
                self.tables.begin(track.name, track.phase, time, n.cause or exit)
            self.tables.add(time, rows)
            made, *others = counts
            self.spans.append((track, whole, (before + made, *others)))
            self.track, self.whole, self.live, self.began = track, whole, track.live, time
            self.changes, self.short = self.changes + 1, 0
        if copies.loop.record.length:
            clock = copies.loop.record.clock
            self.until = None if math.isnan(clock) else clock
            self.clocked = clock < self.end

    def _give(self, times: np.ndarray, states: np.ndarray) -> None:
        """Give rows that no step makes: times, and states of the present phase (k, variables)."""
        block = self.blocks[-1]
        made, block.made[0] = block.made[0], block.made[0] + len(times)
        part = slice(made, block.made[0])
        block.times[part], block.states[: states.shape[1], part] = times, states.T
        if self.wanted.is_made:
            self._new_block()

    def _note(self, name: str, time: Any, track: Track, state: np.ndarray, sign: int) -> None:
        """Log an event that no step has logged, in a state of a phase."""
        number = self.numbers[name]
        track.driver.note(time, number, sign, state)
        if name in self.lasting:
            self.tally["lasts_since"] = float(time)
        for place, what, direction in self.kept[number]:
            kept = self.tallies.kept[:, 0]
            if direction * sign < 0:
                continue
            if what == COUNT:
                kept[place] += 1
            elif what == LAST or np.isnan(kept[place]):
                kept[place] = float(time)

    def _series(self, n: Next, since: np.ndarray) -> np.ndarray:
        """Return states at times since the beginning of a jump that takes time."""
        t = np.array([min(max(one, 0 * n.delay), n.delay) for one in since])
        q, carried = n.series(t)
        moved = [carried[k] * INTEGRAL_SCALE for k in self.track.integrals]
        states = [
            [self.number(one) for one in np.broadcast_to(value, t.shape)] for value in (*q, *moved)
        ]
        return np.array(states).T

    def _fill(self, until: float, states_at: Callable[[np.ndarray], np.ndarray]) -> None:
        """Give the rows that are wanted before a time, at which the present phase makes its first
        step.
        """
        while not self.request.steps:
            times = self.wanted.rows.times[self.wanted.made[0] :]
            count = int(np.searchsorted(times, until))
            if count:
                self._give(times[:count], states_at(times[:count]))
            if count < len(times) or not count:
                break

    def _note_along(self, n: Next, track: Track, event: Event, known: float, now: Any) -> None:
        """Log an event that happens in a jump that takes time."""
        k = track.events.index(event)

        def function(t: Any) -> float:
            q, carried = n.series(np.array([t]))
            q = track.record(*(value[0] if np.ndim(value) else value for value in q))
            return float(track.formulas.functions(q, carried, track.b)[k])

        t = zero_of(lambda t: function(t) * known, 0 * n.delay, n.delay)
        self._note(event.name, now + t, track, self._series(n, np.array([t]))[0], -int(known))

    def _rows(
        self, phases: Sequence[tuple[Track, Sequence]], phase: np.ndarray, states: np.ndarray
    ) -> np.ndarray:
        """Return the rows of states (variables, k).

        `phases` are tracks, and the scaled integrals before they moved some; `phase` (k,) is the
        number of that of each state.
        """
        system, number, record = self.problem.system, self.number, self.carried
        tracks, wholes = zip(*phases, strict=True)
        owner, wholes = np.array([track.place for track in tracks])[phase], np.array(wholes).T
        rows, places = np.empty((self.variables, len(phase)), number), np.empty(len(phase), int)
        made, moving = 0, self.variables - len(wholes)
        for track in (known := dict.fromkeys(tracks)):
            mine = np.flatnonzero(owner == track.place)
            part = slice(made, made := made + len(mine))
            places[mine] = np.arange(part.start, part.stop)
            state, whole = (
                states[: track.width].take(mine, axis=1),
                wholes.take(phase[mine], axis=1),
            )
            whole[track.integrals] = state[track.moving :]
            q, carried = track.record(*state[: track.moving]), whole * number(1 / INTEGRAL_SCALE)
            values = (
                system.row(track.phase, q, record(*carried), self.body)
                if system.row
                else track.phase.leave(q, track.b)
            )
            for row, value in zip(rows, (*values[:moving], *whole), strict=True):
                row[part] = value
        return (rows if len(known) == 1 else rows.take(places, axis=1)).T

    def _slice(self, steps: int, when: Any, track: Track, status: Status | None) -> Slice:
        """Make rows of all that waits, give those that were asked for, and return the rest."""
        driver, n = self.track.driver, self.wanted.variables
        *columns, logged = driver.passages()
        times, asked = zip(
            *(
                (block.times[block.first : made], block.states[:, block.first : made])
                for block in self.blocks
                for made in block.made
            ),
            strict=True,
        )
        others = logged, driver.sampled(), np.resize(self.last, (1, n))
        states = np.concatenate([*asked, *(one[:, :n].T for one in others)], axis=1)
        tracks, wholes, counts = zip(*self.spans, (track, self.whole, self._counts()), strict=True)
        upto = np.array(counts, int)
        sizes = np.append(np.diff(upto, axis=0), [[0, 0, 1]], axis=0)
        phase = np.repeat(np.tile(np.arange(len(sizes)), 3), sizes.T.ravel())
        rows = self._rows([*zip(tracks, wholes, strict=True)], phase, states)
        asked, logged, samples, last = np.split(rows, np.cumsum(upto[-1]))
        if len(asked):
            self.request.take(np.concatenate(times), asked)
        passages = Passages._make([*(column.copy() for column in columns), logged])
        return Slice(steps, when, last, samples, passages, status, self.tables.take())

    # --- where the run is ------------------------------------------------------------------------

    @property
    def tally(self) -> Any:
        """The tally of the run."""
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
        return self._rows([(self.track, self.whole)], np.zeros(1, int), self.state[:, None])

    def extremes(self) -> Extremes:
        """Return those of the normal force so far, internal units."""
        known = [
            extremes_of(track.driver.rows.events, self.tallies) for track in self.tracks.values()
        ]
        known = [one for one in known if np.isfinite(one.least)]
        if not known:
            return Extremes()
        low, high = min(known, key=lambda one: one.least), max(known, key=lambda one: one.most)
        return Extremes(low.least, low.t_least, high.most, high.t_most)

    @property
    def width(self) -> int:
        """The greatest number of variables of a phase."""
        orientation = self.problem.orientation
        return max(
            len(Variables(p.form, orientation).names) + len(self.rows.events)
            for p in self.phases.values()
        )

    def snapshot(self) -> dict[str, Any]:
        """Return what a run needs to continue bit by bit: lists of the same lengths in every phase,
        but for `state`.
        """
        under_way = self.tables.under_way or [math.nan] * (1 + len(self.tables.tables["phases"]))
        phase = [list(self.phases).index(self.track.name), self.changes, self.short, self.began]
        phase += [self.until is not None, self.waits]
        return {
            **self.track.driver.snapshot(),
            "phase": [*phase, *under_way, *(k in self.live for k in self.numbers.values())],
            "carried": [*self.whole, self.number(0) if self.until is None else self.until],
        }

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot, of which state and time come in the working precision."""
        phase, changes, short, self.began, has_clock, self.waits, *rest = kept["phase"]
        self.changes, self.short = int(changes), int(short)
        count = 1 + len(self.tables.tables["phases"])
        under_way, live = rest[:count], rest[count:]
        self.track = track = self.track_of(list(self.phases)[int(phase)])
        *whole, until = kept["carried"].tolist()
        self.whole = tuple(whole)
        track.driver.restore(kept, state[: len(track.driver.state)], clock)
        self.live = {number for number, is_live in enumerate(live) if is_live}
        self._set_clock(until if has_clock else None)
        self.tables = PhaseTables(self.problem)
        self.tables.under_way = (
            None if math.isnan(under_way[0]) else [under_way[0], *map(int, under_way[1:])]
        )


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

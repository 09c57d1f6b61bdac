"""One run of a system of several phases: an ordinary driver for each, and jumps from one to
another.

Jumps are functions of the common state, which every phase can be read as; the driver does not
depend on balls or laws. All phases of a run have the same integrals.
"""

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from operator import itemgetter
from typing import Any, NamedTuple, cast

import heyoka as hy
import numpy as np

from ..errors import InputError, is_one_number
from ..mechanics.event import ON_ZERO as BELOW
from ..mechanics.event import Event
from ..mechanics.form import CLOCK, ENDS, Exit, Next, Phase
from ..mechanics.moment import moment
from ..mechanics.operand import leaves, refill
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..mechanics.variables import INTEGRAL_SCALE, Variables
from ..problem import Problem
from .changes import Changes
from .driver import (
    RUNNING,
    STATUSES,
    Driver,
    Extremes,
    Place,
    Request,
    Slice,
    Wanted,
    extremes_of,
    new_shared,
    view,
)
from .expressions import Formulas
from .impacts import ImpactMotions, kind_of
from .integrator import Compiled
from .loop import Rows
from .phase_tables import PhaseTables
from .python_events import Sampler, zero_of
from .status import Status
from .tallies import begin_lasting, event_rows
from .taylor import code_for, internal_end
from .wide import WideDriver


# End a slice after this many changes. A fixed count, not a time limit, keeps stores reproducible.
PER_SLICE = 256
CHATTER = 1e-12  # of the internal time, at least 1: phases so short, three in a row, lead nowhere
ROOT, SLOPE, NEAR = 1e-6, 1e-3, 1e-6
"""Least value of an event function, of order one, that is no root; least rate of one that has a
multiple root; and the time over which the rate is taken.
"""
QUIET = np.errstate(invalid="ignore", divide="ignore", over="ignore")
"""Jumps evaluate formulas outside their region; a motion that is not finite ends the run."""


# --- phases and jumps, for every run of a system ------------------------------------------------


@lru_cache(maxsize=256)
def completed(phase: Phase, variables: Variables) -> Phase:
    """Return a phase with the integrals of a run: those that it does not move stay."""
    moved = {one.name: one for one in Variables(phase.form, variables.orientation).integrals}
    integrals = tuple(
        moved.get(one.name, replace(one, rate=lambda q, carried, b: 0.0))
        for one in variables.integrals
    )
    return replace(phase, forms=replace(phase.form, integrals=integrals, orientation=None))


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
            whole, first = system.read(phase, q, carried, b)
            read = moment(system.phase.form, whole, carried, first)
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
    struck: Any  # of a body whose contact may open: see `exits`
    phase: Any = None
    left: Any = None

    def rates(self, phase: Phase, q: Any, carried: Any) -> list:
        """Return the rates of the integrals of the run in a state of a phase."""
        b = phase.parameters(self.body)
        return [integral.rate(q, carried, b) for integral in phase.form.integrals]


class Jump:
    """The jump of a phase by an exit, for every run of its system.

    Parameters
    ----------
    system, phases
        The system, and its phases by name.
    kind
        The contact and the kind of its impacts, for which a program is made.
    name, phase
        The phase that ends; "" at the start.
    exit
        How it ends.

    Attributes
    ----------
    calls, program
        How often Python has made it, and how the loop makes it: see `Changes`.
    """

    calls, program = 0, None

    def __init__(
        self, system: System, phases: tuple, kind: tuple, name: str, phase: Phase, exit: Exit
    ):
        self.phase, self.exit, self.variables = phase, exit, Variables(phase.form)
        tables, names = dict(system.tables), events_of(system, dict(phases))
        self.words = {
            "logged": names,
            "zeros": names,
            "sides": names,
            "cause": tables.pop("phases").get("reason", ()),
            "rows": tables,
            "ends": ENDS,
        }
        of_phase = f" from phase `{name}`" if name else ""
        self.where = f"the jump by `{exit.event}`{of_phase} of `{system.name}`"

    def __call__(self, state: Sequence, world: World) -> tuple:
        """Return what follows, as a Next; the variables with which the next phase begins, and the
        event functions there.

        The run ends, as `stalled`, if the jump raises ArithmeticError, or one of this package
        cannot compute: nothing can follow.

        Parameters
        ----------
        state
            The variables where the phase ended.
        world
            Of the run, with the time that is left.

        Raises
        ------
        InputError
            If the jump fails otherwise, or what it returns cannot follow.
        """
        q, carried = self.variables.split(state[: len(self.variables.names)])
        x = self.phase.leave(q, self.phase.parameters(world.body))
        if hasattr(x, "carried"):
            x = x._replace(carried=carried)
        try:
            return self._next(x, carried, world._replace(phase=self.phase))
        except InputError:
            raise
        except Exception as error:
            message, is_told = str(error), type(error) is ArithmeticError
            if not is_told:
                message = f"{self.where} fails: {type(error).__name__}: {error}"
            if not is_told and not (world.rules and isinstance(error, ArithmeticError)):
                raise InputError(message) from error
            return Next("", x, ends=Status.STALLED.value, message=message), (), ()

    def _next(self, x: Any, carried: Any, world: World) -> tuple:
        n = self.exit.jump(x, world)
        if fault := self.exit.fault(n, x, self.words):
            raise InputError(f"{self.where} must {fault}.")
        if n.cause is None:
            n.cause = self.exit.event
        if n.phase not in world.phases:
            return n, (), ()
        to, carried = world.phases[n.phase], getattr(n.x, "carried", carried)
        b = to.parameters(world.body)
        q = type(to.form.units)(*to.enter(n.x, b))
        types: Any = type(b), type(b.friction)
        formulas = formulas_of_phase(world.system, to, *types)
        values = formulas.functions(q, carried, b)
        fault = "" if world.rules else wrong_time(n, to) or wrong_root(n, formulas, q, carried, b)
        if fault:
            raise InputError(f"{self.where} must {fault}.")
        return n, Variables(to.form).join(q, carried), values


jump_of = lru_cache(maxsize=256)(Jump)
"""Returns the same `Jump` for the same exit: runs share its program."""


def begin_in_first(x: Any, world: World) -> Next:
    """Return the first phase."""
    return Next(next(iter(world.phases)), x)


def events_of(system: System, phases: Mapping[str, Phase]) -> dict[str, Event]:
    """Return the events of a run, by name."""
    in_phases = [event for phase in phases.values() for event in phase.events]
    return {event.name: event for event in (*system.events, *in_phases, *system.events)}


def wrong_time(n: Next, to: Phase) -> str:
    """Return what a time, or the motion in it, must be and is not; or ""."""
    times = {"delay": n.delay, "logged_after": n.logged_after, "lasts": n.lasts or 0}
    for what, time in times.items():
        if not (is_one_number(time) and time >= 0):
            return f"have a time of at least 0 in `{what}`, but has {time!r:.60}"
    if not callable(n.series or len):
        return f"have a function in `series`, but has {n.series!r:.60}"
    if n.lasts is not None and CLOCK not in [way.event for way in to.exits]:
        return f"leave out `lasts`, as phase `{n.phase}` has no exit by {CLOCK!r}"
    return ""


def wrong_root(n: Next, formulas: Formulas, q: Any, carried: Any, b: Any) -> str:
    """Return which event has no root of the multiplicity that `zeros` gives, or "".

    The value of its function, or its slope if there is more than one root, is not zero.
    """
    moved = (v + NEAR * rate for v, rate in zip(q, formulas.form.rates(q, b), strict=True))
    here, near = (formulas.functions(q, carried, b) for q in (q, type(q)(*moved)))
    for event, value, ahead in zip(formulas.events, here, near, strict=True):
        count = n.zeros.get(event.name, 0)
        if (count > 0 and abs(value) >= ROOT) or (count > 1 and abs(ahead - value) >= SLOPE * NEAR):
            return (
                f"give multiplicities of roots in `zeros`, but {event.name!r} has no root of "
                f"multiplicity {count} where phase `{n.phase}` begins"
            )
    return ""


# --- runs ---------------------------------------------------------------------------------------


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
        problem, phase = run.problem, run.phases[name]
        self.name, self.phase, self.at = name, phase, [*run.phases].index(name)
        self.b, self.variables = phase.parameters(run.world.body), Variables(phase.form)
        self.width = len(self.variables.names)
        stops = problem.on_liftoff == "stop"
        self.exits = {  # by the number of the event
            run.numbers.get(exit.event, CLOCK): run.jump(name, phase, exit)
            for exit in phase.exits
            if not (stops and exit.event == Status.LIFTOFF.value)
        }
        types: Any = type(self.b), type(self.b.friction)
        self.formulas = formulas_of_phase(problem.system, phase, *types)
        self.events = {run.numbers[event.name]: event for event in self.formulas.events}
        self.live = self.events.keys() - self.exits.keys()
        code = code_for(problem, self.formulas, run.stop)
        records = self._records(run, code.rows.events)
        rows = run.all_events._replace(events=records, axis=code.rows.axis)
        samples = run.shared.samples._replace(in_lane=np.full(1, self.at))
        shared = run.shared._replace(samples=samples)
        self.place = Place(code, run.stepper_of(code), rows, shared)
        run.take(self.place, leaves(self.b))
        sampled = {run.numbers[event.name]: event for event in phase.events if event.sampled}
        self.sampler = Sampler(phase.form, self.b, code.integrator, sampled) if sampled else None

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the events of the run, of which those of this phase, `mine`, are looked for."""
        known, numbers = run.all_events.events, [*self.events]
        known["scale"][numbers] = mine["scale"]
        records = np.zeros_like(known)
        records[numbers] = mine
        records["first"], records["last"] = known["first"], known["last"]
        ways = [k for k in numbers if k in self.exits]
        records["first"][ways] = records["last"][ways] = 0  # its jump logs
        records["ends"][ways] = Status.ENDED.code
        records["watched"][numbers] = [
            not event.sense or event.name in run.problem.events for event in self.events.values()
        ]
        return records

    def value(self, number: int, state: Any) -> Any:
        """Return an event function in a state."""
        functions = self.formulas.functions(*self.variables.split(state), self.b)
        return functions[[*self.events].index(number)]

    def sides(self, n: Next) -> dict[int, tuple[int, int]]:
        """Return the signs with which the events that end the phase begin, and minus the numbers of
        their roots there, by number.
        """
        return {
            k: (n.sides.get(event.name, -event.direction), -n.zeros.get(event.name, 0))
            for k, event in self.events.items()
            if k in self.exits
        }


class HybridDriver(Driver):
    """Makes the steps of a run through its phases.

    Parameters
    ----------
    problem
        The run.
    stop
        Set it to give up while equations are being compiled.
    """

    track: Track
    last: np.ndarray  # the state where the last phase ended
    width = 0  # the greatest number of variables of a phase

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        system, number = problem.system, float if problem.precision == "double" else problem.number
        self.problem, self.stop, self.number = problem, stop, number  # floats are faster
        self.end = number(internal_end(problem))
        body, phases = _assembled(problem)
        body = refill(body, map(number, leaves(body)))
        self.phases = {name: completed(one, problem.variables) for name, one in phases.items()}
        self.variables = len(problem.variables.names)
        self.at_start = np.ones(len(system.events))  # the phase of the start is chosen
        self.events = [*events_of(system, self.phases).values()]
        self.numbers = {event.name: k for k, event in enumerate(self.events)}
        rows = event_rows(self.events, [(0, 1, 1.0, 0.0)] * len(self.events), ())
        for event in (event for phase in self.phases.values() for event in phase.events):
            rows.events[self.numbers[event.name]]["extremes"] |= bool(event.extremes)
        widths = (len(Variables(phase.form).names) for phase in self.phases.values())
        self.all_events, self.width = rows, max(widths) + len(self.events)
        self.shared = new_shared(rows, np.ones((len(self.events), 1)), self.width, number)
        functions = self.shared.tallies.functions
        functions["sign"] = 0.0  # not known
        self.signs, self.zeros = (view(functions[of][:, 0]) for of in ("sign", "on_zero"))
        width = self.width - len(self.events)
        self.wanted, self.tables = Wanted(width, number), PhaseTables(problem)
        self.tracks: dict[str, Track] = {}
        self.short = 0
        self.changes = 0  # in a slice
        contact, kind, struck = problem.contact, None, None
        if contact is not None:
            kind = kind_of(problem, body[0].friction)
            self.impacts = ImpactMotions(*kind, stop)
            struck = self.impacts.struck
        self.key = system, tuple(self.phases.items()), (contact, kind)
        self.world = World(body, system, contact, self.phases, struck)
        is_plain = contact is None or number is not float
        self.copies = None if is_plain else Changes(self, CHATTER, PER_SLICE)
        self._start(tuple(problem.start().tolist()))
        self.first = self.present()

    def _start(self, state: tuple) -> None:
        """Enter the first phase."""
        system, world = self.problem.system, self.world._replace(left=self.end)
        phase = completed(system.phase, self.problem.variables)
        begins = Exit("start", tuple(self.phases), system.begin or begin_in_first)
        begun = n, *_ = self.jump("", phase, begins)(state, world)
        if n.ends:
            self.ended, self.sentence = Status.of_event(n.ends), n.message
        if not n.phase:
            begun = self.jump("", phase, replace(begins, jump=begin_in_first))(state, world)
        self._enter(begun, self.number(0), None)
        begin_lasting(self.shared.tallies, self.all_events)

    # --- phases ----------------------------------------------------------------------------------

    def jump(self, name: str, phase: Phase, exit: Exit) -> Jump:
        """Return the jump of a phase by an exit."""
        return jump_of(*self.key, name, phase, exit)

    def track_of(self, name: str) -> Track:
        """Return the phase of this name, compiled when it is first entered."""
        if name not in self.tracks:
            track = self.tracks[name] = Track(self, name)
            if self.copies:
                for jump in track.exits.values():
                    self.copies.take_up(track, jump)
        return self.tracks[name]

    def codes(self) -> tuple[Compiled, ...]:
        return tuple(self.track_of(name).place.compiled for name in self.phases)

    def follow(self, track: Track, began: float) -> None:
        """Make the next steps in a phase that begins at an internal time."""
        self.track, self.began = track, began
        self.work_in(track.place)

    def _enter(self, begun: tuple, now: Any, before: Track | None) -> None:
        """Take up what follows a phase `before`, at an internal time."""
        n, state, values = begun
        track, time = self.track_of(n.phase), min(now + self.number(n.delay), self.end)
        self.follow(track, float(time))
        if n.cause:
            row = self.tables.row_of(track.name, track.phase, n.cause)
            self.tables.begin(float(now + n.logged_after), row)
        self.tables.add(float(now), n.rows)
        self.put(state, (time, 0 * time))
        passed = self._begin_events(n, values, before)
        if n.series is None:
            for number, sign in passed:
                event, track = self.events[number], cast(Track, before)
                is_corner = event.sense and abs(track.value(number, self.last)) > BELOW  # of theta
                if is_corner or (event.lasting and sign == event.direction):
                    self._note(number, now, sign, track, self.last)
        else:
            self._fill(lambda times: self._series(n, *(times.astype(self.number) - now)))
            for number, sign in passed:
                self._note_along(n, number, sign, now)
        self.begin()
        self.time[0] = self.began
        self.until = math.nan if n.lasts is None else time + self.number(n.lasts)

    def _begin_events(
        self, n: Next, values: Sequence, before: Track | None
    ) -> list[tuple[int, int]]:
        """Write on which side of their zeros the event functions of a phase begin.

        Return the events that have passed in the jump, and their signs now.
        """
        track, signs, zeros, passed = self.track, self.signs, self.zeros, []
        known, sides = before.live if before else (), track.sides(n)
        for number, value in zip(track.events, values, strict=True):
            sign, is_near = 1 if value > 0 else -1, abs(value) < BELOW
            zeros[number] = 0
            if number in sides:
                signs[number], zeros[number] = sides[number]
            elif number not in known:
                signs[number], zeros[number] = sign, is_near
            elif sign != signs[number] and not is_near:
                signs[number] = sign
                passed.append((number, sign))
        return passed

    # --- steps -----------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        return replace(super().advance(request, most), tables=self.tables.take())

    def run(self, most: int) -> tuple[int, Any, np.ndarray, Status | None]:
        """Make at most `most` steps, through as many phases as they take."""
        self.changes = 0
        steps, status, when = 0, None, self.end
        while self.clock[0] < self.end:
            self._fill(lambda times: np.tile(self.state, (len(times), 1)))
            ending = self._end_next()
            steps += self.drive(1 if self.track.sampler else most - steps)
            track, code = self.track, self.status[0]
            when, last = self.reached()
            self.last = last[: track.width].copy()
            status = None if code == RUNNING else STATUSES[code]
            if self.upto[0] < 1.0:
                ending = self.log.rows["event"][self.logged[0] - 1]
            elif status is not Status.FINISHED:
                ending = None
            jump = track.exits.get(ending)
            if jump:
                if self.upto[0] < 1.0:
                    self.logged[0] -= 1  # the jump logs it
                status = self._change(jump, when)
            is_full = self.changes >= PER_SLICE or not (jump or track.sampler)
            if status is not None or steps >= most or is_full:
                break
        if status is None:
            self.last = self.state[: self.track.width].copy()
            if not self.clock[0] < self.end:  # a phase begins where the run ends, and takes no step
                when, status = self.end, Status.FINISHED
                self.tally["upto"] = 0.0
        if status is not None:
            self.tables.end(float(when))
        return steps, when, np.resize(self.last, self.width), status

    def _end_next(self) -> Any:
        """Put the end of the next steps at that of the phase, or where a sampled event happens in
        the next one.

        Return that event, or CLOCK; None at the end of the run.
        """
        has_clock = CLOCK in self.track.exits and self.until < self.end
        end = (self.until, CLOCK) if has_clock else (self.end, None)
        sampler = self.track.sampler
        when, ending = min([end, *(sampler.next(self) if sampler else ())], key=itemgetter(0))
        self.end_at(when)
        return ending

    def _change(self, jump: Jump, when: Any) -> Status | None:
        """Take up what follows the end of a phase in its last state.

        Return how it ends the run, or None.
        """
        shortest = CHATTER * max(self.began, 1.0)
        self.short = self.short + 1 if float(when) - self.began < shortest else 0
        now, track, last = self.number(when), self.track, self.last
        given = tuple(last.tolist()), self.world._replace(left=self.end - now)
        begun = n, state, _ = jump(*given)
        if self.copies:
            self.copies.learn(jump, *given)
        for name in n.logged:
            self._note(self.numbers[name], now + n.logged_after, 1, track, last)
        if n.ends:
            self.sentence = n.message or f"{jump.where} ends the run"
            self.tables.add(float(when), n.rows)
            return Status.of_event(n.ends)
        if self.short > 2:
            shortest *= float(self.problem.scales.of(SECOND))
            self.sentence = (
                f"phases change more often than every {shortest:.1g} s, at last "
                f"from `{track.name}` to `{n.phase}` by `{jump.exit.event}`"
            )
            return Status.STALLED
        if not math.isfinite(sum(state)):
            self.sentence = f"{jump.where} must lead to a finite state, but leads to {n.x!r:.60}"
            return Status.NON_FINITE
        if self.request.steps and self.upto[0] < 1.0:  # the loop keeps the ends of steps
            self.add(np.array([when]), last[None])
        self._enter(begun, now, track)
        self.changes += 1
        return None

    # --- rows ------------------------------------------------------------------------------------

    def make(self, rows: Rows, most: int) -> int:
        if self.copies is None or self.request.steps or self.track.sampler:
            return super().make(rows, most)
        return self.copies.drive(most, PER_SLICE - self.changes)

    def _note(self, number: int, time: Any, sign: int, track: Track, state: np.ndarray) -> None:
        """Log an event that no step has logged, in a state of a phase."""
        at, when = self.logged[0], float(time)
        self.log.rows[at] = when, number, sign, track.at, False
        self.exact.times[at], self.exact.states[at, : len(state)] = time, state
        self.logged[0] += 1
        if self.events[number].lasting:
            self.tally["lasts_since"] = when
        self.loop.keep(self.all_events.events[number], when, sign)

    def _series(self, n: Next, *times: Any) -> np.ndarray:
        """Return states at times since the beginning of a jump that takes time."""
        values = self.track.variables.join(*n.series(np.array(times)))
        return np.array([[self.number(one) for one in value] for value in values]).T

    def _fill(self, states_at: Callable[[np.ndarray], np.ndarray]) -> None:
        """Give the rows that are wanted before the first step of the present phase."""
        while not self.request.steps:
            if self.wanted.is_made:
                self.ask()
            times = self.wanted.rows.times[self.wanted.made[0] :]
            inside = times[: np.searchsorted(times, self.began)]
            if len(inside):
                self.add(inside, states_at(inside))
            if len(inside) < len(times) or not len(times):
                break

    def _note_along(self, n: Next, number: int, sign: int, now: Any) -> None:
        """Log an event that happens in a jump that takes time."""
        track = self.track

        def function(t: Any) -> float:
            return -sign * float(track.value(number, self._series(n, t)[0]))

        t = zero_of(function, 0 * n.delay, n.delay)
        self._note(number, now + t, sign, track, self._series(n, t)[0])

    def rows_of(self, *parts: tuple[np.ndarray, np.ndarray]) -> list[np.ndarray]:
        system, variables = self.problem.system, self.problem.variables
        at = np.concatenate([phases for phases, _ in parts])
        width = self.width - len(self.events)
        states = np.concatenate([some[:, :width] for _, some in parts]).T
        rows = np.empty((self.variables, len(at)), self.number)
        for track in self.tracks.values():
            mine = np.flatnonzero(at == track.at)
            # NumPy cannot multiply an array of quadruple numbers by a literal of a user's formula
            each: Any = mine if self.number is hy.real128 else [mine][: len(mine)]
            for some in each:
                n, state = track.variables.moving, states[: track.width, some]
                q, moved = type(track.phase.form.units)(*state[:n]), state[n:]
                carried = variables.carried(*(moved * self.number(1 / INTEGRAL_SCALE)))
                read, _ = system.read(track.phase, q, carried, track.b)
                for row, value in zip(rows, (*read[: variables.moving], *moved), strict=True):
                    row[some] = value
        return np.split(rows.T, np.cumsum([len(phases) for phases, _ in parts[:-1]]))

    # --- where the run is ------------------------------------------------------------------------

    def last_rows(self) -> dict[str, dict[str, np.ndarray]]:
        """End the phase that is under way; return its row."""
        self.tables.end(float(self.clock[0]))
        return self.tables.take()

    def extremes(self) -> Extremes:
        return extremes_of(self.all_events.events, self.tallies)

    def snapshot(self) -> dict[str, Any]:
        """Return what a run needs to continue bit by bit: lists of the same lengths in every phase,
        but for `state`.
        """
        phase = self.track.at, self.short, self.began, *self.tables.under_way
        return super().snapshot() | {"phase": [*phase], "until": [self.number(self.until)]}

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue from a snapshot, of which state and time come in the working precision."""
        at, short, began, *under_way = kept["phase"]
        self.short, (self.until,) = int(short), kept["until"]
        self.follow(self.track_of([*self.phases][int(at)]), began)
        super().restore(kept, state[: len(self.state)], clock)
        self.tables = PhaseTables(self.problem)
        self.tables.under_way = under_way


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

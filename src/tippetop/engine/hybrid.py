"""One run of a system of several phases: an ordinary driver for each, and jumps from one to
another.

Jumps are functions of the common state, which every phase can be read as; the driver does not
depend on balls or laws. All phases of a run have the same integrals.
"""

import math
import threading
import weakref
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..errors import InputError, is_one_number
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
from .impacts import ImpactMotions, kind_of
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
from .taylor import code_for
from .wide import WideDriver


# End a slice after this many changes. A fixed count, not a time limit, keeps stores reproducible.
PER_SLICE = 256
CHATTER = 1e-12  # internal time: phases so short, three in a row, lead nowhere
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
    phase: Phase
    left: Any
    struck: Any  # of a body whose contact may open: see `exits`

    def rates(self, phase: Phase, q: Any, carried: Any, b: Any = None) -> list:
        """Return the rates of the integrals of the run in a state of a phase. `b` is the body in
        the numbers of the state, if they are others.
        """
        b = b or phase.parameters(self.body)
        return [integral.rate(q, carried, b) for integral in phase.form.integrals]


class Jump:
    """The jump of a phase by an exit, for every run of its system.

    Parameters
    ----------
    system, phases
        The system, and its phases by name.
    name, phase
        The phase that ends; "" at the start.
    exit
        How it ends.
    rules
        Of the contact.

    Attributes
    ----------
    calls, program
        How often Python has made it, and how the loop makes it: see `Changes`.
    """

    calls, program = 0, None

    def __init__(
        self, system: System, phases: tuple, name: str, phase: Phase, exit: Exit, rules: Any
    ):
        self.world = World(None, system, rules, dict(phases), phase, None, None)
        self.exit, self.variables = exit, Variables(phase.form)
        self.events = events_of(system, self.world.phases)
        of_phase = f" from phase `{name}`" if name else ""
        self.where = f"the jump by `{exit.event}`{of_phase} of `{system.name}`"

    def __call__(self, state: Sequence, left: Any, struck: Any, body: Any) -> tuple:
        """Return what follows, as a Next; the variables with which the next phase begins, and the
        event functions there.

        Parameters
        ----------
        state
            The variables where the phase ended.
        left
            The time to the end of the run.
        struck
            See `World`.
        body
            The body.

        Raises
        ------
        ArithmeticError
            If the jump raises it, or one of this package cannot compute: nothing can follow.
        InputError
            If the jump fails otherwise, or what it returns cannot follow.
        """
        world = self.world._replace(body=body, left=left, struck=struck)
        try:
            return self._next(state, world)
        except Exception as error:
            if type(error) in (ArithmeticError, InputError):
                raise
            is_ours = world.rules and isinstance(error, ArithmeticError)
            message = f"{self.where} fails: {type(error).__name__}: {error}"
            raise (ArithmeticError if is_ours else InputError)(message) from error

    def _next(self, state: Sequence, world: World) -> tuple:
        q, carried = self.variables.split(state[: len(self.variables.names)])
        x = world.phase.leave(q, world.phase.parameters(world.body))
        if hasattr(x, "carried"):
            x = x._replace(carried=carried)
        n = self.exit.jump(x, world)
        if fault := fault_of(n, self.exit, x, self.events):
            raise InputError(f"{self.where} must {fault}.")
        if n.cause is None:
            n.cause = self.exit.event
        if n.phase not in world.phases:
            return n, (), ()
        to, carried = world.phases[n.phase], getattr(n.x, "carried", carried)
        b = to.parameters(world.body)
        q = type(to.form.units)(*to.enter(n.x, b))
        types: Any = type(b), type(b.friction)
        functions = formulas_of_phase(world.system, to, *types).functions
        return n, Variables(to.form).join(q, carried), functions(q, carried, b)


@lru_cache(maxsize=256)
def jump_of(impacts: tuple | None, *given: Any) -> Jump:
    """Return the jump with these arguments. Its program is that for impacts of this kind."""
    return Jump(*given)


def begin_in_first(x: Any, world: World) -> Next:
    """Return the first phase."""
    return Next(next(iter(world.phases)), x)


def events_of(system: System, phases: Mapping[str, Phase]) -> dict[str, Event]:
    """Return the events of a run, by name."""
    in_phases = [event for phase in phases.values() for event in phase.events]
    return {event.name: event for event in (*system.events, *in_phases, *system.events)}


def fault_of(n: Any, exit: Exit, x: Any, events: Collection[str]) -> str:
    """Return what the result of a jump must be and is not; empty if it can follow the state `x`."""
    if not isinstance(n, Next):
        return f"return a Next, but returns {n!r:.60}"
    for what, kind in {"ends": str, "logged": tuple, "zeros": dict, "sides": dict}.items():
        if not isinstance(value := getattr(n, what), kind):
            return f"have a {kind.__name__} in `{what}`, but has {value!r:.60}"
    if n.phase not in exit.to and not n.ends:
        return f"lead to {' or '.join(exit.to)}, as its Exit declares, but leads to {n.phase!r}"
    if type(n.x) is not type(x):
        return f"return a state as it takes ({type(x).__name__}), but returns {n.x!r:.60}"
    for name, value in n.x._asdict().items():
        if not all(is_one_number(one) for one in leaves((value,))):
            return f"return a number in `{name}` of the state, but returns {value!r:.60}"
    for what, names in (("logged", n.logged), ("zeros", n.zeros), ("sides", n.sides)):
        for name in names:
            if name not in events:
                return f"have events of the system in `{what}`, but has {name!r}"
    if not all(type(count) is int and count > 0 for count in n.zeros.values()):
        return f"have multiplicities of roots in `zeros`, 1 at least, but has {dict(n.zeros)}"
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
        self.b, self.variables = phase.parameters(run.body), Variables(phase.form)
        self.width = len(self.variables.names)
        stops = problem.on_liftoff == "stop"
        self.exits = {
            exit.event: run.jump(name, phase, exit)
            for exit in phase.exits
            if not (stops and exit.event == Status.LIFTOFF.value)
        }
        types: Any = type(self.b), type(self.b.friction)
        self.formulas = formulas_of_phase(problem.system, phase, *types)
        self.events = {run.numbers[event.name]: event for event in self.formulas.events}
        self.ways = {k: one.name for k, one in self.events.items() if one.name in self.exits}
        self.live = self.events.keys() - self.ways.keys()
        code = code_for(problem, self.formulas, run.stop)
        records = self._records(run, code.rows.events)
        rows = run.all_events._replace(events=records, axis=code.rows.axis)
        self.place = Place(code, run.stepper_of(code), rows, run.shared)
        run.take(self.place, leaves(self.b))
        sampled = [event for event in phase.events if event.sampled]
        self.sampler = Sampler(phase.form, self.b, code.integrator, sampled) if sampled else None

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the events of the run, of which those of this phase, `mine`, are looked for."""
        known, numbers, ways = run.all_events.events, [*self.events], [*self.ways]
        known["scale"][numbers] = mine["scale"]
        records = np.zeros_like(known)
        records[numbers] = mine
        records["first"], records["last"] = known["first"], known["last"]
        records["first"][ways] = records["last"][ways] = 0  # its jump logs
        records["ends"][ways] = Status.ENDED.code
        records["watched"][numbers] = [
            not event.sense or event.name in run.problem.events for event in self.events.values()
        ]
        return records

    def sides(self, n: Next) -> dict[int, tuple[int, int]]:
        """Return the signs with which the events that end the phase begin, and how many roots they
        have there, by number.
        """
        return {
            k: (n.sides.get(name, -self.events[k].direction), n.zeros.get(name, 0))
            for k, name in self.ways.items()
        }

    def has_root(self, number: int, count: int, state: Sequence, values: Sequence) -> bool:
        """Return whether an event function has a root of this multiplicity in a state with these
        values: its value, and its slope if there is more than one root, are zero.
        """
        k, split = [*self.events].index(number), self.variables.split
        if count == 1 or not abs(values[k]) < ROOT:
            return abs(values[k]) < ROOT
        rates = self.variables.rates(*split(state), self.b)
        near = [one + NEAR * rate for one, rate in zip(state, rates, strict=True)]
        ahead = self.formulas.functions(*split(near), self.b)[k]
        return abs(ahead - values[k]) < SLOPE * NEAR


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
        self.second = float(problem.scales.of(SECOND))
        self.end = number(problem.until) / number(self.second)
        self.body, phases = _assembled(problem)
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
        self.shared = Shared(
            new_tallies(rows, 1),
            new_log(PASSAGES + len(self.events) * MOST_COEFFICIENTS, self.width),
            new_samples(STEPS_PER_SLICE + 2, self.width),
        )
        functions = self.shared.tallies.functions
        functions[SIGN] = 0.0  # not known
        self.signs, self.zeros = (view(functions[kind, :, 0]) for kind in (SIGN, ON_ZERO))
        self.wanted, self.tables = Wanted(self.width - len(self.events)), PhaseTables(problem)
        self.tracks: dict[str, Track] = {}
        self.short = 0
        # the phases of a slice: their places, and the numbers of rows, passages and samples before
        self.spans: list[list[int]] = []
        self.states = np.empty((self.wanted.variables, 0), number)  # of the rows
        self.copies: Changes | None = None
        self.kind = self.impacts = self.struck = None
        if problem.contact is not None:
            self.kind = kind_of(problem, self.body[0].friction)
            self.impacts = ImpactMotions(*self.kind, stop)
            self.struck = self.impacts.struck
            self.copies = Changes(self, CHATTER, PER_SLICE) if number is float else None
        self._start(tuple(problem.start().tolist()))
        self.first = self.present()

    def _start(self, state: tuple) -> None:
        """Enter the first phase."""
        system = self.problem.system
        phase = completed(system.phase, self.problem.variables)
        begins = Exit("start", tuple(self.phases), system.begin or begin_in_first)
        given = state, self.end, self.struck, self.body
        try:
            begun = self.jump("", phase, begins)(*given)
            ends, self.sentence = begun[0].ends, begun[0].message
        except ArithmeticError as error:
            begun = self.jump("", phase, replace(begins, jump=begin_in_first))(*given)
            ends, self.sentence = "stalled", str(error)
        if ends:
            self.ended = Status(ends)
        self._enter(begun, self.number(0), None)

    # --- phases ----------------------------------------------------------------------------------

    def jump(self, name: str, phase: Phase, exit: Exit) -> Jump:
        """Return the jump of a phase by an exit."""
        problem = self.problem
        phases = tuple(self.phases.items())
        return jump_of(self.kind, problem.system, phases, name, phase, exit, problem.contact)

    def track_of(self, name: str) -> Track:
        """Return the phase of this name, compiled when it is first entered."""
        if name not in self.tracks:
            track = self.tracks[name] = Track(self, name)
            if self.copies:
                for jump in track.exits.values():
                    self.copies.take_up(self, track, jump)
        return self.tracks[name]

    def equations(self) -> list[tuple]:
        """Return the equations of every phase: pairs of a variable and its rate."""
        codes = (self.track_of(name).place.compiled for name in self.phases)
        return [pair for code in codes for pair in code.integrator.sys]

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
                event = self.events[number]
                if event.sense or (event.lasting and sign == event.direction):
                    self._note(number, now, self.last, sign)  # of theta: it has a corner
            self._begin_span()
        else:
            self._begin_span()
            self._fill(lambda times: self._series(n, times.astype(self.number) - now))
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
        known = before.live if before else ()
        for number, value in zip(track.events, values, strict=True):
            sign, is_near, is_new = 1 if value > 0 else -1, abs(value) < BELOW, number not in known
            if number in track.live and not is_new and sign != signs[number]:
                if is_near:
                    sign = int(signs[number])
                else:
                    passed.append((number, sign))
            signs[number], zeros[number] = sign, is_new and is_near
        for number, (side, roots) in track.sides(n).items():
            signs[number], zeros[number] = side, -roots
        return passed

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
                ending := track.ways.get(self.log.rows["event"][self.logged[0] - 1])
            ):
                self.drop()  # the jump logs it
            if ending is not None:
                status = self._change(track.exits[ending], when)
            is_full = len(self.spans) > PER_SLICE or not (ending or track.sampler)
            if status is not None or steps >= most or is_full:
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
        when, name = min([(end, ""), *(sampler.next(self) if sampler else ())])
        self.end_at(when)
        return name

    def _change(self, jump: Jump, when: Any) -> Status | None:
        """Take up what follows the end of a phase in its last state.

        Return how it ends the run, or None.
        """
        self.short = self.short + 1 if float(when) - self.began < CHATTER else 0
        now, track, last = self.number(when), self.track, self.last
        given = tuple(last.tolist()), self.end - now, self.struck, self.body
        try:
            begun = n, state, values = jump(*given)
        except ArithmeticError as error:
            self.sentence = str(error)
            return Status.STALLED
        if self.copies:
            self.copies.learn(self, jump, given)
        for name in n.logged:
            self._note(self.numbers[name], now + n.logged_after, last, 1)
        if n.ends:
            self.sentence = n.message or f"{jump.where} ends the run"
            self.tables.add(float(when), n.rows)
            return Status.of_event(n.ends)
        if self.short > 2:
            self.sentence = (
                f"phases change more often than every {CHATTER * self.second:.1g} s, at last "
                f"from `{track.name}` to `{n.phase}` by `{jump.exit.event}`"
            )
            return Status.STALLED
        if not math.isfinite(sum(state)):
            self.sentence = f"{jump.where} must lead to a finite state, but leads to {n.x!r:.60}"
            return Status.NON_FINITE
        if self.request.steps and self.upto[0] < 1.0:  # the loop keeps the ends of steps
            self._add(np.array([when]), last[None])
        self._enter(begun, now, track)
        sides = self.track.sides(n) if self.problem.contact is None else {}
        for number, (_, count) in sides.items():
            if count and not self.track.has_root(number, count, state, values):
                raise InputError(
                    f"{jump.where} must give multiplicities of roots in `zeros`, but "
                    f"{self.events[number].name!r} has no root of multiplicity {count} where phase "
                    f"`{n.phase}` begins."
                )
        return None

    # --- rows ------------------------------------------------------------------------------------

    def _begin_span(self) -> None:
        """Note that rows, passages and samples belong to the present phase from now on."""
        counts = self.wanted.made[0], self.logged[0], self.sampled_so_far[0]
        self.spans.append([self.track.at, *counts])

    def ask(self) -> None:
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
        return self.copies.drive(self, most, PER_SLICE + 1 - len(self.spans))

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

    def _note(self, number: int, time: Any, state: np.ndarray, sign: int) -> None:
        """Log an event that no step has logged, in a state of the phase of the last span."""
        self.note(time, number, sign, state)
        if self.events[number].lasting:
            self.tally["lasts_since"] = float(time)
        self.loop.keep(self.all_events.events[number], float(time), sign)

    def _series(self, n: Next, since: np.ndarray) -> np.ndarray:
        """Return states at times since the beginning of a jump that takes time."""
        t = np.array([min(max(one, 0 * n.delay), n.delay) for one in since])
        states = [
            [self.number(one) for one in np.broadcast_to(value, t.shape)]
            for value in self.track.variables.join(*n.series(t))
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

    def _note_along(self, n: Next, number: int, sign: int, now: Any) -> None:
        """Log an event that happens in a jump that takes time."""
        track = self.track
        k = [*track.events].index(number)

        def function(t: Any) -> float:
            q, carried = n.series(np.array([t]))
            q = q._make(value[0] if np.ndim(value) else value for value in q)
            return -sign * float(track.formulas.functions(q, carried, track.b)[k])

        t = zero_of(function, 0 * n.delay, n.delay)
        self._note(number, now + t, self._series(n, np.array([t]))[0], sign)

    def _rows(self, *parts: tuple[int, int, np.ndarray]) -> list[np.ndarray]:
        """Return the rows of states.

        Parameters
        ----------
        parts
            What they are: rows (1), passages (2) or samples (3) of a slice, from this number on;
            and the states (variables, k).
        """
        system, variables = self.problem.system, self.problem.variables
        begin, states = np.array(self.spans), np.concatenate([part[2] for part in parts], axis=1)
        ends = np.cumsum([part[2].shape[1] for part in parts])
        at = np.empty(ends[-1], int)
        for (kind, first, some), mine in zip(parts, np.split(at, ends[:-1]), strict=True):
            numbers = first + np.arange(some.shape[1])
            mine[:] = begin[np.searchsorted(begin[:, kind], numbers, side="right") - 1, 0]
        rows = np.empty((self.variables, len(at)), self.number)
        for track in self.tracks.values():
            mine = np.flatnonzero(at == track.at)
            # NumPy cannot multiply an array of quadruple numbers by a literal of a user's formula
            for some in mine if self.number is hy.real128 else [mine][: len(mine)]:
                n, state = track.variables.moving, states[: track.width, some]
                q, moved = type(track.phase.form.units)(*state[:n]), state[n:]
                carried = variables.carried(*(moved * self.number(1 / INTEGRAL_SCALE)))
                read = (
                    system.row(track.phase, q, carried, self.body)
                    if system.row
                    else track.phase.leave(q, track.b)
                )
                for row, value in zip(rows, (*read[: variables.moving], *moved), strict=True):
                    row[some] = value
        return np.split(rows.T, ends[:-1])

    def _slice(self, steps: int, when: Any, status: Status | None) -> Slice:
        """Give the rows that exist, and return what else the steps have found."""
        *columns, logged = self.passages()
        n, samples = self.wanted.variables, self.sampled()
        logged, samples, end = self._hand_over(
            (2, 0, logged[:, :n].T),
            (3, 0, samples[:, :n].T),
            (1, self.wanted.made[0], np.resize(self.last, (n, 1))),
        )
        passages = Passages._make([*(column.copy() for column in columns), logged])
        return Slice(steps, when, end, samples, passages, status, self.tables.take())

    # --- where the run is ------------------------------------------------------------------------

    def last_rows(self) -> dict[str, dict[str, np.ndarray]]:
        """End the phase that is under way; return its row."""
        self.tables.end(float(self.clock[0]))
        return self.tables.take()

    def present(self) -> np.ndarray:
        """Return the row of the present state, (1, variables)."""
        self.spans = [[self.track.at, 0, 0, 0]]
        return self._rows((1, 0, self.state[:, None]))[0]

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

"""One run of a hybrid system: several phases with equations of their own, and jumps between them.

A `Problem` whose system has phases goes in; out come slices, as from `driver.Driver`, and rows of
the tables of phases and impacts. Each phase has its own integrator; all of them share the tallies,
the log and the integrals of the run. A phase ends by an exit: an event, and a jump, which is a
function of the state that all phases have in common. The driver does not depend on balls or
friction laws.

Symbols
    n         the result of a jump, a `form.Next`; x: the common state, in which a phase ends
    q         the state of a phase; carried: the record of the integrals of the run
    b, body   parameters of the formulas of a phase; the body, from which they are taken
    number    of an event: its index among all events of the run, `HybridDriver.numbers`; of an
              exit the same, or that of the clock or a stall, `endings`
    solver    a `PhaseSolver`; at: the index of its phase
    signs     of event functions: the side of its zero on which each is; zeros: see `begins`
"""

import copy
import math
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import islice, repeat
from operator import itemgetter
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..arguments import PlainData
from ..errors import BuildError, InputError, Interrupted, is_one_number
from ..mechanics.dual import has_derivatives
from ..mechanics.event import ON_ZERO, zero_of
from ..mechanics.form import CLOCK, ENDS, MOST_LOGGED, STALL, Exit, Next, Phase
from ..mechanics.moment import moment
from ..mechanics.operand import kinds, leaves, refill
from ..mechanics.readonly import ReadOnly
from ..mechanics.system import System
from ..mechanics.units import SECOND
from ..mechanics.variables import Variables, variables_of
from ..problem import Problem
from .column_programs import repeated
from .driver import (
    PASSAGES,
    RUNNING,
    STATUSES,
    Driver,
    Request,
    Slice,
    Workspace,
)
from .expressions import Formulas
from .impacts import ImpactMotions
from .integrator import Compiled
from .jump_programs import CHATTER, PER_SLICE, START, JumpPrograms, jump_times
from .loop import library
from .phase_tables import PhaseTables
from .python_events import sampled_in_next_step
from .status import Status
from .tallies import event_rows, lasts_from_start
from .taylor import code_for, internal_end
from .wide import WideDriver


ROOT, SLOPE, NEAR = 1e-6, 1e-3, 1e-6
"""Least value of an event function, of order one, that is no root; least rate of one that has a
multiple root; and the time over which the rate is taken.
"""
AT_END = 2.0**-50
"""An event that ends a phase in this last part of a run is left to a run that begins there. loop.c
has the same number.
"""
QUIET = np.errstate(all="ignore")
"""Jumps evaluate formulas outside their region; a motion that is not finite ends the run."""


# --- phases and jumps, for every run of a system ------------------------------------------------


@lru_cache(maxsize=256)
def completed(phase: Phase, variables: Variables) -> Phase:
    """Return a phase with all integrals of a run, so that every phase has the same ones.

    Integrals that the phase does not change have the rate 0; all have the order of the run's
    variables, so that `carried` passes from phase to phase. Cached, so that a phase stays the same
    object: its formulas are cached by it.
    """
    moved = {one.name: one for one in Variables(phase.form, variables.orientation).integrals}
    integrals = tuple(
        moved.get(one.name, replace(one, rate=lambda q, carried, b: 0.0))
        for one in variables.integrals
    )
    return replace(phase, forms=replace(phase.form, integrals=integrals, orientation=None))


@lru_cache(maxsize=256)
def formulas_of_phase(system: System, phase: Phase, pattern: Any, types: tuple) -> Formulas:
    """Return the equations and event functions of a phase, to be compiled by `taylor.code_for`.

    The events are those of the phase, then those of the system that no phase has. `pattern` is a
    record like the parameters of the phase, whose numbers are all 1; `types` are its `kinds`, as
    equal records may be of other types. Both are keys of the cache, and compiled integrators are
    cached by the result, as an object.
    """
    form = phase.form
    own = [event for event in phase.events if event.formula and not event.sampled]
    of_phases = {event.name for other in system.phases.values() for event in other.events}
    common = [event for event in system.events if event.formula and event.name not in of_phases]
    # as in `formulas_of`, but the parameters of a phase may lack some of these
    folds = {name: v for name, v in system.folds(form).items() if name in pattern._fields}

    def functions(q: Any, carried: Any, b: Any) -> list:
        """Return the values of the phase's own events at a state, then of those of the system.

        Their order is that of `events`, by which callers number them.
        """
        state = form.scalars(q, b)
        values = [event.formula(state, b) for event in own]
        if common:
            row, first = system.read(phase, q, carried, b)
            read = moment(system.phase.form, row, carried, first)
            values += [event.formula(read, first) for event in common]
        return values

    events = *own, *common
    body = lambda values: refill(pattern, values)._replace(**folds)  # noqa: E731
    return Formulas(form, events, functions, body)


class World(NamedTuple):
    """The second argument of a jump, see `form.Exit`; a `HybridDriver` makes it.

    User-defined jumps read the attributes that `form.Exit` names, so these names stay.
    """

    body: Any
    system: System
    rules: Any  # the `problem.contact`; None for a system without it: its jumps are checked
    phases: Mapping[str, Phase]
    struck: Any  # `ImpactMotions.struck`, of a body whose contact may open; None without rules
    phase: Any = None  # that which ends: `Jump` sets it
    left: Any = None  # the internal time to the end of the run, set for each jump

    def with_numbers(self, body: Any, e_n: Any, left: Any, piece: Callable) -> "World":
        """Return the context of a jump with numbers of a program, or with derivatives.

        `piece` follows impacts, as `ImpactMotions.piece`.
        """
        world = self._replace(body=body, left=left)
        if not self.rules:
            return world
        rules = self.rules._replace(e_n=e_n)
        return world._replace(rules=rules, struck=partial(self.struck, piece=piece))

    def rates(self, phase: Phase, q: Any, carried: Any) -> list:
        """Return the rates of the integrals of the run, for the state q of a phase."""
        b = phase.parameters(self.body)
        return [integral.rate(q, carried, b) for integral in phase.form.integrals]

    def repeated(self, key: tuple, function: Callable) -> Callable:
        """Return function(world, *values), which returns a list, for columns with 80 bits.

        It takes an array (values, n) and returns one (results, n), by `column_programs.repeated`.
        The key must have all that the operations depend on but the kind of the body.
        """

        def called(*numbers: Any) -> list:
            """Call the function with a body of the first numbers, and the values after them."""
            rest = iter(numbers)
            return function(self._replace(body=refill(self.body, rest)), *rest)

        key = *key, kinds(self.body)
        body = np.array(leaves(self.body))[:, None]
        # a column of the body for each one of the values
        return lambda values: repeated(
            key, called, np.vstack([np.repeat(body, values.shape[1], 1), values])
        )


@dataclass(eq=False)
class Jump:
    """The jump of an exit, with its checks and its programs, for every run of its system.

    Parameters
    ----------
    system
        The system.
    kind
        The law, restitution and precision of its impacts, on which its programs depend; None
        without impacts. Jumps of another kind are other objects: see `jump_of`.
    name, phase
        The phase that ends; its name is "" at the start of a run.
    exit
        How it ends.
    calls, programs
        How often Python has made it, and how the loop makes it: see `JumpPrograms`.
    """

    system: System
    kind: Any
    name: str
    phase: Phase
    exit: Exit
    calls: int = 0
    programs: list[Any] = field(default_factory=list)

    @property
    def where(self) -> str:
        """Return the name of the jump for messages: "the jump by `land` from phase ... of ..."."""
        of_phase = f" from phase `{self.name}`" if self.name else ""
        return f"the jump by `{self.exit.event}`{of_phase} of `{self.system.name}`"

    def check(self, fault: str) -> None:
        """Raise InputError if there is a fault, a clause after "must"; "": no fault."""
        if fault:
            raise InputError(f"{self.where} must {fault}.")

    def __call__(self, run: "HybridDriver", state: Sequence, world: World) -> tuple:
        """Make the jump: return its `Next`; the next phase, its variables and event functions.

        If the jump raises ArithmeticError, or one of this package cannot compute, the run ends as
        `stalled`. With derivatives in the body there are no event functions. The phase is a
        `PhaseSolver`, which may be compiled here; else nothing of the run changes, as
        `JumpPrograms` and `derivatives.through` call it with other kinds of numbers too.

        Parameters
        ----------
        run
            The run.
        state
            The variables where the phase ended.
        world
            The context of the jump, with the time that is left.

        Raises
        ------
        InputError
            If the jump fails otherwise, or what it returns cannot follow. Its cause stays attached:
            `JumpPrograms._traced` takes a TypeError or ValueError there for "has no program".
        """
        q, carried = variables_of(self.phase.form).split(state)
        x = self.phase.leave(q, self.phase.parameters(world.body))
        if hasattr(x, "carried"):
            x = x._replace(carried=carried)
        try:
            n = self.exit.jump(x, world._replace(phase=self.phase))
            self.check(self.exit.fault(n, x, run.words))
            if n.cause is None:
                n.cause = self.exit.event
            if n.phase not in run.phases:
                return n, None, (), ()
            to = run.solver_of(n.phase)
            carried = getattr(n.x, "carried", carried)
            b = to.phase.parameters(world.body)
            q = type(to.phase.form.units)(*to.phase.enter(n.x, b))
            after = to.variables.join(q, carried)
            if has_derivatives(world.body):
                return n, to, after, ()
            values = to.formulas.functions(q, carried, b)
            if not world.rules:
                self.check(wrong_time(n, to) or wrong_root(n, to, q, carried, values))
            return n, to, after, values
        except (InputError, BuildError, Interrupted):
            raise
        except Exception as error:
            message = f"{self.where} fails: {type(error).__name__}: {error}"
            if type(error) is ArithmeticError:
                message = str(error)
            elif not (world.rules and isinstance(error, ArithmeticError)):
                raise InputError(message) from error
            return Next("", x, ends=Status.STALLED.value, message=message), None, (), ()


jump_of = lru_cache(maxsize=256)(Jump)
"""Returns the same `Jump` for the same exit: runs share its programs, and its count of calls."""


def begin_in_first(x: Any, world: World) -> Next:
    """Begin in the first phase: the jump at the start of a system without `begin`.

    Also where `begin` names no phase. So the order of `System.phases` matters here.
    """
    return Next(next(iter(world.phases)), x)


def wrong_time(n: Next, to: "PhaseSolver") -> str:
    """Return the fault of the times or the series of a Next, a clause after "must"; "" without one.

    `to` is the solver of the phase that it leads to. Like `wrong_root` it is for jumps of systems
    without contact rules, which users write; those of this package are not checked.
    """
    for what in ("delay", "lasts"):
        time = getattr(n, what)
        if not (is_one_number(time) and time >= 0):
            return f"have a time of at least 0 in `{what}`, but has {time!r:.60}"
    if not n.delay < math.inf:
        return f"have a finite `delay`, but has {n.delay!r:.60}"
    if not callable(n.series or len):  # `len` is a function in place of None
        return f"have a function in `series`, but has {n.series!r:.60}"
    if n.series:
        values = to.variables.join(*n.series(0.0))
        names = to.variables.names
        if len(values) != len(names) or not all(map(is_one_number, values)):
            must = f"return numbers {', '.join(names)} at the given time from `series`"
            return f"{must}, but returns {values!r:.60}"
    if n.lasts < math.inf and all(exit.event != CLOCK for exit in to.phase.exits):
        return f"leave out `lasts`, as phase `{n.phase}` has no exit by {CLOCK!r}"
    return ""


def wrong_root(n: Next, to: "PhaseSolver", q: Any, carried: Any, values: Sequence) -> str:
    """Return the fault of the multiplicities of a Next, a clause after "must"; "" without one.

    It is a fault if the event function, or its slope for a multiple root, is not zero in the state
    q, `carried` where the phase of `to` begins; `values` are the event functions there.
    """
    rates = to.phase.form.rates(q, to.b)
    moved = type(q)(*(v + NEAR * rate for v, rate in zip(q, rates, strict=True)))
    later = to.formulas.functions(moved, carried, to.b)
    for event, value, ahead in zip(to.formulas.events, values, later, strict=True):
        count = n.zeros.get(event.name, 0)
        sizes = abs(value) / ROOT, abs(ahead - value) / (SLOPE * NEAR)
        if max(sizes[:count], default=0) >= 1:
            return (
                f"give multiplicities of roots in `zeros`, but {event.name!r} has no root of "
                f"multiplicity {count} where phase `{n.phase}` begins"
            )
    return ""


# --- runs ---------------------------------------------------------------------------------------


class PhaseInterval(NamedTuple):
    """A phase that a run has gone through: internal times, the last state, and the jump.

    `HybridDriver.keep_interval` makes it for `derivatives.through.Pass`.
    """

    solver: "PhaseSolver"
    began: float
    ended: float
    last: list[float]  # variables of the phase, without those added for event functions
    jump: Jump | None  # None: by the end of the run


class PhaseSolver:
    """A phase that a run can enter: its equations, events and exits, compiled.

    Parameters
    ----------
    run
        The run.
    name
        The name of the phase.
    """

    def __init__(self, run: "HybridDriver", name: str):
        """Compile the phase, number its events and exits as the run does, and allocate arrays.

        A run that stops on liftoff has no exit by it, so the event ends the run. `ahead` is for
        `python_events`: a second integrator, whose steps do not move the run.
        """
        problem = run.problem
        phase = run.phases[name]
        self.name = name
        self.phase = phase
        self.at = [*run.phases].index(name)
        self.b = phase.parameters(run.world.body)
        self.variables = variables_of(phase.form)
        stops = problem.on_liftoff == "stop"
        self.exits = {  # by the number of the event
            run.endings[exit.event]: run.jump(name, phase, exit)
            for exit in phase.exits
            if not (stops and exit.event == Status.LIFTOFF.value)
        }
        pattern = refill(self.b, repeat(1.0))  # equal for all bodies: a key of caches
        self.formulas = formulas_of_phase(problem.system, phase, pattern, kinds(pattern))
        self.events = {run.numbers[event.name]: event for event in self.formulas.events}
        code = code_for(problem, self.formulas, run.stop, run.lanes)
        records = self._records(run, code.rows.events)
        rows = run.all_events._replace(events=records, axis=code.rows.axis)
        self.workspace = Workspace(run, code, rows)
        self.workspace.motion.in_lane[0] = self.at
        run.set_parameters(self.workspace, leaves(self.b))
        self.sampled = {run.numbers[event.name]: event for event in phase.events if event.sampled}
        self.ahead = None
        if self.sampled:
            self.ahead = copy.deepcopy(code_for(problem, self.formulas, run.stop).integrator)

    def _records(self, run: "HybridDriver", mine: np.ndarray) -> np.ndarray:
        """Return the records of all events of the run; only those of this phase are searched.

        `mine` are the records (`tallies.EVENT_RECORD`) of its events, in their order. This also
        writes the scale and `extremes` of these events to `run.all_events`, for `Driver.extremes`
        and `ensembles.lanes`.
        """
        known = run.all_events.events
        records = np.zeros_like(run.all_events.events)
        for (number, event), record in zip(self.events.items(), mine, strict=True):
            records[number] = record
            whole = known[number]
            new = records[number]
            whole["scale"] = record["scale"]
            whole["extremes"] |= bool(event.extremes)
            # as in `driver_of`: turnings are many, and found only if they are logged
            new["watched"] = not event.sense or event.name in run.problem.events
            if number in self.exits:  # its jump logs
                new["first"] = new["last"] = 0
                new["ends"] = Status.ENDED.code
            else:
                new["first"], new["last"] = whole["first"], whole["last"]
        return records

    def value(self, number: int, state: Any, b: Any) -> Any:
        """Return the value of the event function `number` in a state of the phase, internal units.

        `state` are its variables, b the parameters of the phase.
        """
        functions = self.formulas.functions(*self.variables.split(state), b)
        return functions[[*self.events].index(number)]

    def points(self, states: Iterable, b: Any) -> dict[int, tuple]:
        """Return the event functions in `states` of a jump to this phase, by number.

        The states are those at `jump_times`, which each tuple follows; b are the parameters of the
        phase. They may be numbers of a program.
        """
        points = [self.formulas.functions(*self.variables.split(state), b) for state in states]
        return dict(zip(self.events, zip(*points, strict=True), strict=True))

    def notes(self, number: int, before: Any, state: Any, b: Any) -> bool:
        """Return whether event `number` is logged if a jump from phase `before` passes its zero.

        A turning is logged if its function was not at zero where that phase ended, in `state` with
        the parameters b of `before`, its `PhaseSolver`; a lasting event always; any other one is
        logged by jumps, if at all. The result is a bool also for numbers of a program, whose
        comparison becomes a line.
        """
        event = self.events[number]
        if event.lasting or not event.sense:
            return event.lasting
        return bool(abs(before.value(number, state, b)) > ON_ZERO)

    def begins(self, n: Next, values: Sequence, signs: Sequence) -> tuple[list, list, list[int]]:
        """Return on which side of their zeros the event functions begin in this phase.

        The value alone cannot decide this, because a jump leads exactly to a zero, up to rounding.
        The function of an exit begins on the side from which it can reach its zero, or where the
        jump says; any other one keeps its sign from before, and has passed its zero in the jump if
        its value has the other sign by more than rounding.

        Parameters
        ----------
        n
            The result of the jump to this phase.
        values
            The event functions of this phase.
        signs
            Signs of all event functions before the jump, by number; 0: not known. Like the values
            they may be numbers of a program, so the comparisons here become lines of it.

        Returns
        -------
        signs, zeros, passed
            Fields `sign` and `on_zero` of `tallies.FUNCTION_RECORD`: signs, 0 for events of other
            phases; 1 for functions that begin on a zero, and minus the multiplicity of the root for
            exits. Then the numbers of the events that happened in the jump.
        """
        sides = [0.0] * len(signs)
        zeros = [0.0] * len(signs)
        passed = []
        for (k, event), value in zip(self.events.items(), values, strict=True):
            if k in self.exits:  # as in `ImpactMotions._followed`
                sides[k] = n.sides.get(event.name, -event.direction)
                zeros[k] = -n.zeros.get(event.name, 0)
            elif signs[k] == 0:  # as in `new_tallies`
                sides[k], zeros[k] = 1 if value > 0 else -1, abs(value) < ON_ZERO
            elif value * signs[k] < 0 and abs(value) > ON_ZERO:
                sides[k] = -signs[k]
                if event.direction * sides[k] >= 0:
                    passed.append(k)
            else:
                sides[k] = signs[k]
        return sides, zeros, passed


def assembled(system: System, tops: Any, number: Callable) -> tuple[Any, Any]:
    """Return bodies as jumps take them, in internal units, and the phases of their system by name.

    The leaves of the body are the first inputs of programs; `pools` and `derivatives.through` take
    them in the same order.

    Parameters
    ----------
    system
        The system.
    tops
        A run, or `Problems`, whose numbers are arrays or have derivatives.
    number
        Converts numbers or arrays to the working precision.
    """

    def internal(value: Any, unit: Any) -> Any:
        """Return SI values of this unit in internal units, in the working precision."""
        return number(value / tops.scales.of(unit))

    if system.assembled is None:
        return tops.internal_body, system.phases
    return system.assembled(tops.internal_body, tops.contact, internal)


class HybridDriver(Driver):
    """Integrate one run through its phases, in doubles: a `Driver` for systems with phases.

    `taylor.driver_of` makes it.

    Parameters
    ----------
    problem
        The run.
    stop
        Set it to give up while equations are being compiled.
    """

    solver: PhaseSolver
    slot = 0  # of the tallies of the run; `HybridPools` sets that of the top which it loads
    parameters_in: Any  # slots of tops in lanes and a phase -> its parameters; of `HybridPools`
    first_jump: Jump  # to the first phase
    last: np.ndarray  # the state where the last phase ended
    intervals: list[PhaseInterval] | None = None  # of the run, if they are to be kept
    short_phases = 0  # phases in a row that were too short; changes by loop.c set it to 0
    changes = 0  # of phase, in a slice
    learns_start = False  # whether the jump to the first phase gets programs
    # internal times -> states (times, variables) of the jump to the present phase, if it takes time
    series: Any = None

    @QUIET
    def __init__(self, problem: Problem, stop: threading.Event | None = None):
        """Assemble the body and its phases, number all events, and begin the run.

        Each phase is compiled when it is first entered. The events of the system come first, in its
        order: `runs.event_log` and `ensembles.lanes` number them so. Solvers and jumps read
        attributes of the run, so all are set before `begin_run`.
        """
        system = problem.system
        number = float if problem.precision == "double" else problem.number
        self.problem, self.stop, self.number = problem, stop, number  # floats are faster
        self.end = number(internal_end(problem))
        body, phases = assembled(system, problem, number)
        body = refill(body, map(number, leaves(body)))
        variables = problem.variables
        self.phases = ReadOnly({name: completed(one, variables) for name, one in phases.items()})
        self.variables = len(problem.variables.names)
        # positive: a jump chooses the first phase, so `Integration` ends no run at its start
        self.at_start = np.ones(len(system.events))
        in_phases = (event for phase in phases.values() for event in phase.events)
        # the system's events twice: the first give the order, the last replace those of phases
        events = {event.name: event for event in (*system.events, *in_phases, *system.events)}
        self.numbers = {name: k for k, name in enumerate(events)}
        self.clock_number = len(events)
        of_clock = dict.fromkeys((CLOCK, START), self.clock_number)
        self.endings = {**self.numbers, **of_clock, STALL: -1}  # numbers of exits
        # the positions of functions are dummies: each phase has its own, see `_records`
        rows = event_rows([*events.values()], [(0, 1, 1.0, 0.0)] * len(events), ())
        phase_widths = (len(variables_of(phase.form).names) for phase in self.phases.values())
        width = max(self.variables, *phase_widths)
        # an integrator has at most one further variable for each event
        self.allocate_tallies(rows, np.ones((len(events), 1)), width + len(events))
        signs = problem.joint.get("signs", {})
        self.functions["sign"] = [signs.get(name, 0.0) for name in events]  # 0: not known
        self.tables = PhaseTables(problem)
        self.solvers: dict[str, PhaseSolver] = {}
        contact = problem.contact
        kind = None
        struck = None
        if contact is not None:
            kind = type(body[0].friction), contact.restitution, problem.precision
            self.impacts = ImpactMotions(*kind, stop, body[0])
            struck = self.impacts.struck
        tables = dict(system.tables)
        self.words = {  # that a Next may have: for `Exit.fault`
            "logged": [event.name for event in system.events],
            **dict.fromkeys(("zeros", "sides"), self.numbers),
            "cause": tables.pop("phases").get("reason", ()),
            "rows": tables,
            "ends": ENDS,
        }
        self.jump = partial(jump_of, system, kind)
        self.world = World(body, system, contact, self.phases, struck)
        self.jump_programs: Any = JumpPrograms(self) if struck and number is float else None
        self.begin_run()

    def begin_run(self) -> None:
        """Enter the first phase from the start of the problem; pools override it.

        `first` is the row at time 0: during a first jump that takes time, that of its `series`.
        """
        self._start(tuple(self.problem.start().tolist()))
        self.first = self.present()
        if self.series:
            first = np.resize(self.series(self.number(0)), (1, self.width))
            self.first = self.rows_of(np.array([self.solver.at]), first)

    def _start(self, state: tuple) -> None:
        """Make the jump from the start, at time 0, to the first phase.

        `state` are the variables at the start, internal. If it is the end of another run, the
        `joint` (made by `joint` below) names the phase. A jump that names none leaves it to
        `begin_in_first`. `HybridPools.attend` calls it for each top that no program starts.
        """
        system = self.problem.system
        world = self.world._replace(left=self.end)
        phase = completed(system.phase, self.problem.variables)
        joint = self.problem.joint
        begins = [system.begin or begin_in_first, begin_in_first]
        if "next" in joint:  # it continues in the phase of another run
            begins.insert(0, lambda x, world: Next(x=x, **joint["next"]))
        for begin in begins:
            jump = self.jump("", phase, Exit(START, tuple(self.phases), begin))
            begun = n, *_ = jump(self, state, world)
            if n.ends:
                self.ended = Status.of_event(n.ends)
                self.sentence = n.message
            if n.phase:
                break
        self.first_jump = jump
        if self.learns_start:
            self.jump_programs.learn(jump, state, world)
        self._enter(begun, self.number(0), None)
        # the phase began in the run before; `_change` compares its whole length with CHATTER
        self.began -= joint.get("lasted", 0.0)
        for name in n.logged:
            self._note(self.numbers[name], self.number(0), 1, None, np.array(state))
        # this overwrites a time that the jump noted, as the end of `HybridPools.start` does: a
        # change of one is a change of both
        self.tallies.lane["lasts_since"] = lasts_from_start(self.tallies.functions, self.all_events)

    # --- phases ----------------------------------------------------------------------------------

    def solver_of(self, name: str) -> PhaseSolver:
        """Return the `PhaseSolver` of a phase by name, compiled when it is first entered."""
        if name not in self.solvers:
            self.add_solver(PhaseSolver(self, name))
        return self.solvers[name]

    def add_solver(self, solver: PhaseSolver) -> None:
        """Add a phase, and the programs of its exits; pools override it to add a pool."""
        self.solvers[solver.name] = solver
        if self.jump_programs:
            self.jump_programs.add_loop(solver.at, solver.workspace.loop)
            for jump in solver.exits.values():
                self.jump_programs.register(solver, jump)

    def codes(self) -> tuple[Compiled, ...]:
        """Return the integrators of all phases, compiled, in the order of `phases`.

        Their fingerprint is in stores: the order must not change, nor may a phase be left out.
        """
        return tuple(self.solver_of(name).workspace.compiled for name in self.phases)

    def set_phase(self, solver: PhaseSolver, began: float) -> None:
        """Make the next steps in a phase that begins at an internal time; its state is not set.

        The caller must also set `until`, `series` and the signs of event functions.
        """
        self.solver = solver
        self.began = began
        self.set_workspace(solver.workspace)

    def _enter(self, begun: tuple, now: Any, before: PhaseSolver | None) -> None:
        """Begin a phase by the result of a jump, which was made at the internal time `now`.

        It sets phase, state, time and signs of event functions, and logs the events that the jump
        passed; the caller makes the jump, and logs its `logged` events. `JumpPrograms` has the same
        work done by `change` in loop.c: a change of one is a change of both.

        Parameters
        ----------
        begun
            The result of `Jump`: the Next, its solver, the state there and its event functions, in
            the order of the solver's events.
        now
            The time of the jump; its `delay` is added here.
        before
            The phase that has ended; None at the start.
        """
        n, solver, state, values = begun
        time = min(now + self.number(n.delay), self.end)
        self.set_phase(solver, float(time))
        if n.cause:
            self.tables.begin(float(now), solver, n.cause)
        self.tables.add(float(now), n.rows)
        self.set_state(state, (time, 0 * time))
        self.series = n.series and partial(self._during, n.series, now)
        signs: Any = self.functions["sign"]
        if self.series:
            first = self._ranged(now, time)
            if before is None:  # the run begins with this series: on a zero, its side is unknown
                sides, zeros, _ = solver.begins(n, first, signs)
                signs = [0 if zero > 0 else side for side, zero in zip(sides, zeros, strict=True)]
        signs, zeros, passed = solver.begins(n, values, signs)
        self.functions["sign"], self.functions["on_zero"] = signs, zeros
        # `_note_passed` takes the end of the phase before, or the series
        for number in passed if before or self.series else ():
            self._note_passed(number, signs[number], before, now)
        self.clear_counts()
        self.time[0] = self.began
        self.until = time + self.number(n.lasts)  # as in `JumpPrograms.drive`

    def keep_interval(
        self, solver: PhaseSolver, began: float, ended: Any, state: Iterable, jump: Jump | None
    ) -> None:
        """Append a phase that has ended to `intervals`, if they are kept (for derivatives).

        `began` and `ended` are internal times, `jump` that by which it ended, or None. `state` is
        its last one, of which only the first numbers, the variables of the phase, are read:
        `JumpPrograms.drive` passes an iterator that is longer.
        """
        if self.intervals is not None:
            last = [float(one) for one in islice(state, len(solver.variables.names))]
            self.intervals.append(PhaseInterval(solver, began, float(ended), last, jump))

    # --- steps -----------------------------------------------------------------------------------

    @QUIET
    def advance(self, request: Request, most: int) -> Slice:
        """Make a slice of at most `most` steps, with the new rows of phases and impacts."""
        return replace(super().advance(request, most), tables=self.tables.take_rows())

    def run(self, most: int) -> tuple[int, Any, np.ndarray, Status | None]:
        """Advance by at most `most` steps, through as many phases as they take, at most PER_SLICE.

        Returns what `Driver.run` does: steps, internal time, state, status or None. The state is of
        the phase in which the slice ends. A phase with sampled events makes one step at a time,
        because `end_next` looks for them in the next step only.
        """
        self.changes = 0
        steps = 0
        while True:
            self.end_next()
            is_full = self.logged[0] > PASSAGES - MOST_LOGGED  # a jump logs MOST_LOGGED at most
            is_over = self.changes >= PER_SLICE or is_full or not self.clock[0] < self.end
            room = 0 if is_over else most - steps  # 0: only rows, or a jump
            steps += self.drive(min(room, 1) if self.solver.sampled else room)
            code, (when, last) = self.status[0], self.reached()
            self.last = last.copy()
            status = None if code == RUNNING else STATUSES[code]
            # as `ends_phase` and `is_at_end` in loop.c; a change of one is a change of both
            endings: dict[Any, Any] = {Status.FINISHED: self.ending, Status.STALLED: -1}
            ending: Any = endings.get(status)
            within = self.upto[0] < 1.0
            if within:
                ending = self.motion.ended_by[0]
            jump = self.solver.exits.get(ending)
            if jump and within:
                self.logged[0] -= 1  # the jump logs it, or the next part of the run
            if jump and float(self.end - self.number(when)) <= AT_END * float(self.end):
                jump = None
                when = self.end
                status = Status.FINISHED
                if within:  # the loop has turned the sign; the run that begins there finds the zero
                    self.functions["sign"][ending] *= -1
            if jump:
                status = self._change(jump, when)
            if status is not None or not room or not (jump or self.solver.sampled):
                break
        if status is None and not self.clock[0] < self.end:
            status = Status.FINISHED  # a phase begins where the run ends, and takes no step
            self.tally["upto"] = 0.0  # no step ends here: `Integration` writes the row at the end
        if status is not None:
            self.tables.end(float(when))
            if not jump:
                self.keep_interval(self.solver, self.began, when, self.last, None)
        return steps, when, self.last, status

    def end_next(self) -> None:
        """Set the time at which the next steps end: with the phase, or at a sampled event.

        `ending` becomes the number of that event, or that of the clock. `run` calls it before each
        `drive`, and `JumpPrograms.drive` after its changes. If no time is left, the phase is
        FINISHED without a step, which `run` takes for the exit by `ending`.
        """
        when, self.ending = self.next_end()
        self.set_end(when)
        high, low = self.clock
        runs = self.status[0] == RUNNING
        if runs and when < self.end and not (when - high) - low > 0:  # it takes no step
            self.status[0] = Status.FINISHED.code

    def next_end(self) -> tuple[Any, Any]:
        """Return the internal time at which the next steps end, and the number of the event that
        ends them: a sampled one, or that of the clock, also for the end of the run.
        """
        ends = [(min(self.end, self.until), self.clock_number)]
        if self.solver.sampled:
            ends += sampled_in_next_step(self)
        return min(ends, key=itemgetter(0))

    def _change(self, jump: Jump, when: Any) -> Status | None:
        """Make the jump by which a phase ends at the internal time `when`, and begin the next one.

        It begins in `self.last`, which `run` has set. Return the status of a run that ends here,
        with the reason in `sentence`, or None. Here the changes are counted that are too short
        (CHATTER): loop.c leaves each such change to this method.
        """
        shortest = CHATTER * max(self.began, 1.0)  # as in `change` of loop.c and in `joint`
        if float(self.until) > self.began:  # it was to last some time
            self.short_phases = self.short_phases + 1 if float(when) - self.began < shortest else 0
        now = self.number(when)
        solver = self.solver
        last = self.last
        self.keep_interval(solver, self.began, when, last, jump)
        given = tuple(last.tolist()), self.world._replace(left=self.end - now)
        begun = n, _, state, _ = jump(self, *given)
        if self.jump_programs:
            self.jump_programs.learn(jump, *given)
        for name in n.logged:
            self._note(self.numbers[name], now, 1, solver, last)
        if n.ends:
            self.sentence = n.message or f"{jump.where} ends the run"
            self.tables.add(float(when), n.rows)
            return Status.of_event(n.ends)
        if self.short_phases > 2:
            shortest *= self.problem.unit(SECOND)
            self.sentence = (
                f"phases change more often than every {shortest:.1g} s, at last "
                f"from `{solver.name}` to `{n.phase}` by `{jump.exit.event}`"
            )
            return Status.STALLED
        if not math.isfinite(sum(state)):
            self.sentence = f"{jump.where} must lead to a finite state, but leads to {n.x!r:.60}"
            return Status.NON_FINITE
        if self.output.steps and self.upto[0] < 1.0:  # the loop keeps the ends of steps
            self.add(np.array([when]), last[None])
        self._enter(begun, now, solver)
        self.changes += 1
        return None

    # --- rows ------------------------------------------------------------------------------------

    def make_steps(self, most: int) -> int:
        """Let the loop in C make at most `most` steps, and the jumps that have programs."""
        self.add_in_jump()
        # with rows at steps Python makes all jumps: `_change` adds the row where a phase ends
        if self.jump_programs is None or self.output.steps:
            return super().make_steps(most)
        return self.jump_programs.drive(most, PER_SLICE - self.changes)

    def add_in_jump(self) -> None:
        """Write the rows at given times within the jump to the present phase, without a step.

        They are those before `began`. If the jump has no `series`, they get the state at its end.
        """
        if not self.output.steps:
            times = self.output.times[self.made[0] :]
            if len(inside := times[: np.searchsorted(times, self.began)]):
                first = np.tile(self.state, (len(inside), 1))
                self.add(inside, self.series(*inside) if self.series else first)

    def add(self, times: np.ndarray, states: np.ndarray) -> None:
        """Write rows at internal times that lie in no step; there must be room for them.

        `states` are of `self.solver`, (k, variables): `rows_of` converts them later, by its number.
        """
        rows = self.output
        made = self.made
        part = slice(made[0], made[0] + len(times))
        rows.times[part], rows.phases[part], made[0] = times, self.solver.at, part.stop
        rows.states[part, : states.shape[1]] = states

    def _note(self, number: int, time: Any, sign: int, solver: Any, state: np.ndarray) -> None:
        """Log event `number` that no step has found, at an internal time, +1 rising or -1 falling.

        `state` are the variables of the phase of `solver`, or a row if that is None, which has the
        number after the last phase (see `rows_of`). C counts and logs the passage.
        """
        at = self.logged[0]
        loop = solver.workspace.loop if solver else self.loop
        phase = solver.at if solver else len(self.phases)
        event = self.all_events.events[number:].ctypes.data
        values = np.array(state, float)
        given = number, self.slot, int(sign), phase, float(time), values.ctypes.data
        library().loop_note(loop.place, event, *given)
        self.times[at], self.log.states[at, : len(state)] = time, state

    def _during(self, series: Any, began: Any, *times: Any) -> np.ndarray:
        """Return states (times, variables) of the present phase in a jump that takes time.

        `series` is that of the Next, whose time 0 is the internal time `began`.
        """
        number, join = self.number, self.solver.variables.join
        # one time at a time, as in `rows_of`
        states = [join(*series(number(time) - began)) for time in times]
        # a series may compute in 80 bits (`World.repeated`): back to the precision of the run
        return np.array([[number(one) for one in state] for state in states])

    def _ranged(self, began: Any, end: Any) -> list:
        """Update the extremes of event functions in a jump from time `began` to `end`.

        Return the values of the event functions at its start. `note_change` in loop.c does the same
        at the same times: a change of one is a change of both.
        """
        solver = self.solver
        times = jump_times(began, end)
        points = solver.points(self.series(*times), solver.b)
        for number, values in points.items():
            event = self.all_events.events[number]
            known = self.functions[number]
            for time, value in zip(times, values if event["extremes"] else (), strict=False):
                scaled = float(value) * event["scale"]
                for side, is_beyond in enumerate((np.less, np.greater)):
                    if is_beyond(scaled, known["extremes"][side]):
                        known["extremes"][side], known["times"][side] = scaled, time
        return [first for first, *_ in points.values()]

    def _note_passed(self, number: int, sign: int, before: Any, now: Any) -> None:
        """Log event `number`, whose function passed zero in the jump from `before` at time `now`.

        `before` is the `PhaseSolver` of the phase that ended, None at the start; `sign` that of the
        function after the jump. In a jump that takes time its zero is searched.
        """
        solver = self.solver
        during = self.series
        if during:  # `zero_of` takes a function that is positive at first
            now = zero_of(
                lambda t: -sign * solver.value(number, during(t)[0], solver.b), now, self.began
            )
            self._note(number, now, sign, solver, during(now)[0])
            return
        if solver.notes(number, before, self.last, before.b):
            self._note(number, now, sign, before, self.last)

    def rows_of(self, phases: np.ndarray, states: np.ndarray, slots: Any = None) -> np.ndarray:
        """Return states (k, width) of phases, by number (k,), as rows (k, variables) of the run.

        The number after the last phase marks states that are rows already (`_note` at the start).
        `slots` are those of the tops, (k,), where a loop has many; None: a run alone.
        """
        variables = self.problem.variables
        rows = states[:, : self.variables].copy()
        for solver in self.solvers.values():
            mine = np.flatnonzero(phases == solver.at)
            # NumPy cannot multiply an array of quadruple numbers by a literal: one state at a time;
            # states of other numbers go in all at once, if there are any
            each: Any = mine if self.number is hy.real128 else [mine][: len(mine)]
            for some in each:
                b = solver.b if slots is None else self.parameters_in(slots[some], solver)
                q, carried = solver.variables.split(states[some].T)
                read, _ = self.problem.system.read(solver.phase, q, carried, b)
                values = variables.join(read[: variables.moving], carried)
                for k, value in enumerate(values):
                    rows[some, k] = value
        return rows

    # --- where the run is ------------------------------------------------------------------------

    def last_rows(self) -> dict[str, dict[str, np.ndarray]]:
        """End the present phase with the run; return the last rows of its tables, SI.

        Only for a run that ends between slices, as a settled one does; others end in `run`.
        """
        self.keep_interval(self.solver, self.began, self.clock[0], self.state, None)
        self.tables.end(float(self.clock[0]))
        return self.tables.take_rows()

    def joint(self, names: Iterable[str]) -> PlainData:
        """Return the data with which another run continues in the present phase: fields of a Next
        as `next`, and how long the phase has `lasted`, besides those of `Driver.joint`.

        `names` are ignored: the joint has the signs of all events of the run. `_start` reads the
        keys.
        """
        joint = super().joint(self.numbers)
        lasts = float(self.until - self.now)
        sides = {name: sign for name, sign in joint["signs"].items() if sign}
        follows: PlainData = {"phase": self.solver.name, "sides": sides}
        if lasts < math.inf:
            follows["lasts"] = max(lasts, 0.0)
        lasted = float(self.now) - self.began
        if lasted < CHATTER * max(self.began, 1.0):  # it has begun here
            roots = zip(self.numbers, self.functions["on_zero"].tolist(), strict=True)
            # of exits, as `begins` sets them; positive ones have no multiplicity
            follows["zeros"] = {name: -int(root) for name, root in roots if root < 0}
        return joint | {"next": follows, "lasted": lasted}

    def snapshot(self) -> dict[str, Any]:
        """Return plain data from which a run continues bit by bit, with its phase.

        The lists have the same length in every phase, except for `state`, which keyframes pad: so
        all keyframes of a run are rows of one array. `restore` reads them by position. An entry in
        the precision of the run, such as `until`, must be in `runs.keyframes.EXACT`.
        """
        phase = [self.solver.at, self.short_phases, self.began, *self.tables.under_way]
        return super().snapshot() | {"phase": phase, "until": [self.until]}

    def restore(self, kept: dict[str, Any], state: np.ndarray, clock: tuple[Any, Any]) -> None:
        """Continue in the phase of a snapshot `kept`, as `Driver.restore` does.

        The phase is set first, because state and time are those of its integrator; the numbers of
        `kept["phase"]` have the order of `snapshot`. Rows in the tables since the start of this
        process are dropped. `state` may be padded, as keyframes are.
        """
        at, short, began, *under_way = kept["phase"]
        self.short_phases, (self.until,) = int(short), kept["until"]
        self.set_phase(self.solver_of([*self.phases][int(at)]), began)
        super().restore(kept, state[: len(self.state)], clock)
        self.tables.take_rows()
        self.tables.under_way = under_way


class WideHybridDriver(HybridDriver, WideDriver):
    """Integrate one run through its phases in numbers wider than doubles."""

"""Changes of phase that the compiled loop makes by itself, by programs of jumps.

A jump that Python has made goes into `JumpPrograms.learn`, and `drive` lets the loop make steps and
the jumps that it can; the changes come back as rows of `made`. A jump is a Python function: it
takes 0.2 to 0.5 ms, its arithmetic some microseconds, and a bouncing top jumps hundreds of times.
The jump is therefore recorded once, by numbers that write down each operation (`mechanics.lines`),
and the loop repeats this straight-line program with other numbers. A comparison that turns out
otherwise ends a program; then one that was recorded on another branch is tried, and at last Python
makes the jump. All have the same bits, so it does not matter when a program is recorded. The runs
of a system share the programs of its jumps.

Symbols
    jump      a `hybrid.Jump`; solver, to: the `PhaseSolver` of the phase that ends, of the next
    number    of an event: its index among all events of the run; of a program: among its jump's;
              the clock has that after the last event, a stall -1: `HybridDriver.endings`
    lines     the operations of a program; registers: its numbers: inputs, constants, results
"""

import ctypes
import threading
import weakref
from functools import partial
from itertools import chain, islice
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves
from .loop import filled, library
from .tallies import record_type


PER_SLICE = 256
"""End a slice after this many changes. A fixed count, not a time limit, keeps stores reproducible.
"""
CHATTER = 1e-12
"""Three phases in a row that are shorter than this part of the internal time, which counts as 1 at
least, lead nowhere; after one of them Python makes the change.
"""
PATIENCE = 16
"""Changes before a jump is recorded as a program; then again after twice as many that no program
has made."""
BRANCHES = 8
"""Most programs of a jump."""
MOST_REGISTERS = 1 << 17
"""Most numbers of a program; that of a top that begins to roll has 2,200."""
NUMBERS, STATE = 24, 40
"""Most numbers that a change may pass to the tables, and variables where its phase ended."""
START = "start"
"""How a phase before the first one ends, from which tops in lanes begin."""
JUMP_PARTS = 8
"""Parts of a jump that takes time, between which the extremes of event functions are sought; the
same number as in loop.c."""


def jump_times(began: Any, end: Any) -> list:
    """Return times of a jump from `began` to `end`, at which extremes are sought: first `began`.

    They may be numbers of a program. `note_change` in loop.c computes the same times.
    """
    return [began + (end - began) * k / JUMP_PARTS for k in range(JUMP_PARTS + 1)]


class _Program(NamedTuple):
    """The structure `Program` of `loop.c`, field by field: a program, and the effects of its jump.

    `events` are those that it logs, then those that it passes, then those with extremes in it:
    `logged`, `passed` and `ranged` of them. `other` is the address of the jump's next program.
    """

    lines: np.ndarray  # (length, 3) see `Program.code`
    constants: np.ndarray
    events: np.ndarray  # numbers of events
    other: int  # 0: none
    length: int
    result: int  # register of the first line's result
    out: int  # registers from which on results are read, see `JumpPrograms._traced`
    after: int
    next: int  # number of the next phase
    number: int  # of the program
    logged: int
    passed: int
    ranged: int


TOP_RECORD = record_type(
    float="high low end until stop began",
    int="stops_by phase event steps short_phases",
    uint="state body",
)
"""A top: its clock, the ends of the run, of its phase and of its next steps, and the start of the
phase, internal; the event at the end of the next steps; the phase, and the event that ended it, or
a number below 0; steps before those of its tally; phases in a row that were too short; addresses of
its state and of the numbers of its body. It is the struct `Top` of loop.c; `JumpPrograms.drive`
fills it by position.
"""


class Jumps(NamedTuple):
    """The structure `Jumps` of `loop.c`: the loops and programs of the phases of a system.

    The fields have its order; see `JumpPrograms`, which makes it, for the arrays.
    """

    loops: np.ndarray  # (phases + stages of impacts,) addresses; 0: not compiled
    programs: np.ndarray  # (phases + 1, events + 1) addresses of first programs; 0: none
    events: np.ndarray  # (events,) EVENT_RECORD
    registers: np.ndarray  # (MOST_REGISTERS,) of the program that is executed
    made: np.ndarray  # (PER_SLICE, width) changes made; empty for tops in lanes
    chatter: float  # CHATTER
    length: int  # how many changes `made` has
    width: int
    numbers: int  # of the body and its contact, the first inputs of a program


class JumpProgram(NamedTuple):
    """The recorded program of a jump, which serves every run of its system."""

    code: _Program
    structure: Any  # the same in C
    regions: list[str]  # of impacts
    phase: str  # the next one
    cause: str  # of the change; empty if the table of phases gets no row
    tables: list[tuple[str, int]]  # each row of the other tables, and how many numbers it has


class JumpPrograms:
    """Record the jumps of a run as programs, and let the loop execute them.

    `HybridDriver` makes it, for runs in doubles of a system with contact rules.

    Parameters
    ----------
    run
        A `HybridDriver`.
    """

    patience = PATIENCE
    lock = threading.Lock()

    def __init__(self, run: Any):
        """Allocate the table in which the loop looks up programs; it is empty."""
        self.run = weakref.proxy(run)
        self.loops = np.zeros(len(run.phases) + len(run.impacts.stages), np.uint64)
        # by phase and event, the last by the clock: where its first program is; the start comes
        # after all phases
        self.table = np.zeros((len(run.phases) + 1, run.clock_number + 1), np.uint64)
        # of each change: time, event, program, `lasts`, `delay`, numbers of tables, last state
        self.made = np.zeros((PER_SLICE, 5 + NUMBERS + STATE))
        # of the body and its contact, the constant inputs of programs, as in `pools.bodies_of`
        self.body = np.array([*leaves(run.world.body), run.world.rules.e_n])
        self.top = np.zeros(1, TOP_RECORD)
        registers = np.empty(MOST_REGISTERS)
        arrays = self.loops, self.table, run.all_events.events, registers, self.made
        self.jumps = Jumps(*arrays, CHATTER, 0, self.made.shape[1], len(self.body))
        self.record: Any = filled(self.jumps)

    def add_loop(self, place: int, loop: Any) -> None:
        """Let programs use a `Loop` by its number `place`: see `loops` of `Jumps`."""
        self.loops[place] = ctypes.addressof(loop.structure)

    def learn(self, jump: Any, *given: Any) -> None:
        """Count a jump that Python has made with these arguments (state, world).

        Record it when it is due: only a jump that begins a phase, and does nothing else, becomes a
        program. `run.solver` and `run.functions` must still be those before the jump, so it comes
        before `HybridDriver._enter`. Runs on other threads may add programs too, hence the lock.
        """
        jump.calls += 1
        # at powers of two
        is_due = jump.calls >= self.patience and not jump.calls & (jump.calls - 1)
        if is_due and len(jump.programs) < BRANCHES:
            written = self._traced(jump, *given)
            with self.lock:
                known = {program.code.lines.tobytes() for program in jump.programs}
                if written and written.code.lines.tobytes() not in known:
                    written.structure.number = len(known)  # its index in `jump.programs`
                    if known:
                        jump.programs[-1].structure.other = ctypes.addressof(written.structure)
                    jump.programs.append(written)
        self.register(self.run.solver, jump)

    def register(self, solver: Any, jump: Any) -> None:
        """Enter the programs of a jump into the table of the loop, for the exit of this phase.

        Each phase and motion that they lead to is compiled, so that the loop can enter it.
        """
        run = self.run
        event = run.endings[jump.exit.event]
        if event < 0 or not jump.programs:  # a stall, which Python follows
            return
        self.table[solver.at, event] = ctypes.addressof(jump.programs[0].structure)
        for program in jump.programs:
            run.solver_of(program.phase)
            for region in program.regions:
                self.add_loop(self.place_of(region), run.impacts.driver(region).loop)

    def place_of(self, region: str) -> int:
        """Return the number of the loop of the motions in a region of impacts.

        The stages follow the phases in `loops`, in their order.
        """
        return len(self.run.phases) + [*self.run.impacts.stages].index(region)

    def _traced(self, jump: Any, state: tuple, world: Any) -> JumpProgram | None:
        """Record the program of a jump; return None if it does more than begin a phase.

        The inputs have the order in which `execute_first` in loop.c writes them. The results have
        that in which `note_change`, `begin_functions` and `change` read them, from `out` on signs,
        zeros and state, and from `after` on what `drive` reads from `made`.
        """
        run = self.run
        solver = run.solver
        regions = list[str]()
        state = state[: len(solver.workspace.motion.state)]
        signs = tuple(run.functions["sign"].tolist())
        given = world.body, (world.rules.e_n,), (run.end - world.left, world.left), signs, state
        program = Program(*given)

        def followed(region: str, *given: Any) -> list:
            """Record the call of `ImpactMotions.piece` as one line of the program.

            It replaces that method, so it has the same arguments and results.
            """
            regions.append(region)
            return program.call(self.place_of(region), partial(run.impacts.piece, region), *given)

        body, (e_n,), (now, left), signs, state = program.inputs
        world = world.with_numbers(body, e_n, left, followed)
        try:
            n, to, after, values = jump(run, state, world)
            numbers = leaves(tuple(n.rows.values()))
            if n.ends or to.sampled or len(numbers) > NUMBERS:
                return None
            sides, zeros, passed = to.begins(n, values, signs)
            ranges = dict[int, tuple]()
            if n.series:
                # Python must search the zero, or cut the delay at the end of the run
                if passed or not n.delay < left:
                    return None
                times = jump_times(now, now + n.delay)
                states = [to.variables.join(*n.series(time - now)) for time in times]
                points = to.points(states, to.phase.parameters(body))
                ranges = {k: values for k, values in points.items() if to.events[k].extremes}
            if passed:
                b = solver.phase.parameters(body)
                passed = [k for k in passed if to.notes(k, solver, state, b)]
        except (TypeError, ValueError) as error:  # a float, or a function that has no line
            cause = error.__cause__ or error
            if not isinstance(cause, (TypeError, ValueError)):
                raise cause from None
            return None
        pad = [0.0] * (len(to.workspace.motion.state) - len(after))
        ended = state[: len(solver.variables.names)]
        ranged = [*chain(*ranges.values())]
        results = [*ranged, *sides, *zeros, *after, *pad, n.lasts, n.delay, *numbers, *ended]
        first = program.joined(results)
        lines = program.code()
        constants = np.array([*program.constants.values()])
        result = program.count + len(constants)
        # the loop copies a whole row of `made`, beyond the last result
        if result + len(lines) + NUMBERS + STATE > MOST_REGISTERS:
            return None
        out = first.place + len(constants) + len(ranged)
        # the number 0 is a placeholder, as is that for `other` below: `learn` sets both
        places = result, out, out + 2 * len(sides) + len(after) + len(pad), to.at, 0
        events = [run.numbers[name] for name in n.logged], passed, [*ranges]
        every = np.array([*chain(*events)], np.int64)
        code = _Program(lines, constants, every, 0, len(lines), *places, *map(len, events))
        tables = [(name, len(row)) for name, rows in n.rows.items() for row in rows]
        return JumpProgram(code, filled(code), regions, n.phase, n.cause, tables)

    def drive(self, steps: int, changes: int) -> int:
        """Make at most `steps` steps and `changes` changes of phase; return the number of steps.

        The changes that the loop made are entered into the tables of the run, which is then where
        `HybridDriver._enter` would have left it: in the last phase, with its `began` and `until`.
        """
        run: Any = self.run
        record = self.record
        for solver in run.solvers.values():
            solver.workspace.loop.fill(run.output)
        until = run.motion.end[0]
        # clock and state are 0: the loop takes them from the lane
        ends = run.end, until, until, run.began
        begun = run.ending, run.solver.at, 0, 0, run.short_phases
        self.top[0] = 0.0, 0.0, *ends, *begun, 0, self.body.ctypes.data
        record.length = 0
        steps = library().loop_run(ctypes.byref(record), self.top.ctypes.data, steps, changes)
        solver = run.solver
        began = run.began
        for time, event, number, lasts, delay, *numbers in self.made[: record.length].tolist():
            jump = solver.exits[int(event)]
            program = jump.programs[int(number)]
            rest = iter(numbers)
            before = solver
            solver = run.solvers[program.phase]
            if program.cause:
                run.tables.begin(time, solver, program.cause)
            for name, size in program.tables:
                # as `PhaseTables.add`
                run.tables.rows[name].append([time, *islice(rest, size)])
            run.keep_interval(before, began, time, rest, jump)  # the state is behind the tables
            # as in `HybridDriver._enter`
            began = min(time + delay, run.end)
            run.until = began + lasts
        if record.length:
            run.set_phase(solver, began)
            run.short_phases = int(self.top["short_phases"][0])
            run.series = None
            run.changes += record.length
            run.end_next()
        return steps

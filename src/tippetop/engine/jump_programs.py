"""Changes of phase that the compiled loop makes by itself, by programs of jumps.

A jump that Python has made goes into `JumpPrograms.learn`, and `drive` lets the loop make steps and
the jumps that it can; the changes come back as rows of `made`. A jump is a Python function: it
takes 0.2 to 0.5 ms, its arithmetic some microseconds, and a bouncing top jumps hundreds of times.
The jump is therefore recorded once, by numbers that write down each operation (`mechanics.lines`),
and the loop repeats this straight-line program with other numbers. A comparison that turns out
otherwise ends a program; then one that was recorded on another branch is tried, and at last Python
makes the jump. All have the same bits, so it does not matter when a program is recorded.

Symbols
    jump      a `hybrid.Jump`; solver, to: the `PhaseSolver` of the phase that ends, of the next
    number    of an event: its index among all events of the run; of a program: its index in `known`
    lines     the operations of a program; registers: its numbers: inputs, constants, results
"""

import ctypes
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
NUMBERS, STATE = 24, 40
"""Most numbers that a change may pass to the tables, and variables where its phase ended."""
START = "start"
"""How a phase before the first one ends, from which tops in lanes begin."""
JUMP_PARTS = 8
"""Parts of a jump that takes time, between which the extremes of event functions are sought."""


class _Program(NamedTuple):
    """The structure `Program` of `loop.c`: a program, and the effects of its jump."""

    lines: np.ndarray
    registers: np.ndarray
    events: np.ndarray
    other: int
    length: int
    result: int
    out: int
    after: int
    next: int
    number: int
    logged: int
    passed: int
    ranged: int


TOP_RECORD = record_type(
    float="high low end until stop began",
    int="stops_by phase event steps short_phases",
)
"""A top: its clock, the ends of the run, of its phase and of its next steps, and the start of the
phase, internal; the event at the end of the next steps; the phase, and the event that ended it, or
a number below 0; steps before those of its tally; phases in a row that were too short.
"""


class Jumps(NamedTuple):
    """The structure `Jumps` of `loop.c`: the loops and programs of the phases of a system."""

    loops: np.ndarray
    programs: np.ndarray
    events: np.ndarray
    made: np.ndarray
    chatter: float
    length: int
    width: int
    numbers: int


class JumpProgram(NamedTuple):
    """The recorded program of a jump, which serves every run of its system."""

    code: _Program
    motions: list[tuple[int, str]]  # numbers of loops, and regions of impacts
    phase: str  # the next one
    cause: str  # of the change; empty if the table of phases gets no row
    tables: list[tuple[str, int]]  # each row of the other tables, and how many numbers it has
    jump: Any


class JumpPrograms:
    """Record the jumps of a run as programs, and let the loop execute them.

    `HybridDriver` makes it.

    Parameters
    ----------
    run
        A `HybridDriver`.

    Attributes
    ----------
    known
        The programs of this run, by the number that the loop reports.
    """

    patience = PATIENCE

    def __init__(self, run: Any):
        """Allocate the table in which the loop looks up programs; it is empty."""
        self.run = weakref.proxy(run)
        self.events = run.clock_number
        self.known = list[JumpProgram]()
        self.loops = np.zeros(len(run.phases) + len(run.impacts.stages), np.uint64)
        # by phase and event, the last by the clock: its programs, and where the first one is; the
        # start comes after all phases
        self.programs = [list[Any]() for _ in range((len(run.phases) + 1) * (self.events + 1))]
        self.table = np.zeros(len(self.programs), np.uint64)
        self.made = np.zeros((PER_SLICE, 4 + NUMBERS + STATE))
        # of the body and its contact, the constant inputs of programs
        self.body = np.array([*leaves(run.world.body), run.world.rules.e_n])
        self.top = np.zeros(1, TOP_RECORD)
        arrays = self.loops, self.table, run.all_events.events, self.made
        self.jumps = Jumps(*arrays, CHATTER, 0, self.made.shape[1], len(self.body))
        self.record: Any = filled(self.jumps)

    def add_loop(self, place: int, loop: Any) -> None:
        """Let programs use a loop by its number `place`: of a phase, or after them of a motion."""
        self.loops[place] = ctypes.addressof(loop.structure)

    def learn(self, jump: Any, *given: Any) -> None:
        """Count a jump that Python has made with these arguments (state, world).

        Record it when it is due.

        Only a jump that begins a phase, and does nothing else, becomes a program.
        """
        jump.calls += 1
        is_due = jump.calls >= self.patience and not jump.calls & (jump.calls - 1)
        if is_due and len(jump.programs) < BRANCHES:
            written = self._traced(jump, *given)
            known = {program.code.lines.tobytes() for program in jump.programs}
            if written and written.code.lines.tobytes() not in known:
                jump.programs.append(written)
        self.register(self.run.solver, jump)

    def register(self, solver: Any, jump: Any) -> None:
        """Enter the new programs of a jump into the table of the loop, for the exit of this phase.

        Each phase that they lead to is compiled.
        """
        run = self.run
        event = run.endings[jump.exit.event]
        if event < 0:  # a stall, which Python follows
            return
        number = solver.at * (self.events + 1) + event
        taken = self.programs[number]
        for program in jump.programs[len(taken) :]:
            run.solver_of(program.phase)  # compiles it, so that the loop can enter it
            for place, region in program.motions:
                self.add_loop(place, run.impacts.driver(region).loop)
            registers = program.code.registers.copy()
            change = program.code._replace(registers=registers, number=len(self.known))
            self.known.append(program._replace(code=change))
            made: Any = filled(change)
            if taken:
                taken[-1].other = ctypes.addressof(made)
            else:
                self.table[number] = ctypes.addressof(made)
            taken.append(made)

    def _traced(self, jump: Any, state: tuple, world: Any) -> JumpProgram | None:
        """Record the program of a jump; return None if it does more than begin a phase."""
        run = self.run
        solver = run.solver
        motions = list[tuple[int, str]]()
        state = state[: len(solver.workspace.motion.state)]
        signs = tuple(run.functions["sign"].tolist())
        given = world.body, (world.rules.e_n,), (run.end - world.left, world.left), signs, state
        program = Program(*given)

        def followed(region: str, *given: Any) -> list:
            """Record the call of `ImpactMotions.piece` as one line of the program.

            It replaces that method, so it has the same arguments and results.
            """
            place = len(run.phases) + [*run.impacts.stages].index(region)
            motions.append((place, region))
            return program.call(place, partial(run.impacts.piece, region), *given)

        body, (e_n,), (now, left), signs, state = program.inputs
        struck = partial(world.struck, piece=followed)
        rules = world.rules._replace(e_n=e_n)
        world = world._replace(body=body, rules=rules, left=left, struck=struck)
        try:
            n, to, after, values = jump(run, state, world)
            numbers = leaves(tuple(n.rows.values()))
            if n.ends or to.sampled or len(numbers) > NUMBERS:
                return None
            sides, zeros, passed = to.begins(n, values, signs)
            ranged: list = []
            ranges: list = []
            if n.series:
                if passed or not n.delay < left:
                    return None
                ranged, ranges = _ranged(n, to, now, body)
            if passed:
                b = solver.phase.parameters(body)
                passed = [k for k in passed if to.notes(k, solver, state, b)]
        except (TypeError, ValueError) as error:  # a float, or a function that has no line
            cause = error.__cause__ or error
            if not isinstance(cause, (TypeError, ValueError)):
                raise cause from None
            return None
        pad = [0.0] * (len(to.workspace.motion.state) - len(after))
        times = n.lasts, n.delay
        ended = state[: len(solver.variables.names)]
        results = [*ranges, *sides, *zeros, *after, *pad, *times, *numbers, *ended]
        first = program.joined(results)
        lines = program.code()
        constants = [*program.constants.values()]
        result = program.count + len(constants)
        registers = np.zeros(result + len(lines) + NUMBERS + STATE)
        registers[program.count : result] = constants
        out = first.place + len(constants) + len(ranges)
        places = result, out, out + 2 * len(sides) + len(after) + len(pad), to.at, 0
        events = [run.numbers[name] for name in n.logged], passed, ranged
        every = np.array([*chain(*events)], np.int64)
        return JumpProgram(
            _Program(lines, registers, every, 0, len(lines), *places, *map(len, events)),
            motions,
            n.phase,
            n.cause,
            [(name, len(row)) for name, rows in n.rows.items() for row in rows],
            jump,
        )

    def drive(self, steps: int, changes: int) -> int:
        """Make at most `steps` steps and `changes` changes of phase; return the number of steps.

        The changes that the loop made are entered into the tables of the run.
        """
        run: Any = self.run
        record = self.record
        for solver in run.solvers.values():
            solver.workspace.loop.fill(run.output)
        until = run.motion.end[0]
        ends = run.end, until, until, run.began
        self.top[0] = 0.0, 0.0, *ends, run.ending, run.solver.at, 0, 0, run.short_phases
        record.length = 0
        places = ctypes.byref(record), self.top.ctypes.data, self.body.ctypes.data
        steps = library().loop_run(*places, steps, changes)
        solver = run.solver
        began = run.began
        for time, number, lasts, delay, *numbers in self.made[: record.length].tolist():
            program = self.known[int(number)]
            rest = iter(numbers)
            before = solver
            solver = run.solvers[program.phase]
            if program.cause:
                run.tables.begin(time, solver, program.cause)
            for name, size in program.tables:
                run.tables.rows[name].append([time, *islice(rest, size)])
            run.keep_interval(before, began, time, rest, program.jump)
            began = min(time + delay, run.end)
            run.until = began + lasts
        if record.length:
            run.set_phase(solver, began)
            run.short_phases = int(self.top["short_phases"][0])
            run.series = None
            run.changes += record.length
            run.end_next()
        return steps


def _ranged(n: Any, to: Any, now: Any, body: Any) -> tuple[list[int], list]:
    """Return the events whose extremes may lie in the delay of n, and their functions there.

    They are numbers of events, and JUMP_PARTS + 1 values of each, one event after the other. n
    begins the phase `to` at the time `now`.
    """
    b = to.phase.parameters(body)
    time = now + n.delay
    points = []
    for k in range(JUMP_PARTS + 1):
        after = now + (time - now) * k / JUMP_PARTS - now
        state = to.variables.join(*n.series(after))
        points.append(to.formulas.functions(*to.variables.split(state), b))
    each = zip(to.events.items(), zip(*points, strict=True), strict=True)
    ranges = {number: values for (number, event), values in each if event.extremes}
    return [*ranges], [*chain(*ranges.values())]

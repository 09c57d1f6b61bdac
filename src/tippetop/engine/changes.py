"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import ctypes
import weakref
from functools import partial
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves
from .loop import filled, library, structure


PER_SLICE = 256
"""End a slice after this many changes. A fixed count, not a time limit, keeps stores reproducible.
"""
CHATTER = 1e-12
"""Three phases in a row that are shorter than this part of the internal time, which counts as 1 at
least, lead nowhere; after one of them Python makes the change.
"""
PATIENCE = 16
"""Changes before a jump is written down as a program; then after twice as many, until it is one."""
NUMBERS = 24
"""Most numbers that a change may pass to the tables."""


class _Change(NamedTuple):
    lines: np.ndarray
    registers: np.ndarray
    length: int
    result: int
    out: int
    next: int
    logged: int


class _Phases(NamedTuple):
    loops: np.ndarray
    changes: int
    events: np.ndarray
    made: np.ndarray
    began: float
    end: float
    chatter: float
    present: int
    length: int
    most: int
    numbers: int
    width: int


class Written(NamedTuple):
    """The program of a jump, for every run of its system."""

    change: _Change
    motions: list[tuple[int, str]]  # numbers of loops, and regions of impacts
    phase: str  # the next one
    cause: str  # of it
    tables: list[tuple[str, int]]  # each row of the other tables, and how many numbers it has


class Changes:
    """The changes of phase that the loop makes by itself in a run.

    Parameters
    ----------
    run
        A `HybridDriver`.

    Attributes
    ----------
    known
        The programs, by the number of a change.
    """

    def __init__(self, run: Any):
        self.run = weakref.proxy(run)
        self.events = len(run.numbers)
        self.known = dict[int, Written]()
        self.loops = np.zeros(len(run.phases) + len(run.impacts.stages), np.uint64)
        self.table: Any = (structure(_Change) * (len(run.phases) * self.events))()
        self.made = np.zeros((PER_SLICE, 3 + NUMBERS))
        self.body = leaves(run.world.body)
        arrays = self.loops, ctypes.addressof(self.table), run.all_events.events, self.made
        sizes = 0, 0, 0, len(self.body), self.made.shape[1]
        self.record: Any = filled(_Phases(*arrays, 0.0, float(run.end), CHATTER, *sizes))

    def learn(self, jump: Any, *given: Any) -> None:
        """Let the loop make a change of the present phase by itself, if its jump only begins a
        phase; Python has made it with these arguments.
        """
        jump.calls += 1
        if jump.program is None and jump.calls >= PATIENCE and not jump.calls & (jump.calls - 1):
            jump.program = self._traced(jump, *given)
        self.take_up(self.run.track, jump)

    def take_up(self, track: Any, jump: Any) -> None:
        """Let the loop make the change of a phase by a jump, if it has a program."""
        run = self.run
        event = self.run.numbers.get(jump.exit.event)
        program = jump.program
        if event is None or not program:
            return
        run.track_of(program.phase)  # compiles it, so that the loop can enter it
        for place, region in program.motions:
            self.loops[place] = ctypes.addressof(run.impacts.driver(region).loop.structure)
        registers = program.change.registers.copy()
        registers[: len(self.body)] = self.body
        change = program.change._replace(registers=registers)
        number = track.at * self.events + event
        self.table[number], self.known[number] = filled(change), program._replace(change=change)

    def _traced(self, jump: Any, state: tuple, world: Any) -> Written | None:
        """Return the program of a jump; None where it does more than begin a phase."""
        run = self.run
        motions = list[tuple[int, str]]()
        state = state[: len(run.state)]
        signs = tuple(run.functions["sign"].tolist())
        program = Program(world.body, (world.left,), signs, state)

        def followed(region: str, *given: Any) -> list:
            place = len(run.phases) + [*run.impacts.stages].index(region)
            motions.append((place, region))
            return program.call(place, partial(run.impacts.piece, region), *given)

        body, (left,), signs, state = program.inputs
        struck = partial(world.struck, piece=followed)
        world = world._replace(body=body, left=left, struck=struck)
        try:
            n, to, state, values = jump(run, state, world)
            sides, zeros, passed = to.begins(n, values, signs)
        except Exception:  # whatever a jump does that is no line
            return None
        numbers = leaves(tuple(n.rows.values()))
        is_more = n.ends or n.delay != 0 or not n.cause or passed or to.sampled
        if is_more or len(n.logged) != 1 or len(numbers) > NUMBERS:
            return None
        pad = [0.0] * (len(to.place.motion.state) - len(state))
        first = program.joined([*sides, *zeros, *state, *pad, n.lasts, *numbers])
        lines = program.code()
        constants = [*program.constants.values()]
        result = program.count + len(constants)
        registers = np.zeros(result + len(lines) + NUMBERS)
        registers[program.count : result] = constants
        places = result, first.place + len(constants), to.at, run.numbers[n.logged[0]]
        return Written(
            _Change(lines, registers, len(lines), *places),
            motions,
            n.phase,
            n.cause,
            [(name, len(row)) for name, rows in n.rows.items() for row in rows],
        )

    def drive(self, steps: int, changes: int) -> int:
        """Make at most so many steps and changes of phase, and return the number of steps."""
        run: Any = self.run
        record = self.record
        for track in run.tracks.values():
            track.place.loop.fill(run.wanted)
            self.loops[track.at] = ctypes.addressof(track.place.loop.structure)
        record.present = run.track.at
        record.began = run.began
        record.length = 0
        record.most = changes
        steps = library().loop_run(ctypes.byref(record), steps)
        for time, number, lasts, *numbers in self.made[: record.length].tolist():
            program = self.known[int(number)]
            rest = iter(numbers)
            track = run.tracks[program.phase]
            run.tables.begin(time, track, program.cause)
            for name, size in program.tables:
                run.tables.rows[name].append([time, *islice(rest, size)])
            run.until = time + lasts
        if record.length:
            run.follow(track, time)
            run.short = 0
            run.series = None
            run.changes += record.length
            run.end_next()
        return steps

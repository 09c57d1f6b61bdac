"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import ctypes
import math
import weakref
from functools import partial
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves
from .driver import NO_ROWS
from .loop import Loop, Rows, filled, library, structure


PATIENCE = 16
"""Changes before a jump is written down as a program; then after twice as many, until it is one."""
NUMBERS, MOTIONS, REGISTERS = 24, 8, 1 << 16
"""Most numbers that a change may pass to the tables, motions of impacts, and registers of a
program.
"""


class _Change(NamedTuple):
    lines: np.ndarray
    constants: np.ndarray
    length: int
    n_constants: int
    out: int
    next: int
    logged: int
    first: int
    last: int


class _Phases(NamedTuple):
    loops: np.ndarray
    changes: int
    registers: np.ndarray
    made: np.ndarray
    began: float
    end: float
    clock: float
    chatter: float
    present: int
    length: int
    most: int
    numbers: int
    width: int


class Written(NamedTuple):
    """The program of a jump, for every run of its system."""

    change: _Change
    motions: tuple[str, ...]  # regions of impacts
    phase: str  # the next one
    row: list[int]  # of it in the table of phases
    tables: list[tuple[str, int]]  # each row of the other tables, and how many numbers it has


class Changes:
    """The changes of phase that the loop makes by itself in a run.

    Parameters
    ----------
    run
        A `HybridDriver`.
    chatter
        After a shorter phase Python makes the change: a fraction of the internal time, which counts
        as 1 at least.
    most
        Changes in a call.

    Attributes
    ----------
    known
        The programs, by the number of a change.
    """

    def __init__(self, run: Any, chatter: float, most: int):
        self.run = weakref.proxy(run)
        self.events, self.known = len(run.events), dict[int, Written]()
        self.loops = np.zeros(len(run.phases) + MOTIONS, np.uint64)
        self.table: Any = (structure(_Change) * (len(run.phases) * self.events))()
        self.made = np.zeros((most, 3 + NUMBERS))
        body, self.registers = leaves(run.world.body), np.zeros(REGISTERS)
        self.registers[: len(body)] = body
        arrays = self.loops, ctypes.addressof(self.table), self.registers, self.made
        times = 0.0, float(run.end), 0.0, chatter
        sizes = 0, 0, most, len(body), self.made.shape[1]
        self.record: Any = filled(_Phases(*arrays, *times, *sizes))

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
        run, event, program = self.run, self.run.numbers.get(jump.exit.event), jump.program
        sampled = track.sampler or (program and run.track_of(program.phase).sampler)
        if event is None or not program or sampled:
            return
        number = track.at * self.events + event
        for region in program.motions:
            self._take_loop(self._place(region), run.impacts.driver(region).loop, NO_ROWS)
        self.table[number], self.known[number] = filled(program.change), program

    def _place(self, region: str) -> int:
        """Return the number of the loop of a motion."""
        return len(self.run.phases) + [*self.run.impacts.stages].index(region)

    def _take_loop(self, place: int, loop: Loop, rows: Rows) -> None:
        """Take a loop, which writes these rows."""
        loop.fill(rows)
        self.loops[place] = ctypes.addressof(loop.structure)

    def _traced(self, jump: Any, state: tuple, world: Any) -> Written | None:
        """Return the program of a jump; None where it does more than begin a phase."""
        run, regions = self.run, list[str]()
        track = run.track
        state += (0.0,) * (len(run.state) - len(state))
        program = Program(world.body, (world.left,), tuple(run.signs.tolist()), state)

        def followed(region: str, *given: Any) -> list:
            regions.append(region)
            return program.call(self._place(region), partial(run.impacts.piece, region), *given)

        body, (left,), signs, state = program.inputs
        struck = partial(world.struck, piece=followed)
        try:
            n, state, values = jump(state, world._replace(body=body, left=left, struck=struck))
            to = run.track_of(n.phase)
        except Exception:  # whatever a jump does that is no line
            return None
        numbers = leaves(tuple(n.rows.values()))
        goes_on = [(k, v) for k, v in zip(to.events, values, strict=True) if k in to.live]
        is_plain = (
            not n.ends
            and n.delay == 0
            and n.cause
            and len(n.logged) == 1
            and len(numbers) <= NUMBERS
            and program.count + 2 * len(program.lines) < REGISTERS
            and to.live <= track.live
            and all((value > 0) == (signs[k] > 0) for k, value in goes_on)
        )
        if not is_plain:
            return None
        sides, zeros = [*signs], [0.0] * self.events
        for k, side in to.sides(n).items():
            sides[k], zeros[k] = side
        pad, none = (
            [0.0] * size
            for size in (len(to.place.motion.state) - len(state), NUMBERS - len(numbers))
        )
        lasts = math.nan if n.lasts is None else n.lasts
        first = program.joined([*state, *pad, lasts, *numbers, *none, *sides, *zeros])
        lines, constants = program.code(), np.array([*program.constants.values()])
        logged = run.numbers[n.logged[0]]
        kept = run.all_events.events[logged][["first", "last"]].item()
        sizes = len(lines), len(constants), first.place - program.count
        return Written(
            _Change(lines, constants, *sizes, to.at, logged, *kept),
            tuple(regions),
            n.phase,
            run.tables.row_of(n.phase, to.phase, n.cause),
            [(name, len(row)) for name, rows in n.rows.items() for row in rows],
        )

    def drive(self, steps: int, changes: int) -> int:
        """Make at most so many steps and changes of phase, and return the number of steps."""
        run: Any = self.run
        record = self.record
        for track in run.tracks.values():
            self._take_loop(track.at, track.place.loop, run.wanted.rows)
        record.present, record.began = run.track.at, run.began
        record.length, record.most = 0, changes
        steps = library().loop_run(ctypes.byref(record), steps)
        for time, number, _, *numbers in self.made[: record.length].tolist():
            program, rest = self.known[int(number)], iter(numbers)
            run.tables.begin(time, program.row)
            for name, size in program.tables:
                run.tables.rows[name].append([time, *islice(rest, size)])
        if record.length:
            run.follow(run.tracks[program.phase], time)
            run.short, run.until = 0, record.clock
            run.changes += record.length
        return steps

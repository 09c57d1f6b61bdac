"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import ctypes
import math
from functools import partial
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves, refill
from .driver import NO_ROWS
from .loop import filled, library, structure
from .phase_tables import number_of


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
    body: np.ndarray
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
        Internal time: after a shorter phase Python makes the change.
    most
        Changes in a call.

    Attributes
    ----------
    known
        The programs, by the number of a change.
    """

    def __init__(self, run: Any, chatter: float, most: int):
        self.events, self.known = len(run.events), dict[int, Written]()
        self.loops = np.zeros(len(run.phases) + MOTIONS, np.uint64)
        self.table: Any = (structure(_Change) * (len(run.phases) * self.events))()
        self.made = np.zeros((most, 3 + NUMBERS))
        self.numbers = np.array(leaves(run.world.body)), np.zeros(REGISTERS)
        arrays = self.loops, ctypes.addressof(self.table), *self.numbers, self.made
        times = 0.0, float(run.end), 0.0, chatter
        sizes = 0, 0, most, len(self.numbers[0]), self.made.shape[1]
        self.record: Any = filled(_Phases(*arrays, *times, *sizes))

    def learn(self, run: Any, jump: Any, *given: Any) -> None:
        """Let the loop make a change of the present phase by itself, if its jump only begins a
        phase; Python has made it with these arguments.
        """
        if jump.exit.event not in run.numbers:
            return
        jump.calls += 1
        if jump.program is None and jump.calls >= PATIENCE and not jump.calls & (jump.calls - 1):
            jump.program = self._traced(run, jump, *given)
        self.take_up(run, run.track, jump)

    def take_up(self, run: Any, track: Any, jump: Any) -> None:
        """Let the loop make the change of a phase by a jump, if it has a program."""
        program: Written | None = jump.program
        if program and not track.sampler and not run.track_of(program.phase).sampler:
            number = track.at * self.events + run.numbers[jump.exit.event]
            for region in program.motions:
                run.impacts.driver(region)
            self.table[number], self.known[number] = filled(program.change), program

    def _traced(self, run: Any, jump: Any, state: tuple, world: Any) -> Written | None:
        """Return the program of a jump; None where it does more than begin a phase."""
        track, regions = run.track, list[str]()
        state += (0.0,) * (len(run.state) - len(state))
        program = Program(state, (world.left,), tuple(run.signs.tolist()), world.body)

        def followed(region: str, *given: Any) -> tuple:
            driver = run.impacts.driver(region)
            end, most, signs, zeros, pars, q = given
            none = [0.0] * (driver.width - len(q))
            inputs = end, most, *signs, *zeros, *pars[: len(driver.motion.pars)], *q, *none
            first = program.joined(inputs)
            values = (getattr(one, "value", one) for one in leaves(given))
            found = leaves(run.impacts.piece(region, *refill(given, values)))
            made = [program.line("motion", first, self._place(run, region), found[0])]
            made += [program.line("result", 0.0, value=value) for value in (*found[1:], *none)]
            regions.append(region)
            return *made[:3], q._make(made[3 : 3 + len(q)])

        state, (left,), signs, body = program.inputs
        struck = partial(world.struck, piece=followed)
        try:
            n, state, values = jump(state, world._replace(body=body, left=left, struck=struck))
            to = run.track_of(n.phase)
        except Exception:  # whatever a jump does that is no line
            return None
        kinds = run.tables.tables
        tables = [(name, row) for name, rows in n.rows.items() for row in rows]
        flat = [
            number_of(one, kind)
            for name, row in tables
            for one, kind in zip(row, kinds[name].values(), strict=True)
        ]
        goes_on = [(k, v) for k, v in zip(to.events, values, strict=True) if k in to.live]
        is_plain = (
            not n.ends
            and n.delay == 0
            and n.cause
            and len(n.logged) == 1
            and len(flat) <= NUMBERS
            and program.count + 2 * len(program.lines) < REGISTERS
            and to.live <= track.live
            and all((value > 0) == (signs[k] > 0) for k, value in goes_on)
        )
        if not is_plain:
            return None
        pad, none = [0.0] * (len(to.place.motion.state) - len(state)), [0.0] * (NUMBERS - len(flat))
        known = to.sides(n)
        sides, roots = zip(*(known.get(k, (0, 0)) for k in range(self.events)), strict=True)
        lasts = math.nan if n.lasts is None else n.lasts
        zeros = [-count for count in roots]
        first = program.joined([*state, *pad, *sides, *zeros, lasts, *flat, *none])
        lines, constants = program.code(), np.array([*program.constants.values()])
        logged = run.numbers[n.logged[0]]
        kept = run.all_events.events[logged][["first", "last"]].item()
        sizes = len(lines), len(constants), first.place - program.count
        return Written(
            _Change(lines, constants, *sizes, to.at, logged, *kept),
            tuple(regions),
            n.phase,
            run.tables.row_of(n.phase, to.phase, n.cause),
            [(name, len(row)) for name, row in tables],
        )

    def _place(self, run: Any, region: str) -> int:
        """Return the number of the loop of a motion."""
        return len(run.phases) + [*run.impacts.stages].index(region)

    def drive(self, run: Any, steps: int, changes: int) -> int:
        """Make at most so many steps and changes of phase, and return the number of steps."""
        record = self.record
        loops = {track.at: track.place.loop for track in run.tracks.values()}
        for loop in loops.values():
            loop.fill(run.wanted.rows)
        for region, driver in run.impacts.drivers.items():
            driver.loop.fill(NO_ROWS)
            loops[self._place(run, region)] = driver.loop
        for place, loop in loops.items():
            self.loops[place] = ctypes.addressof(loop.structure)
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

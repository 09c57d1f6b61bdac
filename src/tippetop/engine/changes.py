"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import ctypes
import math
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves, refill
from .driver import NO_ROWS
from .loop import filled, library, structure
from .stepper import Called


PATIENCE = 16
"""Changes before a jump is written down as a program; then after twice as many, until it is one."""
NUMBERS, MOTIONS = 24, 8
"""Most numbers that a change may pass to the tables, and motions of impacts."""


class Change(NamedTuple):
    """A change of phase, in numbers of the loop."""

    lines: np.ndarray
    registers: np.ndarray
    length: int
    begin: int
    out: int
    next: int
    logged: int
    first: int
    last: int


class _Phases(NamedTuple):
    loops: np.ndarray
    changes: int
    whole: np.ndarray
    made: np.ndarray
    began: float
    end: float
    clock: float
    chatter: float
    present: int
    length: int
    most: int
    integrals: int
    width: int


class Written(NamedTuple):
    """The program of a jump, for every run of its system."""

    lines: np.ndarray
    constants: tuple[float, ...]
    places: tuple[int, ...]  # as of `Change`, from `length` on
    motions: tuple[str, ...]  # regions of impacts
    phase: str
    row: list[int]  # in the table of phases
    tables: list[tuple[str, int]]  # each row of the others, and how many numbers it has


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
        self.run, self.known = run, dict[int, Written]()
        self.events, integrals = len(run.numbers), len(run.carried._fields)
        self.loops = np.zeros(len(run.phases) + MOTIONS, np.uint64)
        self.table: Any = (structure(Change) * (len(run.phases) * self.events))()
        self.whole, self.made = np.zeros(integrals), np.zeros((most, 6 + integrals + NUMBERS))
        arrays = self.loops, ctypes.addressof(self.table), self.whole, self.made
        sizes = 0, 0, most, integrals, self.made.shape[1]
        self.record: Any = filled(_Phases(*arrays, 0.0, float(run.end), 0.0, chatter, *sizes))
        self.kept: list[Change] = []

    def follow(self, place: int, loop: Any) -> None:
        """Follow a phase or a motion by a loop."""
        self.loops[place] = ctypes.addressof(loop.structure)

    def teach(self, exit: str, given: tuple) -> None:
        """Let the loop make a change of the present phase by itself, if its jump only begins a
        phase; `given` are its arguments.
        """
        run, track = self.run, self.run.track
        jump, number = track.exits[exit], track.at * self.events + run.numbers.get(exit, -1)
        is_stepped = track.sampler or isinstance(run.place.stepper, Called)  # by Python
        if number in self.known or exit not in run.numbers or is_stepped:
            return
        state, whole, left, piece, body = given
        state += (0.0,) * (len(run.state) - len(state))
        numbers = state, whole, (left,), tuple(run.signs.tolist()), body
        jump.calls += 1
        if jump.program is None and jump.calls >= PATIENCE and not jump.calls & (jump.calls - 1):
            jump.program = self._traced(jump, exit, numbers, piece)
        program: Written | None = jump.program
        if program is None or run.track_of(program.phase).sampler:
            return
        for region in program.motions:
            self._motion(region)
        inputs = [*leaves(numbers), *program.constants]
        registers = np.array([*inputs, *[0.0] * len(program.lines)])
        change = Change(program.lines, registers, *program.places)
        self.kept.append(change)
        self.table[number], self.known[number] = filled(change), program

    def _traced(self, jump: Any, exit: str, numbers: tuple, piece: Any) -> Written | None:
        """Return the program of a jump; None where it does more than begin a phase."""
        program, regions = Program(*numbers), list[str]()

        def followed(region: str, *given: Any) -> tuple:
            loop, parameters, variables = self._motion(region)
            regions.append(region)
            end, most, signs, zeros, pars, q = given
            inputs = end, most, *signs, *zeros, *pars[:parameters], *q
            first = program.joined([*inputs, *[0.0] * (variables - len(q))])
            values = (getattr(one, "value", one) for one in leaves(given))
            found = leaves(piece(region, *refill(given, values)))
            made = [program.line("motion", first, loop, found[0])]
            made += [program.line("result", 0.0, value=value) for value in found[1:]]
            made += [program.line("result", 0.0) for _ in range(variables - len(q))]
            return *made[:3], q._make(made[3 : 3 + len(q)])

        state, whole, (left,), signs, body = program.inputs
        try:
            n, state, whole, values = jump(state, whole, left, followed, body)
        except Exception:  # whatever a jump does that is no line
            return None
        run, to = self.run, self.run.track_of(n.phase)
        rows = {name: run.tables.numbers_of(name, some) for name, some in n.rows.items()}
        flat = [one for some in rows.values() for row in some for one in row]
        goes_on = [(k, v) for k, v in zip(to.events, values, strict=True) if k in to.live]
        is_plain = (
            (n.ends, n.delay, n.logged_after, n.series) == ("", 0, 0, None)
            and n.cause != ""
            and len(n.logged) == 1
            and n.logged[0] not in run.lasting
            and len(flat) <= NUMBERS
            and to.live <= run.track.live
            and all((value > 0) == (signs[k] > 0) for k, value in goes_on)
        )
        if not is_plain:
            return None
        pad, none = [0.0] * (len(to.place.motion.state) - len(state)), [0.0] * (NUMBERS - len(flat))
        sides, zeros = [0.0] * self.events, [0.0] * self.events
        for k, name in to.ways.items():
            sides[k] = n.sides.get(name, -to.events[k].direction)
            zeros[k] = -n.zeros.get(name, 0)
        lasts = math.nan if n.lasts is None else n.lasts
        results = *state, *pad, *whole, lasts, *flat, *none, *sides, *zeros
        first = program.joined(results)
        lines, constants = program.code(), tuple(program.constants.values())
        begin = program.count + len(constants)
        logged = run.numbers[n.logged[0]]
        kept = run.all_events.events[logged][["first", "last"]].item()
        places = len(lines), begin, first.place + len(constants), to.at, logged, *kept
        row = run.tables.row_of(to.name, to.phase, n.cause or exit)
        tables = [(name, len(row)) for name, some in rows.items() for row in some]
        return Written(lines, constants, places, tuple(regions), n.phase, row, tables)

    def _motion(self, region: str) -> tuple[int, int, int]:
        """Return the number of the loop of a motion, its parameters and variables."""
        piece = self.run.piece
        driver, place = piece.driver(region), len(self.run.phases) + [*piece.stages].index(region)
        driver.loop.fill(NO_ROWS)
        self.follow(place, driver.loop)
        return place, len(driver.motion.pars), driver.width

    def drive(self, steps: int, changes: int) -> int:
        """Make at most so many steps and changes of phase, and return the number of steps."""
        run, record, at = self.run, self.record, len(self.whole) + 3
        for track in run.tracks.values():
            track.place.loop.fill(run.wanted.rows)
        record.present, record.began, self.whole[:] = run.track.at, run.began, run.whole
        record.length, record.most = 0, changes
        steps = library().loop_run(ctypes.byref(record), steps)
        for time, number, *numbers in self.made[: record.length].tolist():
            program, rest = self.known[int(number)], iter(numbers[at + 1 :])
            run.tables.begin(time, program.row)
            for name, size in program.tables:
                run.tables.add(time, {name: [[*islice(rest, size)]]})
            whole = tuple(numbers[3:at])
            run.spans.append([program.places[3], *map(int, numbers[:3]), whole])
        if record.length:
            run.follow(run.tracks[program.phase], whole, time)
            run.changes, run.short, run.until = run.changes + record.length, 0, record.clock
        return steps

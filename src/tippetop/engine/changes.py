"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import math
from itertools import islice
from typing import Any

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves, refill
from .driver import NO_ROWS
from .loop import Change, PhaseLoop
from .stepper import Called


PATIENCE = 16
"""Changes before a jump is written down as a program; then after twice as many, until it is one."""
NUMBERS = 24
"""Numbers that one change may pass to the phase after it."""


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
        Of each change, by its number: the track that follows, its row in the table of phases, and
        how many numbers the rows of other tables have, by name.
    """

    def __init__(self, run: Any, chatter: float, most: int):
        self.run, self.known, self.events = run, dict[int, Any](), len(run.numbers)
        sizes = len(run.phases), self.events, len(run.carried._fields), NUMBERS, most
        self.loop = PhaseLoop(*sizes, float(run.end), chatter)

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
            jump.program = self._traced(jump, numbers, piece)
        if jump.program is None:
            return
        n, regions, code, constants, count, sizes = jump.program
        to, (logged,) = run.track_of(n.phase), n.logged
        if to.sampler:
            return
        for region in regions:
            self._motion(region)
        signs, zeros = np.zeros((2, self.events))
        for k, name in to.ways.items():
            signs[k] = n.sides.get(name, -to.events[k].direction)
            zeros[k] = -n.zeros.get(name, 0)
        inputs = [*leaves(numbers), *constants]
        registers = np.array([*inputs, *[0.0] * len(code)])
        place = run.numbers[logged]
        kept = run.all_events.events[place][["first", "last"]].item()
        places = len(code), len(inputs), len(registers) - count, to.at, place, *kept
        self.loop.teach(number, Change(code, registers, signs, zeros, *places))
        self.known[number] = to, run.tables.row_of(to.name, to.phase, n.cause or exit), sizes

    def _traced(self, jump: Any, numbers: tuple, piece: Any) -> tuple | None:
        """Return what the program of a jump leads to, the motions in it, its lines, constants and
        number of results, and how many of these are rows of tables; None where it does more than
        begin a phase.
        """
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
            n, *begun, values = jump(state, whole, left, followed, body)
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
        state, whole = begun
        pad, none = [0.0] * (len(to.place.motion.state) - len(state)), [0.0] * (NUMBERS - len(flat))
        lasts = math.nan if n.lasts is None else n.lasts
        results = *state, *pad, *whole, lasts, *flat, *none
        program.joined(results)
        sizes = [(name, len(row)) for name, some in rows.items() for row in some]
        return n, regions, program.code(), program.constants.values(), len(results), sizes

    def _motion(self, region: str) -> tuple[int, int, int]:
        """Return the number of the loop of a motion, its parameters and variables."""
        piece = self.run.piece
        driver, place = piece.driver(region), len(self.run.phases) + [*piece.stages].index(region)
        driver.loop.fill(NO_ROWS)
        self.loop.follow(place, driver.loop)
        return place, len(driver.motion.pars), driver.width

    def drive(self, steps: int, changes: int) -> int:
        """Make at most so many steps and changes of phase, and return the number of steps."""
        run, at = self.run, 5 + len(self.run.whole)
        for track in run.tracks.values():
            track.place.loop.fill(run.wanted.rows)
        made = self.loop.drive(run.track.at, run.began, run.whole, steps, changes)
        for time, number, *numbers in self.loop.taken():
            to, row, sizes = self.known[int(number)]
            run.tables.begin(time, row)
            rest = iter(numbers[at - 1 :])
            for name, size in sizes:
                run.tables.add(time, {name: [[*islice(rest, size)]]})
            run.spans.append([to.at, *map(int, numbers[:3])])
            run.wholes.append(tuple(numbers[3 : at - 2]))
        if count := self.loop.record.length:
            run.follow(to, run.wholes[-1], time)
            run.changes, run.short, run.until = run.changes + count, 0, self.loop.record.clock
        return made

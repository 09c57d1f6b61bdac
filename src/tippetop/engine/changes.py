"""Changes of phase that the compiled loop makes by itself, by programs of jumps."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..mechanics.lines import Number, Program
from ..mechanics.operand import leaves, refill
from .driver import NO_ROWS
from .loop import Change, PhaseLoop


PATIENCE = 16
"""Changes before a jump is written down as a program; then after twice as many, until it is one."""
NUMBERS = 24
"""Of a change for tables."""


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
        Of each change, by its number, what follows.
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
        jump, number = track.exits[exit], track.place * self.events + run.numbers.get(exit, -1)
        is_sampled = track.sampler or track.driver.is_called  # Python makes its steps
        if number in self.known or exit not in run.numbers or is_sampled:
            return
        state, whole, left, piece, body = given
        state += (0.0,) * (track.driver.width - len(state))
        numbers = state, whole, (left,), tuple(run.signs.tolist()), body
        jump.calls += 1
        if jump.program is None and jump.calls >= PATIENCE and not jump.calls & (jump.calls - 1):
            jump.program = self._traced(jump, numbers, piece)
        if jump.program is None:
            return
        begun, regions, code, constants, count = jump.program
        to, (logged,) = run.track_of(begun.n.phase), begun.n.logged
        if to.sampler:
            return
        for region in regions:
            self._motion(region)
        signs, zeros = np.zeros((2, self.events))
        for k, event in zip(to.numbers, to.events, strict=True):
            if k in to.ways:
                signs[k] = begun.n.sides.get(event.name, -event.direction)
                zeros[k] = -begun.n.zeros.get(event.name, 0)
        inputs = [*leaves(numbers), *constants]
        registers = np.array([*inputs, *[0.0] * len(code)])
        place = run.numbers[logged]
        kept = run.rows.events[place][["first", "last"]].item()
        sizes = len(code), len(inputs), len(registers) - count, to.place, place, *kept
        self.loop.teach(number, Change(code, registers, signs, zeros, *sizes))
        tables = {
            name: [[(one, isinstance(one, Number | float)) for one in row] for row in some]
            for name, some in begun.n.rows.items()
        }
        self.known[number] = begun.n, exit, to, tables

    def _traced(self, jump: Any, numbers: tuple, piece: Any) -> tuple | None:
        """Return what the program of a jump returns, the motions in it, its lines and constants,
        and the number of its results; None where it does more than begin a phase.
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
            begun = jump(state, whole, left, followed, body)
        except Exception:  # whatever a jump does that is no line
            return None
        n, to = begun.n, self.run.track_of(begun.n.phase)
        rows = [one for one in leaves(tuple(n.rows.values())) if isinstance(one, Number | float)]
        goes_on = [(k, v) for k, v in zip(to.numbers, begun.values, strict=True) if k in to.live]
        is_plain = (
            (n.ends, n.delay, n.logged_after, n.series) == ("", 0, 0, None)
            and len(n.logged) == 1
            and n.logged[0] not in self.run.lasting
            and len(rows) <= NUMBERS
            and to.live <= self.run.track.live
            and all((value > 0) == (signs[k] > 0) for k, value in goes_on)
        )
        if not is_plain:
            return None
        pad, none = [0.0] * (to.driver.width - len(begun.state)), [0.0] * (NUMBERS - len(rows))
        lasts = math.nan if n.lasts is None else n.lasts
        results = *begun.state, *pad, *begun.whole, lasts, *rows, *none
        program.joined(results)
        return begun, regions, program.code(), program.constants.values(), len(results)

    def _motion(self, region: str) -> tuple[int, int, int]:
        """Return the number of the loop of a motion, its parameters and variables."""
        piece = self.run.impacts.piece
        driver, place = piece.driver(region), len(self.run.phases) + [*piece.stages].index(region)
        driver.loop.fill(NO_ROWS)
        self.loop.follow(place, driver.loop)
        return place, len(driver.motion.pars), driver.width

    def taken(self) -> Iterator[tuple]:
        """Yield the changes that were made: time, the `Next`, its exit, the track that follows,
        counts of rows, passages and samples, integrals and rows.
        """
        at = 5 + len(self.run.whole)
        for made in self.loop.taken():
            n, exit, to, tables = self.known[int(made[1])]
            numbers = iter(made[at + 1 :])
            rows = {
                name: [
                    [next(numbers) if is_number else one for one, is_number in row] for row in some
                ]
                for name, some in tables.items()
            }
            yield made[0], n, exit, to, made[2:5], tuple(made[5:at]), rows

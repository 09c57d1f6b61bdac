"""Changes of phase that the compiled loop makes by itself: straight-line copies of jumps become
programs, of which each line writes one register.
"""

import ast
import ctypes
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.inlining import unit_of
from ..mechanics.operand import leaves
from ..mechanics.writing import Symbol
from .driver import NO_ROWS
from .loop import filled, library, structure


OPERATIONS = [
    *("Add", "Sub", "Mult", "Div", "Pow", "Lt", "LtE", "Gt", "GtE", "Eq", "NotEq", "USub"),
    *("sqrt", "absolute", "larger", "unit", "expect", "expect not", "copy", "motion", "result"),
]
"""As in the loop."""

Place = tuple[str, int]
"""A register: of a line or an input, and its number; or a number itself."""


class Program:
    """A copy of a function as lines.

    Parameters
    ----------
    copy
        The copy.
    inputs
        How many numbers the loop writes of each of the first arguments.
    outputs
        The results, symbols and numbers, which are the last lines.
    motion
        motion(region) -> the number of the loop of a motion, its parameters and variables.

    Raises
    ------
    TypeError
        If a line has a function that the loop does not know.
    """

    def __init__(self, copy: Any, inputs: Sequence[int], outputs: Sequence, motion: Callable):
        self.names, self.motion, self.count = copy.trace.values, motion, sum(inputs)
        self.given: list[Any] = []  # expressions of further inputs
        self.regions: list[str] = []
        self.lines: list[tuple[str, Place, Place]] = []
        self.places: dict[str, Place] = {}
        for k, count in enumerate(inputs):
            first = sum(inputs[:k])
            self.places |= {f"a{k}[{i}]": ("input", first + i) for i in range(count)}
            self.places[f"a{k}"] = "input", first
        for text, name in copy.trace.needed([*copy.trace.expected, *outputs]):
            self.places[name] = self.place(ast.parse(text, mode="eval").body, name)
        for one in outputs:
            self.add("copy", self.operand(ast.parse(copy.trace.of(one).name, mode="eval").body))
        self.begin = self.count + len(self.given)  # the first register of a line

        def register(place: Place) -> int:
            return place[1] + self.begin * (place[0] == "line")

        lines = [(OPERATIONS.index(o), register(a), register(b)) for o, a, b in self.lines]
        self.code = np.array(lines, np.int64)

    def add(self, what: str, a: Place = ("", 0), b: Place = ("", 0)) -> Place:
        """Add a line."""
        self.lines.append((what, a, b))
        return "line", len(self.lines) - 1

    def operand(self, node: Any) -> Place:
        """Return the register of an operand."""
        text = ast.unparse(node)
        if text not in self.places:
            self.given.append(compile(text, "", "eval"))
            self.places[text] = "input", self.count + len(self.given) - 1
        return self.places[text]

    def place(self, node: Any, name: str) -> Place:
        """Return the register of an expression."""
        match node:
            case ast.BinOp(left, kind, right) | ast.Compare(left, [kind], [right]):
                if isinstance(getattr(right, "value", None), str):
                    return self.operand(node)
                return self.add(type(kind).__name__, self.operand(left), self.operand(right))
            case ast.UnaryOp(ast.USub(), number):
                return self.add("USub", self.operand(number))
            case ast.BoolOp(_, [ast.UnaryOp(ast.Not(), number), _]):
                return self.add("expect not", self.operand(number))
            case ast.BoolOp(_, [number, _]):
                return self.add("expect", self.operand(number))
            case ast.Call(ast.Name(function), numbers):
                if self.names.get(function) is unit_of.plain:
                    largest = self.operand(numbers[0])
                    for number in numbers:
                        largest = self.add("larger", largest, self.operand(number))
                    return self.add("unit", largest)
                if function in self.places:
                    return self.follow(*numbers, name=name)
                if function not in OPERATIONS:
                    raise TypeError(f"the loop has no function {function}")
                return self.add(function, *map(self.operand, numbers))
            case ast.Name(argument) if argument not in self.places:
                return "function", 0
        return self.operand(node)

    def follow(self, region: Any, *inputs: Any, name: str) -> Place:
        """Return the first register of the results of a motion."""
        self.regions.append(self.names[region.id])
        loop, parameters, variables = self.motion(self.regions[-1])
        end, most, signs, zeros, pars, q = (self.listed(one) for one in inputs)
        none = [ast.Constant(0.0)] * (variables - len(q))
        numbers = [*end, *most, *signs, *zeros, *pars[:parameters], *q, *none]
        first, *_ = [self.add("copy", place) for place in [*map(self.operand, numbers)]]
        place = self.add("motion", first, ("", loop))
        states = [f"[3][{k}]" for k in range(variables)]
        texts = dict(enumerate(["[0]", "[1]", "[2]", *states]))
        self.places |= {name + text: ("line", place[1] + k) for k, text in texts.items()}
        for _ in range(2 + variables):
            self.add("result")
        return place

    def listed(self, node: Any) -> list:
        """Return the numbers of a record."""
        if isinstance(node, ast.Call):
            node = node.args[1]
        return node.elts if isinstance(node, ast.Tuple) else [node]

    def registers(self, arguments: dict[str, Any]) -> np.ndarray:
        """Return its registers, with the further inputs that arguments give."""
        registers, names = np.zeros(self.begin + len(self.lines)), self.names | arguments
        registers[self.count : self.begin] = [eval(one, names) for one in self.given]
        return registers


class Change(NamedTuple):
    lines: np.ndarray
    registers: np.ndarray
    signs: np.ndarray
    zeros: np.ndarray
    count: int
    begin: int
    out: int
    next: int
    logged: int
    first: int
    last: int


class _Phases(NamedTuple):
    loops: np.ndarray
    changes: np.ndarray
    whole: np.ndarray
    made: np.ndarray
    began: float
    end: float
    clock: float
    chatter: float
    present: int
    count: int
    most: int
    integrals: int
    width: int


MOST_MOTIONS, NUMBERS = 8, 24
"""Regions of a law; numbers of a change for tables."""


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
        Of each change its `Next`, its exit, the track that follows, and its rows as a function of
        numbers; nothing where the loop cannot make it.
    """

    def __init__(self, run: Any, chatter: float, most: int):
        self.run, self.known, self.kept = run, dict[int, tuple](), list[Any]()
        phases, self.events, integrals = len(run.phases), len(run.numbers), len(run.carried._fields)
        self.loops = np.zeros(phases + MOST_MOTIONS, np.uint64)
        kind: Any = structure(Change)
        self.table = (kind * (phases * self.events))()
        self.whole, self.made = np.zeros(integrals), np.zeros((most, 6 + integrals + NUMBERS))
        arrays = self.loops, np.frombuffer(self.table, np.uint8), self.whole, self.made
        sizes = 0, 0, most, integrals, self.made.shape[1]
        self.record: Any = filled(_Phases(*arrays, 0.0, float(run.end), 0.0, chatter, *sizes))

    def follow(self, place: int, loop: Any) -> None:
        """Follow a phase or a motion by a loop."""
        self.loops[place] = ctypes.addressof(loop.structure)

    def teach(self, copy: Any, exit: str) -> None:
        """Let the loop make a change of the present phase, if its copy only begins a phase."""
        run, track, begun = self.run, self.run.track, copy.result
        number = track.place * self.events + run.numbers.get(exit, -1)
        if exit not in run.numbers or number in self.known:
            return
        n, to = begun.n, run.track_of(begun.n.phase)
        self.known[number] = ()
        signs, zeros = np.zeros((2, self.events))
        for k, event in zip(to.numbers, to.events, strict=True):
            if k in to.ways:
                signs[k] = n.sides.get(event.name, -event.direction)
                zeros[k] = -n.zeros.get(event.name, 0)
        *delays, lasts = begun.times
        is_plain = begun.keeps and delays == [0, 0] and len(n.logged) == 1 and n.series is None
        numbers = [one for one in leaves(begun.rows) if isinstance(one, Symbol | float)]
        is_plain = is_plain and len(numbers) <= NUMBERS
        if not is_plain or track.sampler or to.sampler or not signs[[*to.ways]].all():
            return
        pad = [0.0] * (to.driver.width - len(begun.state))
        lasts = np.nan if lasts is None else lasts
        none = [0.0] * (NUMBERS - len(numbers))
        outputs = *begun.state, *pad, *begun.whole, lasts, *numbers, *none
        inputs = track.driver.width, len(self.whole), 1, self.events
        if not hasattr(copy, "program"):
            try:
                copy.program = Program(copy, inputs, outputs, self._motion)
                listed = iter([Symbol(copy.trace, f"n[{k}]") for k in range(len(numbers))])
                text = f"lambda n: {copy.trace.written(_with(begun.rows, listed))}"
                copy.program.rows = eval(text, copy.trace.values)
            except TypeError:
                copy.program = None
        if copy.program:
            for region in copy.program.regions:
                self._motion(region)
            given = run.problem.contact, None, run.body
            arguments = {f"a{k}": value for k, value in enumerate(given, len(inputs))}
            program, registers = copy.program, copy.program.registers(arguments)
            logged = run.numbers[n.logged[0]]
            kept = run.rows.events[logged][["first", "last"]].item()
            sizes = len(program.code), program.begin, len(registers) - len(outputs)
            change = Change(program.code, registers, signs, zeros, *sizes, to.place, logged, *kept)
            self.kept.append(change)
            self.table[number] = filled(change)
            self.known[number] = n, exit, to, program.rows

    def _motion(self, region: str) -> tuple[int, int, int]:
        """Return the number of the loop of a motion, its parameters and variables."""
        piece = self.run.impacts.piece
        driver, place = piece.driver(region), len(self.run.phases) + [*piece.stages].index(region)
        driver.loop.fill(NO_ROWS)
        self.follow(place, driver.loop)
        return place, len(driver.motion.pars), driver.width

    def make(self, most: int, changes: int) -> int:
        """Make at most `most` steps and `changes` changes of phase; return the number of steps."""
        run, record, self.whole[:] = self.run, self.record, self.run.whole
        record.present, record.began = run.track.place, run.began
        record.count, record.most = 0, changes
        return library().loop_run(ctypes.byref(record), most)

    def taken(self) -> Iterator[tuple]:
        """Yield the changes that were made: time, what the copy returns, its exit, the track that
        follows, counts of rows, passages and samples, integrals and rows.
        """
        at = 5 + len(self.whole)
        for row in self.made[: self.record.count].tolist():
            n, exit, to, rows_of = self.known[int(row[1])]
            yield row[0], n, exit, to, row[2:5], tuple(row[5:at]), rows_of(row[at + 1 :])


def _with(record: Any, numbers: Iterator) -> Any:
    """Return a record with numbers in place of symbols."""
    if isinstance(record, tuple):
        return tuple.__new__(type(record), [_with(one, numbers) for one in record])
    return next(numbers) if isinstance(record, Symbol | float) else record

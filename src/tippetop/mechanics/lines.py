"""Programs: the operations of one run of a function of numbers, one after another.

A function that is called with the `inputs` of a `Program` leaves a line for each operation;
`code()` returns them for the loop in C (`engine.jump_programs`, `engine.column_programs`). A
program repeats the run for other numbers, as long as every comparison turns out as it did.

Symbols
    line      an operation and the places of its operands; its result is a register
    place     index of a register: inputs first, then results of lines; negative: a constant
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from .dual import Dual, plain
from .operand import leaves, refill


OPERATIONS = (
    *("add", "subtract", "multiply", "divide", "power", "negative", "sqrt", "absolute", "maximum"),
    *("exp", "log", "arctan2", "sin", "cos"),
    *("less", "less_equal", "equal", "unit", "expect", "motion", "result"),
)
"""In the order of the loop: a line contains the place of its operation here. All but the last four
are functions of NumPy."""

TURNED = {"greater": "less", "greater_equal": "less_equal", "fmax": "maximum"}
"""Functions of NumPy that are one of the operations on their operands in the other order.

`fmax` so ignores a NaN in its first operand only.
"""


@dataclass(eq=False)
class Number(NDArrayOperatorsMixin):
    """A number of a run, whose operations become lines of its program; not a `number.Number`.

    Parameters
    ----------
    program
        The program.
    place
        Of its register: see `Program`.
    value
        Its value in the run.
    """

    program: "Program"
    place: int
    value: Any

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, out: Any = None) -> Any:
        """Apply a function of NumPy; `out`, of an assignment such as +=, becomes another number."""
        if any(isinstance(one, Dual) for one in inputs):
            return NotImplemented
        values = (one.value if isinstance(one, Number) else one for one in inputs)
        name = function.__name__
        a = inputs[0]
        b = inputs[-1]
        if name in TURNED:
            name, a, b = TURNED[name], b, a
        key = (name, *map(self.program.place, (a, b)))
        known = self.program.known
        if key not in known:
            known[key] = self.program.line(name, a, b, function(*values))
        return known[key]

    def __bool__(self) -> bool:
        is_true = bool(self.value)
        self.program.line("expect", self, is_true)
        return is_true


class Program:
    """A program for the loop: its lines are an operation and the places of two operands.

    `writing.Program` is another one, of text. A place is that of an input, then those of lines;
    negative: -1 minus that of a constant.

    Parameters
    ----------
    inputs
        Records of numbers.
    """

    def __init__(self, *inputs: tuple):
        """Make a symbolic number of each input; there are no lines yet."""
        values = leaves(inputs)
        numbers = (Number(self, k, value) for k, value in enumerate(values))
        # (index in OPERATIONS, place of a, place of b)
        self.lines = list[tuple]()
        # by their bits, as `float.hex` writes them; in the order of their places
        self.constants = dict[str, float]()
        # of the inputs
        self.count = len(values)
        # the records with a symbolic number for each number
        self.inputs = refill(inputs, numbers)
        # results by (operation, place of a, place of b): a repeated operation gets no second line
        self.known = dict[tuple, Number]()

    def place(self, value: Any) -> int:
        """Return the place of the register of a number; a constant gets one if it has none.

        Constants are compared by their bits. `code` renumbers the registers: a change of one is a
        change of both.
        """
        if isinstance(value, Number):
            return value.place
        number = float(value)
        self.constants.setdefault(number.hex(), number)  # -0.0 is another number than 0.0
        return -1 - [*self.constants].index(number.hex())

    def line(self, what: str, a: Any, b: Any = 0.0, value: Any = None) -> Number:
        """Add a line, and return its result: the operation `what` of a and b, which gives `value`.

        `what` is one of OPERATIONS.
        """
        self.lines.append((OPERATIONS.index(what), self.place(a), self.place(b)))
        return Number(self, self.count + len(self.lines) - 1, value)

    def joined(self, values: Sequence) -> Number:
        """Copy values to consecutive registers, for a MOTION; return the first one.

        A product with 1 is a new line always, and keeps all bits.
        """
        first, *_ = [self.line("multiply", value, 1.0) for value in values]
        return first

    def call(self, place: int, function: Callable, *inputs: Any) -> list[Number]:
        """Record the call of a function whose work a loop does when the program is repeated.

        It takes numbers and records of them, and returns a list of numbers. `place` is the number
        of the loop. Return the results of the call.
        """
        first = self.joined(leaves(inputs))
        values = (getattr(one, "value", one) for one in leaves(inputs))
        made, *others = function(*refill(inputs, values))
        results = [self.line("motion", first, place, made)]
        return results + [self.line("result", 0.0, value=value) for value in others]

    def code(self) -> np.ndarray:
        """Return the lines (k, 3) with numbers of registers, as the loop has them.

        Registers are those of inputs, then of constants, then of lines.
        """
        code = np.array(self.lines, np.int64)
        constants = len(self.constants)
        places = code[:, 1:]
        places[places >= self.count] += constants
        places[places < 0] = self.count - 1 - places[places < 0]
        return code


def unit_of(*values: Any) -> Any:
    """Return the least power of two above the largest of the sizes of some numbers.

    Numbers of a program give a number of the program, and a line. The operation UNIT of `loop.c`
    computes the same: a change of one is a change of both.
    """
    values = plain(values)
    if isinstance(values[0], Number):
        largest = reduce(np.maximum, map(abs, values))
        return values[0].program.line("unit", largest, 0.0, unit_of(largest.value))
    return math.ldexp(1.0, math.frexp(max(map(abs, map(float, values))))[1])

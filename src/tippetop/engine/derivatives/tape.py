"""Record functions of numbers, and repeat them with derivatives by compiled code.

A formula or a jump takes milliseconds in numbers with derivatives, and its record microseconds.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tippetop_kernels.compilation import Entry

from ...mechanics.lines import OPERATIONS, Program


ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER, NEGATIVE, SQRT, ABSOLUTE, MAXIMUM = range(9)
EXP, LOG, ARCTAN2, SIN, COS, LESS, LESS_EQUAL, EQUAL, UNIT, EXPECT, MOTION, RESULT = range(9, 21)
assert OPERATIONS[EXP] == "exp"
assert OPERATIONS[RESULT] == "result"


def _executed(lines, k, registers, least):
    """Execute lines from the k-th on; return the number of the next MOTION, or of the end.

    Return -1 if a comparison turns out otherwise. Each line is an operation and the places a, b of
    its operands. `registers` are values and their derivatives;
    `least` gets the smallest change along each direction at which a comparison would.
    """
    first = len(registers) - len(lines)
    while k < len(lines):
        what, a, b = lines[k]
        x = registers[a, 0, 0]
        y = registers[b, 0, 0]
        p = 0.0
        q = 0.0
        r = 0.0
        if what == MULTIPLY:
            r, p, q = x * y, y, x
        elif what == ADD:
            r, p, q = x + y, 1.0, 1.0
        elif what == SUBTRACT:
            r, p, q = x - y, 1.0, -1.0
        elif what == DIVIDE:
            r = x / y
            p, q = 1 / y, -r / y
        elif what == NEGATIVE:
            r, p = -x, -1.0
        elif what == SQRT:
            r = math.sqrt(x)
            p = 0.5 / r
        elif what == POWER:
            r = x**y
            p = y * x ** (y - 1)
            q = r * math.log(x) if x > 0 else 0.0
        elif what == ABSOLUTE:
            r, p = abs(x), np.sign(x)
        elif what == MAXIMUM:
            r = max(x, y)
            p = 1.0 if x >= y else 0.0
            q = 1 - p
        elif what == EXP:
            r = math.exp(x)
            p = r
        elif what == LOG:
            r, p = math.log(x), 1 / x
        elif what == ARCTAN2:
            r = math.atan2(x, y)
            size = x * x + y * y
            p, q = y / size, -x / size
        elif what == SIN:
            r, p = math.sin(x), math.cos(x)
        elif what == COS:
            r, p = math.cos(x), -math.sin(x)
        elif what == UNIT:
            r = math.ldexp(1.0, math.frexp(x)[1])
        elif what == EXPECT:
            if (x != 0) != (y != 0):
                return -1
        elif what == MOTION:
            return k
        elif what == RESULT:
            k += 1
            continue
        else:
            r = x < y if what == LESS else x <= y if what == LESS_EQUAL else x == y
            for j in range(len(least)):
                change = abs(registers[a, 1, j] - registers[b, 1, j])
                if abs(x - y) < least[j] * change:
                    least[j] = abs(x - y) / change
        for j in range(len(least)):
            registers[first + k, 0, j] = r
            registers[first + k, 1, j] = p * registers[a, 1, j] + q * registers[b, 1, j]
        k += 1
    return k


_execute = Entry(_executed)


class Tape:
    """The recorded operations of a function of numbers, on one branch of its comparisons.

    `through.evaluated` makes tapes, and calls them with other numbers.

    Parameters
    ----------
    function
        function(call, inputs) -> numbers, and what they depend on: see `evaluated`.
    inputs
        Numbers.
    """

    def __init__(self, function: Callable, inputs: Sequence):
        """Call the function once with symbolic inputs, and record its operations as lines.

        It must be a function of its inputs alone: later calls repeat this branch.
        """
        program = Program(*inputs)
        results, self.about = function(program.call, program.inputs)
        program.joined(results)
        self.results = slice(-len(results), None)
        self.lines = program.code()
        self.constants = [*program.constants.values()]

    def __call__(self, numbers: np.ndarray, follow: Any = None) -> tuple | None:
        """Repeat the function for other inputs; return None if a comparison turns out otherwise.

        Return the results with their derivatives, and the least change along each direction at
        which a comparison would.

        Parameters
        ----------
        numbers
            The inputs and their derivatives, (inputs, 2, directions).
        follow
            follow(place, numbers) of the motion that a place stands for.
        """
        count, _, directions = numbers.shape
        first = count + len(self.constants)
        registers = np.zeros((first + len(self.lines), 2, directions))
        registers[:count] = numbers
        registers[count:first, 0] = np.array(self.constants)[:, None]
        least = np.full(directions, np.inf)
        k = _execute(self.lines, 0, registers, least)
        while 0 <= k < len(self.lines):
            _, a, place = self.lines[k]
            made = follow(int(registers[place, 0, 0]), registers[a : first + k])
            registers[first + k : first + k + len(made)] = made
            k = _execute(self.lines, k + 1, registers, least)
        return None if k < 0 else (registers[self.results], least)

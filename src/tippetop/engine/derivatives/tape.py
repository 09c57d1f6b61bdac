"""Record functions of numbers, and repeat them with derivatives by compiled code.

A formula or a jump takes milliseconds in numbers with derivatives, and its record microseconds.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tippetop_kernels.compilation import Entry

from ...mechanics.lines import OPERATIONS, Program


ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER, NEGATIVE, SQRT, ABSOLUTE, MAXIMUM = range(9)
EXP, LOG, ARCTAN2, SIN, COS, LESS, LESS_EQUAL, EQUAL, UNIT, EXPECT, MOTION, RESULT = range(9, 21)
assert OPERATIONS[EXP] == "exp"
assert OPERATIONS[RESULT] == "result"


def _executed(lines, k, values, moves, least):
    """Execute lines from the k-th on; return the number of the next MOTION, or of the end.

    Return -1 if a comparison turns out otherwise. `least` gets the smallest change along each
    direction at which one would.
    """
    first = len(values) - len(lines)
    while k < len(lines):
        what, a, b = lines[k]
        x = values[a]
        y = values[b]
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
                change = abs(moves[a, j] - moves[b, j])
                if abs(x - y) < least[j] * change:
                    least[j] = abs(x - y) / change
        values[first + k] = r
        for j in range(moves.shape[1]):
            moves[first + k, j] = p * moves[a, j] + q * moves[b, j]
        k += 1
    return k


_execute = Entry(_executed)


class Tape:
    """The recorded operations of function(*inputs) -> numbers, on one branch of its comparisons.

    Parameters
    ----------
    function
        function(program, *inputs), of records of numbers.
    inputs
        The records.
    """

    def __init__(self, function: Callable, *inputs: tuple):
        program = Program(*inputs)
        results, self.about = function(program.call, *program.inputs)
        self.length = len(results)
        program.joined(results)
        self.lines = program.code()
        self.count = program.count
        constants = [*program.constants.values()]
        self.size = self.count + len(constants) + len(self.lines)
        self.constants = np.array(constants)

    def __call__(
        self, values: np.ndarray, moves: np.ndarray, follow: Any = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Repeat the function for other inputs; return None if a comparison turns out otherwise.

        Return the results, their derivatives, and the least change along each direction at which a
        comparison would.

        Parameters
        ----------
        values, moves
            The inputs, and their derivatives (inputs, lanes).
        follow
            follow(place, values, moves) of the motion that a place stands for.
        """
        registers = np.zeros(self.size)
        tangents = np.zeros((self.size, moves.shape[1]))
        n = self.count
        registers[:n] = values
        registers[n : n + len(self.constants)] = self.constants
        tangents[:n] = moves
        first = self.size - len(self.lines)
        least = np.full(moves.shape[1], np.inf)
        k = _execute(self.lines, 0, registers, tangents, least)
        while 0 <= k < len(self.lines):
            _, a, place = self.lines[k]
            given = slice(a, first + k)
            made, by = follow(int(registers[place]), registers[given], tangents[given])
            results = slice(first + k, first + k + len(made))
            registers[results] = made
            tangents[results] = by
            k = _execute(self.lines, k + 1, registers, tangents, least)
        results = slice(-self.length, None)
        return None if k < 0 else (registers[results], tangents[results], least)

"""Functions of numbers, repeated for columns of numbers with 80 bits.

The function is recorded once, as a program of its operations: NumPy would take a microsecond for
each of them. Series of slow slides are computed so, and jumps with derivatives.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..mechanics.lines import Program
from .loop import library


BRANCHES = 32
"""Most programs of a function."""


class ColumnProgram:
    """A function of the numbers of a column.

    Parameters
    ----------
    function
        function(*values) -> a list of numbers.
    values
        Numbers of a column.
    """

    def __init__(self, function: Callable, values: Sequence | np.ndarray):
        """Record the function; its results are the last lines.

        Raises TypeError or ValueError if an operation of the function has no line in a program.
        """
        program = Program(tuple(values))
        (inputs,) = program.inputs
        results = function(*inputs)
        program.joined(results)
        self.code = np.ascontiguousarray(program.code())
        self.constants = np.array([*program.constants.values()])[:, None]
        self.results = len(results)

    def __call__(self, values: np.ndarray, follow: Any = None) -> np.ndarray | None:
        """Return the results, (results, n), of columns (values, n).

        Return None if a comparison turns out otherwise than in the recorded call. The results of a
        motion, see `Program.call`, are follow(place, its inputs), an array (results, n): its inputs
        are all registers from `a` up to that of the motion. The results are the last registers.
        """
        inputs, n = values.shape
        first = inputs + len(self.constants)
        registers = np.empty((first + len(self.code), n), np.longdouble)
        registers[:inputs] = values
        registers[inputs:first] = self.constants
        address = registers.ctypes.data
        done = 0
        while True:
            lines = self.code[done:]
            made = library().loop_columns(len(lines), first + done, n, lines.ctypes.data, address)
            if made < 0:
                return None
            if made == len(lines):
                return registers[-self.results :]
            _, a, place = lines[made]  # the MOTION: registers of its first input and its number
            done += made + 1
            results = follow(int(registers[place, 0]), registers[a : first + done - 1])
            registers[first + done - 1 :][: len(results)] = results


@lru_cache(maxsize=1024)
def programs_of(key: tuple) -> list[ColumnProgram]:
    """Return the programs of a function, one for each branch on which it was called so far.

    It is the cache that keeps them: `repeated` appends to the list for a key, which starts empty.
    """
    return []


def repeated(
    key: tuple, function: Callable, values: np.ndarray, follow: Any = None
) -> np.ndarray | None:
    """Return the results of a function for columns, by the program of a branch, as `ColumnProgram`.

    Parameters
    ----------
    key
        Identifies the function, with all on which its operations depend but the numbers.
    function
        As for `ColumnProgram`. It is called if no program is known for the branch.
    values, follow
        As for its call. None is returned if the columns differ in their branch.
    """
    programs = programs_of(key)
    for program in programs:
        made = program(values, follow)
        if made is not None:
            return made
    if len(programs) == BRANCHES:
        return None
    program = ColumnProgram(function, values[:, 0])
    programs.append(program)
    return program(values, follow)

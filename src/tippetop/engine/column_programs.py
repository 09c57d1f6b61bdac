"""Functions of numbers, repeated for columns of numbers with 80 bits.

The function is recorded once, as a program of its operations: NumPy would take a microsecond for
each of them. Series of slow slides are computed so, and jumps with derivatives.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..mechanics.lines import Program
from ..mechanics.operand import leaves
from .loop import library


BRANCHES = 32
"""Most programs of a function."""


class ColumnProgram:
    """A function of numbers, some of which are common to all columns.

    Parameters
    ----------
    function
        function(common, *values) -> a list of numbers.
    common
        A record of numbers, like those of the calls.
    values
        Numbers of a column.
    """

    def __init__(self, function: Callable, common: Any, values: Sequence | np.ndarray):
        """Record the function; its results are the last lines.

        Raises TypeError or ValueError if an operation of the function has no line in a program.
        """
        program = Program(common, tuple(values))
        same, others = program.inputs
        results = function(same, *others)
        program.joined(results)
        self.code = np.ascontiguousarray(program.code())
        self.constants = np.array([*program.constants.values()])[:, None]
        self.results = len(results)

    def __call__(
        self, common: np.ndarray, values: np.ndarray, follow: Any = None
    ) -> np.ndarray | None:
        """Return the results, (results, n), of common numbers (k, 1) and columns (values, n).

        Return None if a comparison turns out otherwise than in the recorded call. The results of a
        motion, see `Program.call`, are follow(place, its inputs), an array (results, n): its inputs
        are all registers from `a` up to that of the motion. The results are the last registers.
        """
        inputs = len(common) + len(values)
        first = inputs + len(self.constants)
        n = values.shape[1]
        registers = np.empty((first + len(self.code), n), np.longdouble)
        registers[: len(common)] = common
        registers[len(common) : inputs] = values
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
    key: tuple, function: Callable, common: Any, values: np.ndarray, follow: Any = None
) -> np.ndarray | None:
    """Return the results of a function for columns, by the program of a branch, as `ColumnProgram`.

    Parameters
    ----------
    key
        Identifies the function, with all on which its operations depend but the numbers.
    function, common
        As for `ColumnProgram`. The function is called if no program is known for the branch.
    values, follow
        As for its call. None is returned if the columns differ in their branch.
    """
    numbers = np.array(leaves(common), np.longdouble)[:, None]
    programs = programs_of(key)
    for program in programs:
        made = program(numbers, values, follow)
        if made is not None:
            return made
    if len(programs) == BRANCHES:
        return None
    program = ColumnProgram(function, common, values[:, 0])
    programs.append(program)
    return program(numbers, values, follow)

"""Functions of numbers, repeated for columns of numbers with 80 bits.

The function is recorded once, as a program of its operations: NumPy would take a microsecond for
each of them.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..mechanics.lines import Program
from .loop import library


class ColumnProgram:
    """A function of numbers, some of which are common to all columns.

    Parameters
    ----------
    function
        function(common, *values) -> a list of numbers; its operations must not depend on
        comparisons.
    common
        A record of numbers, like those of the calls.
    values
        Numbers of a column.
    """

    def __init__(self, function: Callable, common: Any, values: Sequence):
        """Record the function."""
        program = Program(common, tuple(values))
        same, others = program.inputs
        results = function(same, *others)
        program.joined(results)
        self.code = np.ascontiguousarray(program.code())
        self.constants = np.array([*program.constants.values()])[:, None]
        self.results = len(results)

    def __call__(self, common: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the results, (results, n), of common numbers (k, 1) and columns (values, n)."""
        inputs = len(common) + len(values)
        first = inputs + len(self.constants)
        n = values.shape[1]
        registers = np.empty((first + len(self.code), n), np.longdouble)
        registers[: len(common)] = common
        registers[len(common) : inputs] = values
        registers[inputs:first] = self.constants
        places = self.code.ctypes.data, registers.ctypes.data
        library().loop_columns(len(self.code), first, n, *places)
        return registers[-self.results :]

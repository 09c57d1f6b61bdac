"""Functions that are repeated for columns of 80-bit numbers, against NumPy's evaluation."""

import numpy as np

from tippetop.engine.column_programs import ColumnProgram
from tippetop.mechanics.operand import Vector, atan2, cos, cross, exp, log, sin, sqrt


def values_of(common: Vector, x: np.ndarray, y: np.ndarray) -> list:
    """Return values of every operation that a program of columns has."""
    turned = cross(common, Vector(x, y, 1 / y))
    largest = np.maximum(np.absolute(x), -y)
    return [*turned, x - common.x, sqrt(y) ** 3, atan2(x, y), sin(x), cos(x), exp(x), log(largest)]


def test_a_repeated_function_has_the_values_of_numpy(rng: np.random.Generator) -> None:
    common = Vector(*rng.uniform(0.5, 2, 3).astype(np.longdouble))
    columns = rng.uniform(0.5, 2, (2, 7)).astype(np.longdouble)
    program = ColumnProgram(values_of, common, columns[:, 0])
    expected = np.array(values_of(common, *columns))
    assert np.array_equal(program(np.array(common)[:, None], columns), expected)

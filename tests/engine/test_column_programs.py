"""Functions that are repeated for columns of 80-bit numbers, against NumPy's evaluation."""

from typing import Any

import numpy as np

from tippetop.engine.column_programs import ColumnProgram
from tippetop.mechanics.operand import Vector, atan2, cos, cross, exp, log, sin, sqrt


def values_of(x: np.ndarray, y: np.ndarray) -> list:
    """Return values of every operation that a program of columns has."""
    turned = cross(Vector(y, 2 * x, x + y), Vector(x, y, 1 / y))
    largest = np.maximum(np.absolute(x), -y)
    return [*turned, x - y, sqrt(y) ** 3, atan2(x, y), sin(x), cos(x), exp(x), log(largest)]


def test_a_repeated_function_has_the_values_of_numpy(rng: np.random.Generator) -> None:
    columns = rng.uniform(0.5, 2, (2, 7)).astype(np.longdouble)
    program = ColumnProgram(values_of, columns[:, 0])
    assert np.array_equal(program(columns), np.array(values_of(*columns)))


def test_columns_that_compare_otherwise_than_the_recorded_ones_have_no_results() -> None:
    program = ColumnProgram(lambda x: [2 * x if x < 1 else x], [0.5])
    assert np.array_equal(program(np.array([[0.2, 0.7]])), [[0.4, 1.4]])
    assert program(np.array([[0.2, 1.5]])) is None


def test_a_motion_is_followed_where_a_program_calls_it() -> None:
    def function(x: Any) -> list:
        return [1 + y for y in x.program.call(3, lambda square: [square, -square], x * x)]

    program = ColumnProgram(function, [0.5])
    follow = lambda place, inputs: np.concatenate([place * inputs, inputs])  # noqa: E731
    assert np.array_equal(program(np.array([[2.0, 4.0]]), follow), [[13, 49], [5, 17]])

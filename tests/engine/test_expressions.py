"""The equations of motion in symbols: by the leaves of the body, and by what the user gives."""

from collections.abc import Callable
from typing import Any

import heyoka as hy
import numpy as np
import pytest

from tippetop.engine.expressions import equations_of_motion
from tippetop.problem import Problem
from tippetop.scenario import build, reading


def equations(problem: Problem, *, by_parameters: bool) -> list[tuple[Any, Any]]:
    law = type(problem.friction)
    return equations_of_motion(problem.system, problem.variables, law, by_parameters=by_parameters).rates


def compiled(expressions: list, symbols: list) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Their values by state and parameters."""
    function = hy.cfunc([hy.expression(0.0) + e for e in expressions], vars=symbols, opt_level=0)
    return lambda state, pars: function(state, pars=pars[: function.nparams])


@pytest.mark.parametrize("preset", [name for name in reading.presets() if build.load(name).contact is None])
def test_equations_by_what_the_user_gives_are_the_same_equations(preset: str) -> None:
    """They have the same rates at the start, to rounding, and the derivatives by a number are those of differences."""
    problem = build.load(preset)
    state, numbers = problem.start(), problem.alone.parameters[:, 0]
    symbols, rates = zip(*equations(problem, by_parameters=False), strict=True)
    folded = compiled(list(rates), list(symbols))(state, problem.alone.pars[:, 0])
    symbols, rates = (list(part) for part in zip(*equations(problem, by_parameters=True), strict=True))
    size = np.abs(folded).max()
    # what is folded is exactly 1 where the user's numbers are 1 to rounding
    values = compiled(rates, symbols)
    slopes = compiled([hy.diff(rate, hy.par[i]) for i in range(len(numbers)) for rate in rates], symbols)
    expected = slopes(state, numbers).reshape(len(numbers), -1)
    np.testing.assert_allclose(values(state, numbers), folded, rtol=1e-13, atol=1e-13 * size)
    for i, number in enumerate(numbers):
        h = 1e-6 * max(number, 1e-3)
        step = h * (np.arange(len(numbers)) == i)
        ahead, behind = (values(state, numbers + sign * step) for sign in (1, -1))
        np.testing.assert_allclose(
            (ahead - behind) / (2 * h), expected[i], rtol=1e-6, atol=1e-14 * size / h + 1e-6 * size
        )

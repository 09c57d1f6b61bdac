"""The rows of a step, many at once or one alone, have the same bits, however LLVM rounds the code
that gives one.
"""

import functools

import llvmlite.binding as llvm
import numpy as np
import pytest

from tippetop.engine import taylor
from tippetop.engine.integrator import compiled_from
from tippetop.engine.opt_level import OPT_LEVEL
from tippetop.runs import starting
from tippetop.runs.run import solve


@pytest.fixture(params=["0", "3"])
def fuses(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """As tests are compiled; as users have it, with fused products where the processor has them."""
    monkeypatch.setenv(OPT_LEVEL, request.param)
    monkeypatch.setattr(taylor, "compiled_from", functools.cache(compiled_from.__wrapped__))
    return request.param == "3" and llvm.get_host_cpu_features().get("fma", False)


@pytest.mark.parametrize("preset", ["inverting", "rolling-cylinder"])
def test_the_rows_of_a_step_have_the_bits_of_each_alone(fuses: bool, preset: str) -> None:
    """Of the inversion, eight numbers in 8500 had not: where what is left of a sum is 1e-8 of its
    terms.
    """
    times = np.linspace(0.0, 0.5, 501)
    problem = starting.load(preset, ["run.output_step=1e-3"], 0.5)
    driver = taylor.driver_of(problem)
    assert driver.workspace.compiled.machine.fused == fuses
    many = solve(problem)
    np.testing.assert_array_equal(many.times, times)
    for first in range(9):
        few = solve(starting.load(preset, [f"run.output_times={times[first::9].tolist()}"], 0.5))
        np.testing.assert_array_equal(few.rows, many.rows[first::9])

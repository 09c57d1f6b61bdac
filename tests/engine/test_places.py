"""A run works where another has worked: with the bits of a first run, and never where
one still is.
"""

import numpy as np
import pytest

from tippetop.engine.driver import PLACES, Driver
from tippetop.engine.taylor import driver_of
from tippetop.runs import starting
from tippetop.runs.run import solve


def made(until: float, *sets: str) -> Driver:
    return driver_of(starting.load("inverting", list(sets), until))


def test_drivers_that_live_share_nothing() -> None:
    """More of them than places are kept."""
    drivers = [made(0.1, f"initial.theta=0.{i + 1}") for i in range(PLACES + 2)]
    for i, one in enumerate(drivers):
        np.testing.assert_array_equal(one.state[: one.variables], one.first[0])
        for other in drivers[:i]:
            assert not np.shares_memory(one.motion.state, other.motion.state)
            assert not np.shares_memory(one.log.states, other.log.states)
            assert not np.shares_memory(one.rows.events, other.rows.events)


def test_a_run_has_the_bits_of_a_first_run_wherever_it_works() -> None:
    """After a longer one, with other events, that a liftoff ended: rows, events, report, and what a
    store keeps.
    """
    problem = starting.load("inverting", until=2.0)
    first = solve(problem)
    long = starting.load(
        "inverting", ["initial.omega3=300.0", "run.events=[]", "run.orientation=true"], until=8.0
    )
    assert solve(long).status.value == "liftoff"
    again = solve(problem)
    np.testing.assert_array_equal(again.rows, first.rows)
    np.testing.assert_array_equal(again.events.time, first.events.time)
    assert again.report == first.report
    assert repr(again.last_slice) == repr(first.last_slice)


def test_the_extremes_of_a_run_are_those_of_its_column() -> None:
    """Of the heavy top the impulse is written otherwise than the column `normal_force`: they are
    one number.
    """
    problem = starting.load("heavy-top", ["run.output_step=0.0005"], until=2.0)
    force = solve(problem, keep=False).report["normal_force"]
    column = solve(problem).columns()["normal_force"].values
    assert force["min"] == pytest.approx(column.min(), rel=1e-6)
    assert force["max"] == pytest.approx(column.max(), rel=1e-6)
    assert force["min"] <= column.min() + 1e-13
    assert force["max"] >= column.max() - 1e-13

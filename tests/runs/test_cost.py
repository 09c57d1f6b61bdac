"""The time that a run takes is inferred from its first slices, by the clock of the computer."""

import itertools
from collections.abc import Callable
from typing import Any

import pytest

from tippetop.runs import cost, starting
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve


STEP, COMPILING = 1e-4, 3.0  # [s]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[], float]:
    """A clock that every step moves by 0.1 ms, and the first slice, which compiles, by three
    seconds.
    """
    now, follow = [0.0], Integration.add_slice

    def counted(self: Integration, piece: Any) -> Any:
        now[0] += STEP * piece.steps + (COMPILING if now[0] == 0 else 0.0)
        return follow(self, piece)

    monkeypatch.setattr(Integration, "add_slice", counted)
    return lambda: now[0]


@pytest.mark.parametrize("until", [0.5, 8.0, 400.0])
def test_seconds_are_those_of_the_whole_run(until: float, clock: Callable[[], float]) -> None:
    """Of a long run only the beginning is made."""
    problem = starting.load("rolling", until=until)
    expected = cost.measured(problem, clock)
    assert clock() < COMPILING + 1.01 * STEP * cost.STEPS * (1 + cost.SLICES)
    steps = solve(problem, keep=False).report["steps"]
    assert expected["seconds"] == pytest.approx(STEP * steps, rel=0.1)
    assert expected["steps"] == pytest.approx(steps, rel=0.1)


def test_a_run_that_ends_early_is_not_taken_for_longer(clock: Callable[[], float]) -> None:
    problem = starting.load("inverting", ["initial.omega3=170"], until=1e6)
    steps = solve(problem, keep=False).report["steps"]
    assert cost.measured(problem, clock)["steps"] == steps


@pytest.mark.slow
def test_a_slow_computer_expects_as_many_steps_as_a_fast_one() -> None:
    """The steps of this top become shorter as friction stops its spin."""
    problem = starting.load("wooden-toy")
    slow, fast = (
        cost.measured(problem, map(step.__mul__, itertools.count()).__next__)
        for step in (100.0, 1e-9)
    )
    assert slow["steps"] == fast["steps"]
    assert slow["seconds"] > 1e9 * fast["seconds"]
    steps = solve(problem, keep=False).report["steps"]
    assert slow["steps"] == pytest.approx(steps, rel=0.5)


def test_many_rows_are_measured_in_short_slices() -> None:
    """A slice of 512 steps would make a hundred thousand rows; they are part of the time."""
    few, many = (
        cost.measured(starting.load("inverting", [f"run.output_step={step}"], until=8.0))
        for step in (1e-2, 1e-5)
    )
    assert many["seconds"] > 10 * few["seconds"]

"""What a run takes is inferred from its beginning, by the clock of the computer at hand."""

from types import SimpleNamespace
from typing import Any

import pytest

from tippetop.engine.status import Status
from tippetop.problem import Problem
from tippetop.runs import measuring
from tippetop.scenario import build


class Computer:
    """A clock, and runs that take 3 s to compile, 0.01 s to begin and 1 ms a step, of 100 steps a second."""

    def __init__(self, ends_at: float = 1e9, meets: float = 1e9):
        self.now, self.compiled, self.ends_at, self.longest, self.meets = 0.0, False, ends_at, 0.0, meets

    def clock(self) -> float:
        return self.now

    def solve(self, problem: Problem, watch: Any) -> Any:
        self.now += 0.01 + (0 if self.compiled else 3.0)
        self.compiled = True
        end = min(problem.until, self.ends_at)
        self.longest = max(self.longest, end)
        for part in range(11):
            watch(SimpleNamespace(t_end=end * part / 10, steps=10 * end * part))
            self.now += 10 * end * 1e-3 if part < 10 else 0
            if end * part / 10 >= self.meets:  # what is compiled only there
                self.now, self.meets = self.now + 4.0, 1e9
        status = Status.LIFTOFF if self.ends_at < problem.until else Status.FINISHED
        return SimpleNamespace(status=status, report={"steps": 100 * end}, columns=dict)


@pytest.mark.parametrize("guess", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("until", [0.5, 100.0, 1e6])
def test_seconds_are_those_of_the_whole_run(monkeypatch: pytest.MonkeyPatch, until: float, guess: float) -> None:
    """Whatever was thought of it before; and little of a long one is made."""
    computer = Computer()
    monkeypatch.setattr(measuring, "solve", computer.solve)
    expected = measuring.measured(build.load("inverting", until=until), guess, computer.clock)
    assert expected["seconds"] == pytest.approx(0.01 + 0.1 * until, rel=0.05)
    if guess > 1:  # else the first piece is the whole run, and is broken off
        assert expected["compiling"] == pytest.approx(3.0, abs=0.1)
    if "steps" in expected:
        assert expected["steps"] == pytest.approx(100 * until, rel=0.01)
    assert computer.now < 10 or guess == 1.0


def test_steps_that_grow_in_number_are_those_foretold(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction that drills: the beginning, of 100 steps a second, says what one takes."""
    computer = Computer()
    monkeypatch.setattr(measuring, "solve", computer.solve)
    monkeypatch.setattr(measuring, "driver_of", lambda problem: SimpleNamespace(prepare=lambda: None))
    expected = measuring.measured(build.load("leine-glocker-drilling", until=100.0), 5e4, computer.clock)
    assert expected["steps"] == 50000
    assert expected["seconds"] == pytest.approx(50, rel=0.05)


def test_a_run_that_ends_early_is_not_taken_for_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    computer = Computer(ends_at=1.5)
    monkeypatch.setattr(measuring, "solve", computer.solve)
    expected = measuring.measured(build.load("inverting", until=1e4), 1e6, computer.clock)
    assert expected["steps"] == 150
    assert expected["seconds"] == pytest.approx(0.16, rel=0.05)


def test_what_is_compiled_on_the_way_is_no_time_of_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of two hundred tenths of a second takes 4 s, for another phase begins."""
    computer = Computer(meets=0.1)
    monkeypatch.setattr(measuring, "solve", computer.solve)
    expected = measuring.measured(build.load("inverting", until=20.0), 2000, computer.clock)
    assert expected["seconds"] == pytest.approx(2.01, rel=0.05)


def test_real_steps() -> None:
    """By the counter of the integrator, of a run so short that it is made whole."""
    problem = build.load("rolling", until=2.0)
    assert measuring.measured(problem, 100.0)["steps"] == measuring.solve(problem).report["steps"]

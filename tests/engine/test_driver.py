"""The driver makes heyoka's own steps, bit by bit: every system and form, and rows on the way."""

import copy
import dataclasses
from typing import Any

import numpy as np
import pytest

from tippetop.engine.driver import Driver
from tippetop.engine.status import Status
from tippetop.engine.taylor import driver_of
from tippetop.mechanics.systems import SYSTEMS
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve
from tippetop.runs.sinks import Memory
from tippetop.scenario import reading


ENDLESS = 1 << 40


def cases() -> list[tuple[str, str]]:
    """Every preset in the form that it asks for, and one preset of every system in all forms."""
    found: dict[tuple[str, str], None] = {}
    seen = set()
    for preset in reading.presets():
        made = starting.load(preset)
        if made.contact is not None:  # several problems, one a phase: `tests/engine/contact`
            continue
        forms = made.system.forms if made.system.name not in seen else [made.form.name]
        seen.add(made.system.name)
        found |= {(preset, form): None for form in forms}
    assert seen == set(SYSTEMS)
    return list(found)


def problem(preset: str, form: str, until: float, *sets: str) -> Problem:
    """A run that no event ends."""
    return starting.load(preset, [f"form={form}", "run.on_liftoff=continue", *sets], until)


class Rows:
    """A request: rows at given internal times, or at the ends of steps."""

    def __init__(self, times: np.ndarray | None = None, room: int = 1 << 16):
        self.rows_at_steps, self.left, self.room = times is None, times, room
        self.times: list[np.ndarray] = []
        self.states: list[np.ndarray] = []

    def next_times(self) -> np.ndarray:
        if self.left is None:
            return np.empty(self.room)
        now, self.left = self.left[: self.room], self.left[self.room :]
        return now

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        self.times.append(np.array(times, copy=True))
        self.states.append(np.array(states, copy=True))

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        return np.concatenate(self.times), np.concatenate(self.states)


def heyokas(driver: Driver) -> Any:
    """heyoka's integrator at the start of a driver, with its parameters."""
    made = copy.deepcopy(driver.workspace.compiled.integrator)
    made.pars[:] = driver.motion.pars[:, 0]  # type: ignore[attr-defined]
    made.state[:] = driver.state
    return made


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()


@pytest.mark.parametrize(("preset", "form"), cases())
def test_steps_and_rows_are_heyokas_bit_by_bit(
    preset: str, form: str, rng: np.random.Generator
) -> None:
    """Ends of steps, the double length of the time, and rows anywhere, however few are asked for at
    a time.
    """
    made = problem(preset, form, 0.4)
    driver = driver_of(made)
    theirs = heyokas(driver)
    *_, output, _ = theirs.propagate_until(driver.end, c_output=True)
    ends, n = np.concatenate([output.tcs[1:, :, 0], theirs.state[None, :]]), driver.variables
    piece = driver.advance(steps := Rows(), ENDLESS)
    times, states = steps.rows
    assert (piece.status, piece.steps) == (Status.FINISHED, len(ends))
    assert same_bits(times, output.times[1:])
    assert same_bits(states, ends[:, :n])
    assert same_bits(driver.state, theirs.state)
    assert driver.clock == theirs.dtime
    in_one_step = rng.uniform(*output.times[5:7], 19)
    asked = np.sort(
        np.concatenate([rng.uniform(0, driver.end, 200), in_one_step, output.times[[0, 3, -1]]])
    )
    expected = np.array(output(asked))[:, :n]
    between = (
        asked != output.times[3]
    )  # there heyoka has the end of a polynomial, and we the start of the next
    for room in (1 << 16, 7):
        driver = driver_of(made)
        piece = driver.advance(rows := Rows(asked, room), ENDLESS)
        times, states = rows.rows
        assert piece.status is Status.FINISHED
        assert same_bits(times, asked)
        assert same_bits(states[between], expected[between])
        np.testing.assert_allclose(states, expected, rtol=4e-15, atol=4e-15)


# --- what a run leaves alone --------------------------------------------------------------------


@pytest.mark.parametrize("end", ["finished", "liftoff", "non-finite"])
def test_rows_at_steps_are_each_there_once(end: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The end of the run has one row too, whatever ended it."""
    made = starting.load(
        "inverting", [f"initial.omega3={170.0 if end == 'liftoff' else 155.0}"], 6.0
    )
    made = dataclasses.replace(made, output="steps")
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 100)
    integration, memory = Integration(made), Memory()
    of_body = integration.driver.motion.pars

    def spoil(_: object) -> None:
        of_body[3] = np.nan

    integration.run(memory, spoil if end == "non-finite" else None)
    times = np.concatenate(memory.times)
    assert integration.status is Status(end)
    assert np.all(np.diff(times) > 0)
    assert (times[0], times[-1]) == (0.0, integration.t_end)
    assert len(times) == integration.steps_made + 1


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

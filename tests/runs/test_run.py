"""The engine: what must not change a run does not, every end has its name, and accuracy is what is
promised.
"""

import dataclasses
import functools
import time
from typing import Any

import numpy as np
import pytest
from nightly import at_night

import tippetop as tt
from tippetop.engine import taylor
from tippetop.engine.integrator import compiled_from
from tippetop.engine.status import Status
from tippetop.engine.taylor import driver_of
from tippetop.problem import Problem
from tippetop.runs import integration, starting
from tippetop.runs.run import solve


def load(*assignments: str, until: float = 2.0, **changes: object) -> Problem:
    return dataclasses.replace(starting.load("inverting", list(assignments), until), **changes)


def test_time_of_compilation_is_not_that_of_integration(monkeypatch: pytest.MonkeyPatch) -> None:
    """A phase is compiled when it is first entered, in the middle of a run."""

    @functools.cache
    def slowly(*key: Any) -> Any:
        time.sleep(0.3)
        return compiled_from(*key)

    monkeypatch.setattr(taylor, "compiled_from", slowly)
    run = tt.run("cohen-coulomb", until=0.03)
    assert len(run.phases.start) == 2
    seconds = run.solution.seconds
    assert seconds["compile"] > 0.6
    assert seconds["integrate"] < 0.3


def test_neither_rows_nor_events_change_the_run() -> None:
    """Bits of the end and steps are equal for 2 rows, 10^5 rows, rows at odd times, and without
    events; events too.
    """
    plain = solve(load(until=6.5, times=np.array([0.0, 6.5])))
    without = solve(load("run.events=[]", until=6.5, times=np.array([0.0])))
    assert without.final.tobytes() == plain.final.tobytes()
    assert without.report["steps"] == plain.report["steps"]
    assert len(without.events.time) == 0 < len(plain.events.time)
    for times in (
        np.linspace(0, 6.5, 100_001),
        np.sort(np.random.default_rng(1).uniform(0, 6.5, 77)),
    ):
        other = solve(load(until=6.5, times=times))
        assert other.final.tobytes() == plain.final.tobytes()
        assert other.report["steps"] == plain.report["steps"]
        columns = zip(*(run.events.values() for run in (other, plain)), strict=True)
        assert all(a.values.tobytes() == b.values.tobytes() for a, b in columns)
    rows = solve(load(until=6.5, times=np.linspace(0, 6.5, 100_001))).rows
    np.testing.assert_array_equal(rows[-1], plain.rows[-1])


def test_integrals_never_control_the_step() -> None:
    """The place of the top may be a kilometre away: steps and motion are the same to the bit."""
    here, there = solve(load()), solve(load("initial.x=1000.0", "initial.y=-2000.0"))
    names = here.problem.variables.names
    moved = [names.index("x"), names.index("y")]
    assert here.report["steps"] == there.report["steps"]
    assert (
        np.delete(here.rows, moved, axis=1).tobytes()
        == np.delete(there.rows, moved, axis=1).tobytes()
    )


def test_the_first_liftoff_is_the_first_zero_of_the_force() -> None:
    """A run that continues tells the same moment; rows of it, close together, see the force fall
    below zero there.
    """
    ended = solve(load("initial.omega3=170.0", until=10.0)).report["t_end"]
    beyond = load("initial.omega3=170.0", "run.on_liftoff=continue", until=ended + 0.5)
    near = ended + np.array([-1e-9, 1e-9])
    run = solve(
        dataclasses.replace(
            beyond, times=np.concatenate([np.linspace(0.0, ended - 1e-6, 50_001), near])
        )
    )
    force = run.columns()["normal_force"].values
    assert "outside the model since the liftoff" in run.reason
    assert run.events.of("liftoff").time[0] == ended
    assert np.all(force[:-1] > 0)
    assert force[-1] < 0


def test_a_stiff_law_is_named_and_the_last_state_kept() -> None:
    run = solve(load("friction.mu=1e12", "initial.theta=0.0", "initial.nu_y=0.1"))
    assert run.status is Status.STALLED
    assert "too stiff" in run.reason
    assert np.all(np.isfinite(run.final))


def test_a_state_that_turns_non_finite_keeps_the_last_good_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = load("form=euler", until=0.3)
    driver = driver_of(problem)
    driver.motion.pars[3] = np.nan  # type: ignore[attr-defined]  # what a broken parameter would do, past the checks
    monkeypatch.setattr(integration, "driver_of", lambda *_: driver)
    run = solve(problem)
    assert run.status is Status.NON_FINITE
    assert "not finite" in run.reason
    assert np.all(np.isfinite(run.final))
    assert np.all(np.isfinite(run.rows))


def test_the_length_of_an_integrated_axis_is_watched() -> None:
    """Every form that integrates the components of 3hat promises |3hat| = 1."""
    made = solve(starting.load("gliding-heavy-top", [], 1.0))
    assert 0 <= made.report["drift"]["axis_norm"] < 1e-13
    axis = made.rows[
        :, [made.problem.form.units._fields.index(name) for name in ("ux", "uy", "uz")]
    ]
    assert (
        made.report["drift"]["axis_norm"] >= np.abs(np.linalg.norm(axis, axis=1) - 1).max() - 1e-14
    )


@pytest.mark.parametrize("until", [1e12, 1e15, at_night(1e16)])
@pytest.mark.parametrize("law", ["viscous", "coulomb"])
def test_a_body_at_rest_stays_for_as_long_as_a_run_may_last(law: str, until: float) -> None:
    """Its series allows any step, the powers of which a double may not contain."""
    sets = ["initial.theta=0", "initial.omega3=0", f"friction.law={law}", "friction.mu=0.3"]
    problem = starting.load("inverting", [*sets, "run.output=events"], until)
    run = solve(problem, keep=False)
    assert run.status is Status.FINISHED
    assert run.report["t_end"] == until
    assert run.report["theta_end"] == 0.0

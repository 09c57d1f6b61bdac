"""Tops in lanes have the rows at given times that they have alone, between their changes too."""

from dataclasses import replace

import numpy as np
import pytest
from test_hybrid_lanes import CASES, TOPS, assert_column, few_lanes, some

from tippetop.engine.observables import Observables
from tippetop.ensembles import ensemble
from tippetop.ensembles.hybrid_tops import problem_of
from tippetop.ensembles.rows_at_times import rows_at_times
from tippetop.mechanics.contact.contact_phases import PHASES
from tippetop.problem import Problems
from tippetop.runs.integration import Integration
from tippetop.runs.sinks import Memory
from tippetop.sampling import ListedTimes
from tippetop.scenario import build, reading


NAMES = "theta", "axis", "omega3", "x"


def rows_alone(tops: Problems, top: int, times: np.ndarray) -> dict[str, np.ndarray]:
    problem = replace(problem_of(tops, top), until=times[-1], times=ListedTimes(times))
    memory = Memory()
    Integration(problem).run(memory)
    columns = Observables(problem).columns(times, np.concatenate(memory.states))
    return {name: columns[name].values for name in NAMES if name in columns}


def smooth(**columns: np.ndarray) -> Problems:
    base = build.problem(reading.read("inverting"))
    return ensemble.vary(base, columns or {"initial.omega3": np.linspace(150.0, 160.0, 12)})


def tops_of(case: str) -> tuple[Problems, float]:
    return (smooth(), 1.0) if case == "inverts" else (some(case), TOPS[case][2])


@pytest.mark.parametrize("case", ["inverts", *CASES])
def test_rows_in_lanes_are_those_of_single_runs(case: str) -> None:
    """They fall into steps, and into jumps that take time."""
    tops, until = tops_of(case)
    times = np.linspace(0.0, until, 1001)
    found = rows_at_times(tops, times, NAMES, threads=1)
    for top in (0, 7):
        for name, values in rows_alone(tops, top, times).items():
            assert_column(found[name][top], values)


@pytest.mark.parametrize("case", ["inverts", *CASES])
def test_the_bits_of_rows_do_not_depend_on_other_tops(monkeypatch, case: str) -> None:
    tops, until = tops_of(case)
    times = np.linspace(0.0, until, 101)
    found = rows_at_times(tops, times, NAMES, threads=2)
    few_lanes(monkeypatch)
    again = rows_at_times(tops, times, NAMES, threads=1)
    for name, values in found.items():
        np.testing.assert_array_equal(values, again[name], name)


def test_a_row_at_a_change_of_phase_is_that_before_the_jump() -> None:
    """At the first liftoff, whose time the ensemble has, and at the next double."""
    tops = some("hops")
    liftoff = ensemble.measure(tops, threads=1).columns["lifted_at"]
    times = np.stack([liftoff, np.nextafter(liftoff, np.inf), liftoff + 0.001], axis=1)
    phases = rows_at_times(tops, times, ["phase"], threads=1)["phase"]
    assert [PHASES[int(k)] for k in phases[0, :2]] == ["slip", "flight"]
    assert (phases[:, :2] == phases[0, :2]).all()


@pytest.mark.parametrize("case", ["inverts", "hops"])
def test_there_are_no_rows_before_the_start(case: str) -> None:
    """Each top has other times; the first row of a run is its start."""
    tops, until = tops_of(case)
    times = np.linspace(-0.1, until, 50) + np.linspace(0.0, 0.09, tops.n)[:, None]
    times[:, 20] = times[:, 19]  # twice
    times[::2, 5] = 0.0
    times.sort(axis=1)
    found = rows_at_times(tops, times, ["theta"])
    np.testing.assert_array_equal(np.isnan(found["theta"]), times < 0)
    starts = found["theta"][times == 0]
    np.testing.assert_allclose(starts, tops.base.initial["theta"], rtol=1e-14)


@pytest.mark.parametrize("scenario", ["flying", "inverting"])
def test_a_top_has_no_rows_after_its_end(scenario: str) -> None:
    """One lifts off, one goes on, one is invalid, and one begins without a contact force."""
    run = {"until": 6.0, "on_liftoff": "stop", "output_step": 1.0}
    base = build.problem(reading.read(scenario) | {"run": run})
    spins = np.array([300.0, 100.0, 100.0, 100.0])
    rates = np.array([0.0, 0.0, 0.0, 200.0])
    mu = np.array([0.3, 0.3, -1.0, 0.3])
    tops = ensemble.vary(
        base, {"friction.mu": mu, "initial.omega3": spins, "initial.theta_dot": rates}
    )
    times = np.linspace(0.0, 6.0, 201)
    measured = ensemble.measure(tops, threads=1)
    found = rows_at_times(tops, times, ["theta"])
    ends = np.where(tops.valid, np.nan_to_num(measured.columns["t_end"]), -1.0)
    assert 0 < ends[0] < 6
    assert ends[1] == 6
    np.testing.assert_array_equal(np.isfinite(found["theta"]), times <= ends[:, None])

"""Asymptotic states, the least energy of a lambda, the general system, rates as columns, and theta
made again.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from examples import CANONICAL
from typed import answered, reported, typed

import tippetop as tt


TOP = tt.TippeTop(**CANONICAL | {"I1": 2.4e-6})  # gamma = 0.75 < gamma_plus
LAM = 2.6e-6


def test_asymptotic_states_are_the_critical_points_of_the_least_energy() -> None:
    """Stable ones are minima; each has the lambda that was asked for, and its sign."""
    states = tt.theory.asymptotic_states(TOP, LAM)
    assert [s.kind for s in states] == ["upright", "tumbling", "tumbling", "inverted"]
    assert [s.stable for s in states] == [True, False, True, False]
    theta = np.linspace(0, math.pi, 20001)
    energy = tt.theory.least_energy(TOP, theta, LAM)
    inside = np.flatnonzero(np.diff(np.sign(np.diff(energy))) != 0) + 1
    np.testing.assert_allclose(theta[inside], [s.theta for s in states[1:3]], atol=2e-4)
    np.testing.assert_allclose(energy[inside], [s.energy for s in states[1:3]], rtol=1e-8)
    mirrored = tt.theory.asymptotic_states(TOP, -LAM)
    for one, other in zip(states, mirrored, strict=True):
        start = {"theta": one.theta, "phi_dot": one.phi_dot, "omega3": one.omega3}
        problem = tt.run(
            TOP, tt.friction.Viscous(mu=0.3), start=start, until=1e-3, output_times=[0.0, 1e-3]
        )
        assert float(problem.trajectory.jellett[0]) == pytest.approx(LAM, rel=1e-12)
        assert float(problem.trajectory.energy[0]) == pytest.approx(one.energy, rel=1e-12)
        assert (one.theta, one.omega3, one.phi_dot) == (other.theta, -other.omega3, -other.phi_dot)
    assert tt.theory.asymptotic_states(TOP, 0.0)[0].omega3 == 0


def test_no_state_has_less_energy_than_the_least() -> None:
    run = tt.run("inverting", until=0.5, output_step=0.01, columns=["theta", "energy", "jellett"])
    rows = run.trajectory
    assert np.all(rows.energy > tt.theory.least_energy(run, rows.theta, rows.jellett))


@pytest.mark.parametrize(
    ("source", "start", "pairs"),
    [
        (
            "inverting",
            {"theta": 0.8},
            (("routh", "routh_rate"), ("modified_energy", "modified_energy_rate")),
        ),
        ("gliding-heavy-top", {}, (("Lz", "Lz_rate"), ("modified_energy", "modified_energy_rate"))),
    ],
)
def test_rates_are_columns_when_a_run_asks_for_them(source: str, start: dict, pairs: tuple) -> None:
    columns = ["theta", *(name for pair in pairs for name in pair)]
    rows = tt.run(source, start=start, until=0.1, output_step=1e-4, columns=columns).trajectory
    for name, its_rate in pairs:
        assert rows[its_rate].attrs["units"] in ("kg m2 s-2", "W")
        difference = (
            np.gradient(rows[name].values, rows.time.values)[1:-1] - rows[its_rate].values[1:-1]
        )
        assert abs(difference).max() < 1e-3 * abs(rows[its_rate].values).max()


def test_thresholds_of_the_surface_stand_beside_the_others() -> None:
    limits = tt.theory.thresholds("inverting")
    assert limits["lambda_pi"].value == pytest.approx(1.70683e-6, rel=1e-5)  #
    assert limits["gamma_star"].value == pytest.approx(2.1213, abs=1e-4)


@pytest.mark.slow
def test_theta_is_made_again_by_a_command(tmp_path: Path) -> None:
    store = tmp_path / "r.zarr"
    tt.run("inverting", start={"theta": 0.8}, until=0.3, output_step=1e-4, out=store)
    report = reported(f"reconstruct {store}")
    assert report["difference"] < 1e-9 > report["mismatch"]
    assert report["turnings"] > 10
    assert report["rows"] <= report["rows_of_run"]
    assert "difference" in answered("reconstruct", store)[1]
    assert typed(f"reconstruct {store} --period -1") == 2
    assert typed(f"reconstruct {tmp_path}/no.zarr") == 5
    tt.run("gliding-cylinder", until=0.01, out=tmp_path / "c.zarr")
    _, _, message = answered("reconstruct", tmp_path / "c.zarr", codes=[2])
    assert "tippe top or a heavy top" in message

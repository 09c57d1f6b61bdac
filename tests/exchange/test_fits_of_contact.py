"""Fits where the contact changes its phase, under laws that have no derivatives along a run."""

from pathlib import Path

import numpy as np
import pytest

import tippetop as tt


NOISE = np.deg2rad(0.3)
FILMS: dict[str, tuple[str, list[str], float, dict[str, float]]] = {
    "slides and sticks": (
        "inverting",
        ["friction.law=coulomb", "initial.centre_at_rest=true", "initial.theta=0.5"],
        0.5,
        {"friction.mu": 0.2, "initial.omega3": 155.0},
    ),
    "drills": (
        "inverting",
        ["friction.law=contensou", "friction.patch=2e-4", "friction.mu_r=0", "initial.theta=0.5"],
        0.4,
        {"friction.mu": 0.2, "initial.omega3": 155.0},
    ),
    "has parts": (
        "inverting",
        ["friction.mu_d=1e-4", "friction.mu_r=0", "initial.theta=0.5"],
        0.5,
        {"friction.mu_d": 1e-4, "initial.omega3": 155.0},
    ),
    "hops": (
        "flying",
        ["initial.gap=2e-3"],
        0.3,
        {"initial.omega3": 155.0, "contact.e_n": 0.5},
    ),
}


def film(path: Path, preset: str, changes: list[str], until: float) -> Path:
    """Write theta and the spin of a run with noise, forty times a second or more."""
    t = np.linspace(0, until, 61)
    rows = tt.run(tt.load(preset, [*changes, f"run.output_times={t.tolist()}"], until)).trajectory
    random = np.random.default_rng(5)
    table = [t, rows.theta + NOISE * random.standard_normal(61)]
    table.append(rows.omega3 + 0.5 * random.standard_normal(61))
    header = "t [s],theta [rad],omega3 [rad/s]"
    np.savetxt(path, np.column_stack(table), delimiter=",", header=header, comments="")
    return path


@pytest.mark.parametrize("name", FILMS)
def test_numbers_of_contacts_are_recovered(name: str, tmp_path: Path) -> None:
    preset, changes, until, true = FILMS[name]
    for key in list(true):
        changes = [*changes, f"{key}={true[key]}"]
    path = film(tmp_path / "film.csv", preset, changes, until)
    near = tt.load(preset, [*changes, *(f"{key}={1.02 * value}" for key, value in true.items())])
    found = tt.fit(path, near, list(true), noise=NOISE, within=0.05, starts=1)
    for key, value in true.items():
        estimate = found.estimates[key]
        assert abs(estimate.value - value) < 4 * estimate.sigma
        assert estimate.sigma < 0.5 * (value or 1)

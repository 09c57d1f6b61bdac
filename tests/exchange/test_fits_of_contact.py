"""Fits where the contact changes its phase, under laws that have no derivatives along a run."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measured import written
from nightly import at_night

import tippetop as tt
from tippetop.exchange.fitting import correlation_time


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
    table = {"t [s]": t, "theta [rad]": rows.theta + NOISE * random.standard_normal(61)}
    table["omega3 [rad/s]"] = rows.omega3 + 0.5 * random.standard_normal(61)
    return written(path, table)


@pytest.mark.parametrize(
    "name", ["has parts", *map(at_night, ("slides and sticks", "drills", "hops"))]
)
def test_numbers_of_contacts_are_recovered(name: str, tmp_path: Path) -> None:
    preset, changes, until, true = FILMS[name]
    for key in list(true):
        changes = [*changes, f"{key}={true[key]}"]
    path = film(tmp_path / "film.csv", preset, changes, until)
    near = tt.load(preset, [*changes, *(f"{key}={1.01 * value}" for key, value in true.items())])
    found = tt.fit(path, near, list(true), noise=NOISE, within=0.02, starts=1, systematic=False)
    for key, value in true.items():
        estimate = found.estimates[key]
        assert abs(estimate.value - value) < 4 * estimate.sigma
        assert estimate.sigma < 0.5 * (value or 1)


def test_a_tilted_table_moves_a_fit_as_its_systematic_error_predicts(tmp_path: Path) -> None:
    """The film of a table tilted by a hundredth of 0.1 degrees, fitted as if it were level."""
    start = ["initial.centre_at_rest=true", "initial.theta=0.3"]
    t = np.linspace(0, 0.5, 31)
    free = ["friction.mu", "initial.omega3", "initial.theta"]

    def fitted(tilt: float, azimuth: float, **how: bool) -> Any:
        around = [f"plane.tilt={tilt}", f"plane.azimuth={azimuth}"]
        rows = tt.run(
            tt.load("inverting", [*start, *around, f"run.output_times={t.tolist()}"], t[-1])
        ).trajectory
        path = written(tmp_path / "film.csv", {"t [s]": t, "theta [rad]": rows.theta})
        return tt.fit(path, tt.load("inverting", start), free, starts=1, within=0.01, **how)

    tilt = np.deg2rad(0.001)
    still = fitted(0.0, 0.0)
    found = [fitted(tilt, azimuth, systematic=False) for azimuth in (0.0, np.pi / 2)]
    (name,) = (name for name in still.influences if "tilted" in name)
    for key in free:
        moved = [f.estimates[key].value - still.estimates[key].value for f in found]
        expected = still.influences[name][key] / 100
        assert np.hypot(*moved) == pytest.approx(expected, rel=0.02)
    assert "a table tilted by 0.1 degrees would move" in still.reason
    assert not still.trustworthy


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "words"),
    [
        (2, "the residuals are like those of the drag of still air"),
        (0, "other numbers fit nearly as well, if the scenario lacks something"),
    ],
)
def test_a_film_of_a_top_in_air_is_not_explained_without_it(
    seed: int, words: str, tmp_path: Path
) -> None:
    """Drag that shifts the nutation by a period: the best numbers without it are in another one."""
    start = ["initial.centre_at_rest=true", "initial.theta=0.35", "friction.mu=0.205"]
    t = np.arange(0, 3, 1 / 30)
    blown = ["air.c1=3.8e-8", "air.c2=0", "initial.theta=0.353", "friction.mu=0.204"]
    run = tt.load("inverting", [*start[:1], *blown, f"run.output_times={t.tolist()}"], t[-1])
    noise = np.deg2rad(1)
    theta = tt.run(run).trajectory.theta + noise * np.random.default_rng(seed).standard_normal(90)
    path = written(tmp_path / "film.csv", {"t [s]": t, "theta [rad]": theta})
    free = ["friction.mu", "initial.omega3", "initial.theta", "parameters.I1"]
    found = tt.fit(path, tt.load("inverting", start), free, noise=noise, within=0.1)
    assert found.converged
    assert not found.trustworthy
    assert words in found.reason


def test_intervals_widen_with_correlations_and_are_withheld_of_a_wrong_model(
    tmp_path: Path,
) -> None:
    """Noise of an autoregressive process of coefficient rho has a time of (1 + rho)/(1 - rho)."""
    random = np.random.default_rng(2)
    white = random.standard_normal(20_001)
    slow = np.zeros(20_001)
    for k in range(1, len(slow)):
        slow[k] = 0.6 * slow[k - 1] + white[k]
    assert correlation_time({"theta": slow[:, None]}) == pytest.approx(1.6 / 0.4, rel=0.1)
    assert correlation_time({"theta": white[:, None]}) < 1.05
    path = film(tmp_path / "film.csv", "inverting", ["initial.theta=0.5"], 0.5)
    wrong = tt.load("inverting", ["initial.theta=0.7"])
    found = tt.fit(path, wrong, ["friction.mu"], starts=1, within=0.05, systematic=False)
    assert "the residuals are not noise" in found.reason
    assert np.isnan(found.estimates["friction.mu"].low)
    assert "no interval" in str(found)
    assert "+-" not in str(found)


def test_searches_of_a_hopeless_model_end_early(tmp_path: Path) -> None:
    """The film of a top that gets up, fitted by one that hardly has friction: few searches."""
    seen = film(tmp_path / "both.csv", "inverting", ["initial.theta=0.5"], 3.0)
    path = tmp_path / "film.csv"
    path.write_text("\n".join(row.rpartition(",")[0] for row in seen.read_text().splitlines()))
    wrong = tt.load("inverting", ["initial.theta=0.5", "friction.mu=0.001"])
    free = ["initial.omega3", "initial.theta"]
    found = tt.fit(path, wrong, free, noise=NOISE, within=0.1, systematic=False)
    assert re.search(r"\b[3-5] independent searches found nothing near enough", found.reason)
    assert not found.trustworthy
    assert not found.converged
    assert abs(found.estimates["initial.theta"].value - 0.5) < 0.05


@pytest.mark.slow
def test_laws_are_compared_by_likelihood(tmp_path: Path) -> None:
    """A short film cannot decide; the sharp law of a long slide is told from a viscous one."""
    start = ["initial.centre_at_rest=true", "initial.theta=0.5"]
    path = film(
        tmp_path / "film.csv", "inverting", [*start, "friction.law=coulomb", "friction.mu=0.2"], 0.4
    )
    found = tt.fit(
        path,
        tt.load("inverting", [*start, "friction.mu=0.5"]),
        ["friction.mu", "initial.omega3"],
        laws=["viscous", "coulomb"],
        starts=1,
        systematic=False,
    )
    assert set(found.laws) == {"viscous", "coulomb"}
    assert "the film decides for coulomb" in found.reason
    assert "viscous by at most" in found.reason
    assert found.problem.law.key == "coulomb"
    mu = found.estimates["friction.mu"]
    assert abs(mu.value - 0.2) < 4 * mu.sigma


def test_a_tilt_and_its_azimuth_are_found_from_a_level_plane(tmp_path: Path) -> None:
    t = np.linspace(0, 0.3, 8)
    plane = {"tilt": 0.01, "azimuth": 2.5}
    rows = tt.run("inverting", plane=plane, until=0.3, output_times=t.tolist()).trajectory
    random = np.random.default_rng(5)
    place = {f"{n} [m]": rows[n] + 1e-4 * random.standard_normal(len(t)) for n in ("x", "y")}
    written(tmp_path / "f.csv", {"t [s]": t} | place)
    free = ["plane.tilt", "plane.azimuth"]
    level, how = tt.load("inverting", ["plane.tilt=0"]), {"within": 0.05, "systematic": False}
    fit = tt.fit(tmp_path / "f.csv", level, free, starts=1, **how)
    for key in free:
        found = fit.estimates[key]
        assert abs(found.value - plane[key.partition(".")[2]]) < 4 * found.sigma

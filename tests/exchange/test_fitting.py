"""Fits: exact Jacobians, numbers that are recovered with honest errors, and what cannot be fitted,
in sentences.
"""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from measured import AXIS, written
from nightly import at_night
from typed import reported, typed

import tippetop as tt
from tippetop.exchange.misfit import Misfit
from tippetop.exchange.motion import turned
from tippetop.exchange.observation import Observation
from tippetop.exchange.search import Minimum, merge
from tippetop.library.exchanging import Fitted


TRUE = {"friction.mu": 0.3, "initial.omega3": 155.0, "initial.theta": 0.5}


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The axis of the canonical top for 0.4 s: 40 rows, 0.3 degrees of noise, a fifth of them
    gone.
    """
    random, t = np.random.default_rng(8), np.arange(0, 0.4, 0.01)
    run = tt.run("inverting", start={"theta": 0.5}, until=t[-1], output_times=t)
    axis = run.trajectory.axis.values
    seen = axis + np.cross(np.deg2rad(0.3) * random.standard_normal(axis.shape), axis)
    seen /= np.linalg.norm(seen, axis=1)[:, None]
    keep = random.random(len(t)) > 0.2
    path = tmp_path_factory.mktemp("film") / "film.csv"
    return written(path, {"t [s]": t[keep], AXIS: seen[keep]})


NEAR = ["friction.mu=0.33", "initial.omega3=160.0", "initial.theta=0.48"]


def fitted(film: Path, changes: list[str] = NEAR, free: Any = TRUE, **how: Any) -> Fitted:
    """Fit numbers of the canonical top by one search, from changed numbers."""
    how = {"starts": 1, "systematic": False, "within": 0.12} | how
    return tt.fit(film, tt.load("inverting", changes), list(free), **how)


@pytest.fixture(scope="module")
def fit(film: Path) -> Fitted:
    return fitted(film, starts=3)


def test_numbers_are_recovered_within_their_errors(fit: Fitted) -> None:
    assert fit.reason == "the numbers fit: the residuals are noise."
    assert fit.converged
    assert fit.trustworthy
    for name, true in TRUE.items():
        estimate = fit.estimates[name]
        assert abs(estimate.value - true) < 4 * estimate.sigma
        assert estimate.sigma < 0.1 * true
        assert estimate.low < estimate.value < estimate.high
    noise = np.sqrt(np.nanmean(fit.residuals["axis"] ** 2))
    assert noise == pytest.approx(np.deg2rad(0.3), rel=0.2)
    np.testing.assert_allclose(np.diag(fit.correlations), 1)


@pytest.mark.parametrize("columns", [at_night(["theta"]), ["orientation", "omega3", "x", "y"]])
def test_exact_data_give_the_numbers_to_rounding(columns: list[str], tmp_path: Path) -> None:
    """All 17 digits of a run: what the fit adds to its error is rounding, and its interval covers
    that.
    """
    t = np.arange(0, 0.6, 0.06)
    rows = tt.run("inverting", until=t[-1], output_times=t).trajectory
    heads = {"theta": "theta [rad]", "orientation": "q_w,q_x,q_y,q_z", "omega3": "omega3 [rad/s]"}
    table = {"t [s]": t} | {heads.get(name, f"{name} [m]"): rows[name] for name in columns}
    found = fitted(written(tmp_path / "R.csv", table), NEAR[:2], ["friction.mu", "initial.omega3"])
    for name, estimate in found.estimates.items():
        assert estimate.value == pytest.approx(TRUE[name], rel=1e-12)
        assert estimate.low <= TRUE[name] <= estimate.high
        assert estimate.sigma < 1e-7 * TRUE[name]


def test_one_search_does_not_establish_a_minimum(film: Path, fit: Fitted) -> None:
    found = fitted(film, noise="0.3 deg")
    assert "larger than the stated noise" not in found.reason
    assert (found.converged, found.trustworthy) == (False, False)
    assert (
        "the minimum is not trustworthy: 1 of 1 independent searches ended there (3 are needed)"
        in found.reason
    )
    assert found.estimates["friction.mu"].value == pytest.approx(
        fit.estimates["friction.mu"].value, rel=1e-4
    )
    assert str(found).startswith("the fit must be read with care:")


def test_outliers_hardly_move_a_fit_with_another_loss(
    film: Path, fit: Fitted, tmp_path: Path
) -> None:
    rows = np.loadtxt(film, delimiter=",", skiprows=1)
    rows[5::9, 1:] = [0.0, 0.6, 0.8]
    path = tmp_path / "outliers.csv"
    found = fitted(written(path, {"t [s]": rows[:, 0], AXIS: rows[:, 1:]}), loss="cauchy")
    for name, estimate in fit.estimates.items():
        assert found.estimates[name].value == pytest.approx(estimate.value, abs=4 * estimate.sigma)


def test_searches_with_the_same_end_are_counted_together() -> None:
    def end(point: float, cost: float) -> Minimum:
        return Minimum(np.array([point]), np.zeros(9), np.full((9, 1), 10.0), cost, 0.01, 1)

    ends = merge([end(1.0, 3.0), end(0.0, 1.0), end(0.001, 1.0), end(1.0, 3.0), end(0.0, 1.0)])
    assert [(e.point.round(2).item(), e.searches) for e in ends] == [(0.0, 3), (1.0, 2)]


def test_three_rows_of_noise_do_not_end_a_search(tmp_path: Path) -> None:
    """Two of the first three residuals are larger than twice the stated noise."""
    t = np.arange(0, 0.4, 1 / 60)
    seen = tt.run("inverting", start={"theta": 0.5}, until=t[-1], output_times=t).trajectory
    noise = np.deg2rad(0.3) * np.random.default_rng(3).standard_normal(seen.axis.shape)
    noise[:3] = np.deg2rad(1.0)
    axis = seen.axis.values + np.cross(noise, seen.axis.values)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    path = written(tmp_path / "film.csv", {"t [s]": t, AXIS: axis})
    found = fitted(path, ["initial.theta=0.5"], ["friction.mu"], starts=3, noise="0.3 deg")
    assert found.converged


@pytest.mark.slow
def test_numbers_in_another_period_are_named(tmp_path: Path) -> None:
    """Of a second; the best mu is 0.52 and not 0.3."""
    t = np.arange(60) / 60
    run = tt.run("inverting", start={"theta": 0.24}, until=1.0, output_times=t)
    noise = np.deg2rad(1) * np.random.default_rng(5).standard_normal(60)
    path = written(tmp_path / "film.csv", {"t [s]": t, "theta [rad]": run.trajectory.theta + noise})
    found = fitted(path, ["initial.theta=0.23"], starts=12, noise="1 deg", within=0.1)
    assert "other numbers fit nearly as well" in found.reason


@pytest.mark.slow
def test_of_a_film_that_begins_late_the_best_minimum_is_found(tmp_path: Path) -> None:
    """Nine free numbers: no better minimum is found from the truth."""
    t = np.arange(1, 270) / 30
    rows = tt.run(
        "inverting",
        {"mu": 0.27},
        parameters={"I1": 3.05e-6},
        start={"theta": 0.13, "omega3": 148},
        until=9.0,
        output_times=t,
    ).trajectory.sel(time=t)
    seen = rows.axis.values + np.deg2rad(1) * np.random.default_rng(3).standard_normal(
        rows.axis.shape
    )
    seen = (seen / np.linalg.norm(seen, axis=1)[:, None])[60:]
    path = written(tmp_path / "cut.csv", {"t [s]": t[60:] - t[60], AXIS: seen})
    true = {"friction.mu": 0.27, "parameters.I1": 3.05e-6}
    for name in ("theta", "theta_dot", "phi", "phi_dot", "omega3", "nu_x", "nu_y"):
        true[f"initial.{name}"] = float(rows[name][60])
    azimuth = float(np.arctan2(seen[0, 1], seen[0, 0]))
    found = tt.fit(
        path, tt.load("inverting", [f"initial.phi={azimuth}"]), list(true), systematic=False
    )
    best = fitted(path, [f"{name}={value!r}" for name, value in true.items()], true)
    left, least = (float(np.sum(f.residuals["axis"] ** 2)) for f in (found, best))
    assert found.trustworthy
    assert left <= least * (1 + 1e-4)


def test_a_fit_is_a_scenario_that_runs(fit: Fitted, tmp_path: Path) -> None:
    path = tmp_path / "fit.toml"
    path.write_text(fit.to_toml(), encoding="utf-8")
    assert tomllib.loads(fit.to_toml())["friction"]["mu"] == fit.estimates["friction.mu"].value
    assert tt.load(path).initial == fit.problem.initial
    dots, *_, curve = fit.plot(tmp_path / "fit.png").axes[0].lines
    assert len(curve.get_xdata()) > 50 * len(dots.get_xdata())  # not a line from dot to dot


def test_jacobians_are_the_exact_derivatives() -> None:
    """By numbers of the body, the law, the start and the clock, against variational equations."""
    names = ["parameters.I1", "parameters.alpha", "friction.mu", "initial.omega3"]
    t = np.array([0.01, 0.05, 0.11])
    seen = {"t": t, "theta": np.full(3, 0.2), "omega3": np.zeros(3), "place": np.zeros((3, 3))}
    observation = Observation(tt.load("inverting"), [*names, "time.offset", "time.scale"], seen)
    observation.refine()
    space = observation.space()
    _, (slopes,) = Misfit(observation, space, "linear").at(np.zeros((1, 6)), 3)
    run = tt.load("inverting", [f"run.output_times={t.tolist()}"], 0.11)
    exact = tt.derivatives.sensitivities(run, names).trajectory
    rows = tt.run(run).trajectory
    columns = ["theta", "omega3", "x", "y"]
    by_name = [np.concatenate([exact[c].sel(parameter=n) for c in columns]) for n in names]
    moves = np.stack(by_name, axis=1) @ space.slopes(np.zeros(6))[:4, :4]
    order = np.concatenate([np.arange(6), 6 + np.array([0, 2, 4, 1, 3, 5])])
    np.testing.assert_allclose(-slopes[order, :4], moves, rtol=1e-5, atol=1e-6)
    rate = rows.theta_dot.sel(time=t).values
    np.testing.assert_allclose(
        -slopes[:3, 4], rate * space.width[4] * space.scales[4].size, rtol=1e-5
    )
    np.testing.assert_allclose(-slopes[:3, 5], rate * t * space.width[5], rtol=1e-5)


def test_a_marker_is_where_a_run_with_these_numbers_has_it() -> None:
    """Its height too, which depends on numbers of the body that are free."""
    t, arm = np.array([0.02, 0.05, 0.11]), (0.01, 0.0, 0.005)
    free = {"parameters.alpha": 0.34, "parameters.R": 0.021}
    motion = {"t": t, "marker": np.zeros((3, 3))}
    observation = Observation(tt.load("inverting"), list(free), motion, arm)
    (off,) = observation.predictions(free)["marker"]
    body = {name.removeprefix("parameters."): value for name, value in free.items()}
    run = tt.run("inverting", parameters=body, until=0.12, output_times=t).trajectory.sel(time=t)
    height = 0.021 - 0.34 * 0.021 * np.cos(run.theta.values)
    place = np.stack([run.x.values, run.y.values, height], axis=1)
    assert_near(-off, place + turned(run.orientation.values, np.array(arm)), 1e-9)


def test_numbers_that_say_the_same_are_named(film: Path) -> None:
    """Mass and inertia together, without a scale of force in what is seen."""
    free = ["parameters.m", "parameters.I1", "parameters.I3"]
    found = fitted(film, ["initial.theta=0.5"], free)
    assert not found.trustworthy
    assert "cannot be distinguished" in found.reason


def test_the_command_prints_json_and_writes_a_scenario(film: Path, tmp_path: Path) -> None:
    out, figure = tmp_path / "fit.toml", tmp_path / "fit.svg"
    some = film.read_text().splitlines()[::3]
    (tmp_path / "some.csv").write_text("\n".join(some))
    words = (
        f"fit {tmp_path}/some.csv inverting --set initial.theta=0.5 --free friction.mu --starts 3"
    )
    words += " --within 0.05 --no-systematic"
    said = reported(f"{words} --out {out} --figure {figure}")
    assert abs(said["estimates"]["friction.mu"]["value"] - 0.3) < 0.03
    assert said["reason"] == "the numbers fit: the residuals are noise."
    assert (said["converged"], said["trustworthy"]) == (True, True)
    assert said["correlations"]["friction.mu"]["friction.mu"] == pytest.approx(1.0)
    assert out.is_file()
    assert figure.is_file()
    assert typed(f"{words} --out {out}") == 5  # it exists already

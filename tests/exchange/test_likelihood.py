"""The likelihood of a film, and draws of its posterior."""

from pathlib import Path

import numpy as np
import pytest
from measured import written
from refusals import refusal

import tippetop as tt


FREE = ["friction.mu", "initial.omega3", "initial.theta"]
TRUE = np.array([0.3, 155.0, 0.5])
NOISE = np.deg2rad(0.5)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    t = np.linspace(0, 0.6, 61)
    rows = tt.run("inverting", start={"theta": 0.5}, until=0.6, output_times=t).trajectory
    noise = NOISE * np.random.default_rng(4).standard_normal(61)
    path = tmp_path_factory.mktemp("film") / "film.csv"
    return written(path, {"t [s]": t, "theta [rad]": rows.theta + noise}), noise


def test_it_is_that_of_gaussian_noise(seen: tuple[Path, np.ndarray]) -> None:
    path, noise = seen
    f = tt.log_likelihood(path, "inverting", FREE, noise=NOISE)
    expected = -(noise**2).sum() / (2 * NOISE**2) - 61 * np.log(NOISE * np.sqrt(2 * np.pi))
    assert f(TRUE) == pytest.approx(expected, abs=1e-6)
    unknown = tt.log_likelihood(path, "inverting", FREE)
    assert unknown(TRUE) == pytest.approx(-61 / 2 * np.log((noise**2).sum()), abs=1e-6)


def test_many_points_are_those_alone_and_the_gradient_is_that_of_differences(
    seen: tuple[Path, np.ndarray],
) -> None:
    f = tt.log_likelihood(seen[0], "inverting", FREE, noise=NOISE)
    points = TRUE * (1 + 1e-2 * np.random.default_rng(1).standard_normal((5, 3)))
    points[3, 0] = -0.1
    values, slopes = f(points, gradient=True)
    assert values[3] == -np.inf
    np.testing.assert_allclose(values, [f(p) for p in points], rtol=1e-9)
    value, slope = f(points[0], gradient=True)
    assert value == pytest.approx(values[0])
    np.testing.assert_allclose(slope, slopes[0], rtol=1e-5)
    step = 1e-4 * np.eye(3) * points[0]
    wide = [(f(points[0] + s) - f(points[0] - s)) / (2 * s.sum()) for s in step]
    np.testing.assert_allclose(slope, wide, rtol=1e-3, atol=1e-3 * np.abs(slope).max())


def test_a_posterior_of_much_data_is_the_fit(seen: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    near = tt.load("inverting", ["initial.theta=0.5"])
    fitted = tt.fit(seen[0], near, FREE, noise=NOISE, starts=1, within=0.05, systematic=False)
    found = tt.posterior(seen[0], near, FREE, draws=300, fitted=fitted)
    assert found.effective > 150
    for name, estimate in fitted.estimates.items():
        assert found.sigma[name] == pytest.approx(estimate.sigma, rel=0.25)
        assert abs(found.mean[name] - estimate.value) < 0.4 * estimate.sigma
    assert "300 draws" in str(found)
    assert len(found.plot(tmp_path / "corner.png").axes) == 9
    with refusal(r"must be a fit of friction\.mu, but is one of"):
        tt.posterior(seen[0], near, "friction.mu", fitted=fitted)
    with refusal("must be alone, as it has its own options, but `noise`"):
        tt.posterior(seen[0], near, FREE, noise=NOISE, fitted=fitted)

"""Test bodies with two wells: the band is that of the body's well, the other one is named."""

import functools

import landscape_oracle as oracle
import numpy as np
import pytest

from tippetop.landscape import formulas, turning
from tippetop.landscape import landscape_body as bodies
from tippetop.mechanics.theory import spinning
from tippetop_kernels.level_crossings import Level


PARAMETERS = oracle.parameters(0.3, 3.0, 4.0)  # gamma above gamma*
TOP = bodies.top(PARAMETERS)


@pytest.fixture(scope="module")
def two_wells():
    """D, lambda, and the theta [rad] and V [J] of minimum, maximum, minimum on a dense scan."""
    b = oracle.body(PARAMETERS)
    lam = 1.02 * float(spinning.lambda_pi(b))
    D = float(spinning.slope(-1, b)) * lam * (1 + 1e-3)
    theta, V = scan(D, lam)
    slope = np.sign(np.diff(V))
    turns = np.flatnonzero(slope[1:] != slope[:-1]) + 1
    assert len(turns) == 3, "the body must have two wells here"
    return D, lam, theta[turns], V[turns]


@functools.cache
def scan(D, lam):
    """Theta [rad] and V [J] at a million points: nothing but the formula of V."""
    theta = np.linspace(0, np.pi, 1_000_003)[1:-1]
    coefficients = bodies.top(PARAMETERS).coefficients
    at = formulas.at_momenta(D, lam, coefficients)
    return theta, formulas.value(np.tan(theta / 2) ** 2, at, coefficients)


def bands(D, lam, energy):
    """The intervals of theta where V < E~, on the scan."""
    theta, V = scan(D, lam)
    below = np.flatnonzero(np.diff(np.concatenate([[0], (energy > V).astype(int), [0]])))
    return [(theta[a], theta[b - 1]) for a, b in zip(below[::2], below[1::2], strict=True)]


def edges(found, name="theta"):
    """The lower and the upper edge [rad] of a band."""
    return found[[f"{name}_min", f"{name}_max"]].to_array().values


@pytest.mark.slow
def test_both_bands_are_given_and_theta_chooses(two_wells):
    D, lam, theta, V = two_wells
    energy = max(V[0], V[2]) + 0.5 * (V[1] - max(V[0], V[2]))
    near, far = bands(D, lam, energy)
    for start, here, there in ((theta[0], near, far), (theta[2], far, near)):
        found = turning.turning_angles(TOP, D, lam, energy, theta=start)
        assert edges(found) == pytest.approx(here, abs=1e-5)
        assert edges(found, "other_theta") == pytest.approx(there, abs=1e-5)
        assert found.theta_star.item() == pytest.approx(start, abs=1e-5)
        assert found.F.item() == pytest.approx(V[0] if start == theta[0] else V[2], rel=1e-9)
    by_depth = turning.turning_angles(TOP, D, lam, energy)
    assert by_depth.theta_star.item() == pytest.approx(
        theta[0] if V[0] < V[2] else theta[2], abs=1e-5
    )


def test_levels_above_the_barrier_and_in_one_well_only(two_wells):
    D, lam, theta, V = two_wells
    over, lower = V[1] + 0.2 * (V[1] - min(V)), min(V) + 0.5 * abs(V[2] - V[0])
    (whole,) = bands(D, lam, over)
    for start in (theta[0], theta[2], np.nan):
        found = turning.turning_angles(TOP, D, lam, over, theta=start)
        assert edges(found) == pytest.approx(whole, abs=1e-5)
        assert np.isnan(found.other_theta_min.item())
        assert found.F.item() == pytest.approx(min(V), rel=1e-9)
    (only,) = bands(D, lam, lower)
    deep, shallow = (theta[0], theta[2]) if V[0] < V[2] else (theta[2], theta[0])
    found = turning.turning_angles(TOP, D, lam, [lower, lower, np.nan], theta=[deep, shallow, deep])
    assert edges(found)[:, 0] == pytest.approx(only, abs=1e-5)
    assert found.level.values.tolist() == [Level.ABOVE, Level.BELOW, Level.UNDEFINED]
    assert np.isnan(found.other_theta_min[0].item())
    assert found.other_theta_max[1].item() == pytest.approx(only[1], abs=1e-5)


def test_the_band_of_a_run_holds_the_run():
    import tippetop
    from tippetop.scenario import build

    b = TOP.body
    lam = 1.02 * float(spinning.lambda_pi(b))
    tables = {
        "system": "rolling-tippe-top",
        "parameters": PARAMETERS,
        "initial": {"theta": 3.1, "omega3": float(spinning.spin(-1, lam, b))},
        "run": {"until": 3.0, "output_step": 0.0005, "on_liftoff": "continue"},
    }
    run = tippetop.run(build.problem(tables)).datasets()["trajectory"]
    found = turning.band(bodies.top(PARAMETERS, "rolling-tippe-top"), run)
    theta = run["theta"].values
    assert theta.min() == pytest.approx(
        found.theta_min.values.min(), abs=1e-4
    )  # the rows miss the turning by some
    assert theta.max() == pytest.approx(found.theta_max.values.max(), abs=1e-9)
    assert np.isfinite(found.other_theta_min.values).all()
    assert (found.other_theta_max.values < theta.min()).all()

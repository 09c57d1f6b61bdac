"""What `check` predicts, runs confirm: random bodies, friction laws and starts, at poles and away
from them.
"""

import math
import re
from typing import Any

import examples
import numpy as np
import pytest

from tippetop.ensembles.ensemble import measure
from tippetop.ensembles.outcomes import CLASSES
from tippetop.problem import Problem, Problems
from tippetop.runs import forecast, starting
from tippetop.runs.run import solve


LAWS = [
    ("viscous", {"mu": 1.0}),
    ("coulomb", {"mu": 0.3, "eps": 0.1}),
    ("stribeck", {"mu": 0.0, "mu_static": 0.4, "v_s": 0.05, "eps": 0.05}),
    ("latitude", {"mu": 0.0, "mu_stem": 1.0}),
    ("latitude", {"mu": 1.0, "mu_stem": 0.0}),
    ("latitude", {"mu": 0.5, "mu_stem": 1.0}),
]


def top(law: tuple[str, dict[str, float]], until: float = 60.0, **start: float) -> Problem:
    """The canonical top under a law, or another of its parameters."""
    parameters = {**examples.CANONICAL, **{k: start.pop(k) for k in ("alpha", "I1") if k in start}}
    return examples.problem(
        "tippe-top", parameters, start, until, law, stop_when="settled", events=("settled",)
    )


def random_start(rng: np.random.Generator) -> dict[str, Any]:
    """A body near the canonical one, and a start; every third at a pole."""
    theta = rng.choice([0.0, math.pi, rng.uniform(0.01, 3.1), rng.uniform(0.01, 0.3)])
    sliding = rng.choice([0.0, 0.2])
    alpha, omega3 = rng.uniform(0.1, 0.5), rng.choice([-1, 1]) * rng.uniform(0, 160)
    return {
        "theta": theta,
        "omega3": omega3,
        "nu_x": sliding,
        "alpha": alpha,
        "I1": 3.2e-6 * rng.uniform(0.8, 1.2),
    }


WORDS = {"inverted": "the inverted spin", "upright": "the upright spin", "tumbling": "tumbling"}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law[0])
def test_a_predicted_fate_comes_true(law: tuple[str, dict[str, float]]) -> None:
    rng, confirmed = np.random.default_rng(5), 0
    for _ in range(8):
        start = random_start(rng)
        made = top(law, **start)
        fate, found = forecast.assessment(made).get("fate", ""), solve(made, keep=False).report
        if "stays" in fate:
            assert found["theta_end"] == start["theta"]
        elif fate and found["outcome"] not in ("under-way", "lifted-off"):
            assert WORDS[found["outcome"]] in fate, start
            confirmed += 1
    assert confirmed > 1 or fate == ""


@pytest.mark.parametrize("theta", [0.0, math.pi])
def test_what_slides_at_a_pole_leaves_it(theta: float) -> None:
    """But not without friction, which alone would turn it."""
    for law, leaves in ((LAWS[0], True), (("none", {}), False)):
        made = top(law, until=0.05, theta=theta, omega3=100.0, nu_x=0.1)
        assert ("stays at the pole" not in forecast.assessment(made)["fate"]) == leaves
        assert (abs(solve(made, keep=False).report["theta_end"] - theta) > 1e-4) == leaves


def test_a_top_that_lifts_off_at_once_has_lifted_off() -> None:
    made = top(("viscous", {"mu": 0.3}), theta=1.0, phi_dot=30.0, omega3=100.0)
    run, lane = (
        solve(made, keep=False),
        measure(Problems.vary(made, {"initial.theta": np.array([1.0])}), threads=1),
    )
    assert run.report["outcome"] == CLASSES[lane.kind[0]] == "lifted-off"
    assert "g_n < 0" in run.reason
    force = forecast.at_start(made)["normal_force"]
    assert (
        run.report["normal_force"]["min"]
        == lane.columns["normal_force_min"][0]
        == pytest.approx(force)
    )
    assert force < 0


@pytest.mark.parametrize("law", [LAWS[2], LAWS[3]], ids=lambda law: law[0])
def test_what_slides_almost_without_loss_has_not_settled(law: tuple[str, dict[str, float]]) -> None:
    """Under a law that weakens with speed, or towards a pole; no spin is called stable, and none
    the end.
    """
    for theta in (0.02, 0.5):
        made = top(law, until=1.0, theta=theta, omega3=155.0, nu_x=1.0)
        assert "fate" not in forecast.assessment(made)
        assert solve(made, keep=False).report["outcome"] == "under-way"


@pytest.mark.parametrize("theta", [0.5, 1.5, 1.7, 2.0])
def test_a_gliding_heavy_top_falls_to_the_plane_if_it_is_above(theta: float) -> None:
    start = {"theta": theta, "omega3": 20.0}
    made = examples.problem("gliding-heavy-top", examples.HEAVY, start, 20.0, LAWS[0])
    fate = forecast.assessment(made).get("fate", "")
    assert ("falls" in fate) == (solve(made, keep=False).status.value == "fallen")


@pytest.mark.parametrize(("spin", "grows", "until"), [(-5.0, "pitch", 6.0), (5.0, "roll", 18.0)])
def test_small_oscillations_of_a_rattleback_grow_as_predicted(
    spin: float, grows: str, until: float
) -> None:
    """Where the body spins one way pitch grows, and the other way roll."""
    parameters = starting.load("rattleback").parameters
    start = {"tilt": 1e-9, "roll": 1e-9, "spin": spin}
    times = np.linspace(0.0, until, 6001)
    problem = examples.problem("rolling-ellipsoid", parameters, start, until, times=times)
    regime = forecast.assessment(problem)["regime"]
    rate = float(re.search(rf"small {grows}, [\d.]+ rad/s at rest, grows at ([\d.]+)", regime)[1])
    assert "decays" in regime
    swings = solve(problem).columns()["tilt" if grows == "pitch" else grows].values
    sizes = np.abs(swings[1:].reshape(6, 1000)).max(axis=1)
    np.testing.assert_allclose(np.log(sizes[5] / sizes[2]) * 2 / until, rate, rtol=0.01)


def test_a_ball_with_three_moments_oscillates_as_a_pendulum_that_rolls() -> None:
    """At rest: omega^2 = m g h/(I + m (R - h)^2), about axis 1 (roll) and axis 2 (pitch)."""
    parameters = starting.load("rock-n-roller").parameters
    problem = examples.problem("rolling-ellipsoid", parameters, {"tilt": 0.01}, 1.0)
    regime = forecast.assessment(problem)["regime"]
    for name, moment in (("roll", "I1"), ("pitch", "I2")):
        omega = math.sqrt(0.1 * 9.81 * 0.01 / (parameters[moment] + 0.1 * 0.03**2))
        assert f"small {name}, {omega:.6g} rad/s at rest, keeps its size" in regime


def test_away_from_rest_and_off_the_axis_nothing_is_predicted() -> None:
    for name in ("off-axis-top", "rock-n-roller"):
        regime = forecast.assessment(starting.load(name))["regime"]
        assert regime.startswith("theory predicts small oscillations only")

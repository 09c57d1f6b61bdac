"""What has become of a top: near an unstable pole it is under way, and liftoff is known; in runs
and lanes alike.
"""

import numpy as np
import pytest

import tippetop
from tippetop.engine.status import Status
from tippetop.ensembles.ensemble import measure
from tippetop.ensembles.outcomes import CLASSES
from tippetop.problem import Problems
from tippetop.runs import forecast, starting
from tippetop.runs.run import solve
from tippetop.runs.summary import lines


def outcomes(sets: list[str], until: float, **variations: list[float]) -> tuple[str, str]:
    """The outcome of a single run, and the class of the same top in a lane."""
    problem = starting.load("inverting", sets, until=until)
    lane = measure(
        Problems.vary(problem, {"initial.theta": np.array([problem.initial["theta"]])}),
        threads=1,
    )
    return solve(problem, keep=False).report["outcome"], CLASSES[lane.kind[0]]


def test_a_settled_that_does_not_last_is_no_time_in_a_lane() -> None:
    """In planar motion sliding dies for a moment at every swing: a run marks none of these as
    significant.
    """
    problem = starting.load("inverting", ["initial.omega3=0.0"], until=1.0)
    run = solve(problem)
    assert len(run.events.of("settled").time) > 3
    lane = measure(Problems.vary(problem, {"initial.omega3": np.array([0.0])}), threads=1)
    assert len(run.events.of("settled", significant=True).time) == 0
    assert not lane.settled[0]
    assert np.isnan(lane.columns["settled_at"][0])


def test_a_fate_knows_liftoff() -> None:
    problem = starting.load("inverting", ["initial.omega3=300.0"])
    assert forecast.assessment(problem)["fate"] == "ends in the inverted spin, unless it lifts off"
    done = solve(problem, keep=False)
    assert done.status is Status.LIFTOFF
    assert "4.96" in done.reason
    assert done.report["outcome"] == "lifted-off"
    assert abs(done.report["normal_force"]["min"]) < 1e-9
    assert "unless it lifts off" in forecast.assessment(starting.load("rolling"))["fate"]


def test_a_summary_says_that_a_top_is_under_way() -> None:
    run = tippetop.run("inverting", start={"theta": 1e-6}, until=0.5)
    assert run.summary.outcome == "under-way"
    assert "under way" in dict(lines(run.summary))["outcome"]


@pytest.mark.parametrize(
    ("sets", "expected"),
    [
        (["initial.theta=0.0", "initial.omega3=0.0"], "at-rest"),
        (["initial.theta=0.0", "initial.omega3=10.0"], "upright"),
        (["initial.gap=0.001", "contact.e_n=0.0"], "under-way"),  # the landing took energy
        (["initial.gap=0.0", "contact.e_n=0.0"], "nutating"),
    ],
)
def test_a_top_without_friction_nutates_unless_it_stays_or_loses_energy(
    sets: list[str], expected: str
) -> None:
    sets = ["friction.mu=0", *sets]
    assert outcomes(sets, 0.5) == (expected, expected)


@pytest.mark.parametrize("theta", [0.05, 0.11])
def test_what_rolls_for_ever_near_a_pole_is_rolling(theta: float) -> None:
    sets = [
        f"initial.theta={theta}",
        "friction.law=coulomb",
        "friction.mu=0.3",
        "stem.r=0.004",
        "stem.h=0.017",
    ]
    assert (
        solve(starting.load("inverting", sets, until=0.5), keep=False).report["outcome"]
        == "rolling"
    )

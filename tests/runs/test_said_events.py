"""What is said of events: passages are counted as such, and only of what a system can do."""

import numpy as np
import pytest

import tippetop
from tippetop.ensembles.ensemble import measure
from tippetop.problem import Problems
from tippetop.runs import starting
from tippetop.runs.run import solve
from tippetop.runs.summary import lines


SWINGS = ["initial.omega3=0.0", "initial.phi_dot=0.0", "initial.theta=2.0"]


def test_a_planar_swing_through_the_pole_is_no_turning() -> None:
    problem = starting.load("heavy-top", SWINGS, until=2.0)
    run = solve(problem)
    events = run.events
    turning = events.kind == 0
    at_pole = turning & (np.pi - events.theta < 1e-6)
    assert at_pole.sum() > 3
    assert not events.significant[at_pole].any()
    assert events.significant[turning & ~at_pole].all()
    band = run.report["nutational_band"]
    assert band["theta_min"] == pytest.approx(2.0, abs=1e-12)
    assert band["theta_max"] == pytest.approx(2.0, abs=1e-12)
    lane = measure(Problems.vary(problem, {"initial.theta": np.array([2.0])}), threads=1)
    assert lane.columns["turnings"][0] == run.report["event_counts"]["turning_significant"]
    assert lane.columns["theta_max"][0] == pytest.approx(2.0, abs=1e-12)


def test_a_near_passage_is_a_turning() -> None:
    """Almost planar: the axis passes the pole at some 1e-5 rad, and turns there."""
    run = solve(starting.load("heavy-top", [*SWINGS[:1], "initial.phi_dot=1e-4", SWINGS[2]], 1.0))
    near = (run.events.kind == 0) & (np.pi - run.events.theta < 1e-3)
    assert near.any()
    assert run.events.significant[near].all()


def test_a_held_tip_neither_lifts_off_nor_inverts() -> None:
    start = {"omega3": 1.0, "phi_dot": 25.0}
    text = dict(lines(tippetop.run("heavy-top", start=start, until=2.0).summary))
    assert "inversion" not in text
    assert "liftoff" not in " ".join(text.values())
    assert "outcome" not in text


def test_a_cylinder_has_no_inversion_and_passages_are_counted() -> None:
    run = tippetop.run("gliding-cylinder", until=2.0)
    text = dict(lines(run.summary))
    assert "inversion" not in text
    assert run.summary.event_counts["equator"] > 0
    assert "passage" in text["other events"]

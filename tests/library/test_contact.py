"""Runs whose contact changes its phase, from Python."""

import numpy as np
import pytest
from refusals import refusal
from touching import BODY, BOUNCE

import tippetop as tt
from tippetop.columns import flag_words, flagged


TOP = tt.TippeTop(**BODY)
START = {"theta": 0.1, "omega3": 155.0, "centre_at_rest": True}
STEM = {"r": 0.005, "h": 0.017}


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run(BOUNCE)


def test_a_run_in_memory_has_all_its_tables(run: tt.Run) -> None:
    assert set(run.datasets()) == {"trajectory", "events", "phases", "impacts"}
    assert float(run.phases.end[-1]) == BOUNCE["run"]["until"]
    assert (run.impacts.work <= 0).all()
    assert run.impacts.sizes["impact"] == flagged(run.events.kind, "impact").sum()
    assert "flies" in repr(run._repr_html_())


def test_a_run_without_phases_says_so() -> None:
    run = tt.run("inverting", until=0.01)
    with pytest.raises(AttributeError, match="does not change its phase"):
        run.phases  # noqa: B018


def test_theory_of_a_run_is_that_of_its_ball(run: tt.Run) -> None:
    assert (
        tt.theory.thresholds(run)["lambda_s"].value == tt.theory.thresholds(TOP)["lambda_s"].value
    )
    band = tt.landscapes.band(run)
    flies = flagged(run.trajectory.phase, "flight")
    assert np.isnan(band.theta_min.values[flies]).all()
    rolls = band.isel(time=~flies)
    assert (rolls.theta_min <= rolls.theta + 1e-9).all()
    assert (rolls.theta <= rolls.theta_max + 1e-9).all()
    with refusal("its contact may change it"):
        tt.theory.reconstruct(run)
    for about in (run, run.problem):
        with refusal("must be finite as v_A goes to 0"):
            tt.theory.linear_modes(about, omega3=60.0)


@pytest.mark.parametrize("theta", [0.05, np.pi - 0.05])
def test_a_top_that_drills_has_the_modes_of_viscous_friction_but_no_final_spin(
    theta: float,
) -> None:
    start = {"theta": theta, "omega3": 180.0}
    law = {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 0.0}
    drills = tt.run({**BOUNCE, "friction": law, "initial": start, "run": {"until": 1e-4}})
    slides = tt.run(
        TOP, tt.friction.Viscous(mu=3 * np.pi * 0.3 / (8 * 5e-4 * 180.0)), start=start, until=1e-4
    )
    assert drills.summary.outcome == "under-way"
    assert slides.summary.outcome == ("inverted" if theta > 3 else "under-way")
    np.testing.assert_allclose(
        tt.theory.linear_modes(drills, omega3=180.0),
        tt.theory.linear_modes(slides, omega3=180.0),
        rtol=1e-13,
    )


def test_a_top_that_is_not_followed_to_its_end_has_no_class() -> None:
    """An impact that makes energy ends the run: neither the run nor the row of an ensemble calls
    that a fate.
    """
    start, contact = (
        {"theta": 1.66, "omega3": 0.0, "nu_x": -0.66, "nu_z": -1.0},
        {"restitution": "newton", "e_n": 1.0},
    )
    law = {"law": "coulomb", "mu": 0.31}
    scenario = {
        **BOUNCE,
        "friction": law,
        "contact": contact,
        "initial": start,
        "run": {"until": 1e-4},
    }
    alone = tt.run(scenario)
    assert alone.summary.status == "ended"
    assert "made energy" in alone.summary.reason
    assert not hasattr(alone.summary, "outcome")
    tops = tt.ensemble(scenario, {"nu_x": [-0.66, 0.0]})
    assert [*flag_words(tops.status)] == ["ended", "finished"]
    assert [*flag_words(tops["class"])] == ["none", "bouncing"]


def test_a_stem_under_the_plane_is_refused() -> None:
    def begun(**gap: float) -> tt.Run:
        start = {"theta": 3.0, "omega3": 100.0, **gap}
        return tt.run(TOP, tt.friction.Viscous(mu=0.3), stem=STEM, start=start, until=1e-3)

    with refusal(r"`initial.gap` must be at least .*: the stem would be under the plane"):
        begun(gap=1e-9)
    least = STEM["r"] - BODY["R"] - STEM["h"] * np.cos(3.0)
    given, left_out = begun(gap=least), begun()
    assert given.trajectory.gap_stem.min() > -1e-15
    assert given.phases.ball.values.tolist() == [1]
    assert left_out.trajectory.identical(given.trajectory)  # it stands on what reaches further down

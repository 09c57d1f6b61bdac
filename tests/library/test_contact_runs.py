"""Runs whose contact opens and closes do what other runs do: own events and columns, keyframes,
settling, quad.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import CANONICAL as BODY
from limits import assert_below, assert_near
from nightly import at_night
from refusals import refusal
from touching import DRILLING, LEINE_GLOCKER, STEM, TOSSED

import tippetop as tt
from tippetop.columns import flag_words, flagged
from tippetop.engine.status import Status
from tippetop.mechanics.operand import formula
from tippetop.mechanics.units import ONE, SECOND, SECOND_PER_METRE


ROCKING = {"theta": 1.5, "theta_dot": 20.0, "phi_dot": -20.0, "omega3": 60.0}
COULOMB, VISCOUS = {"law": "coulomb", "mu": 0.3}, {"law": "viscous", "mu": 2.0}


def scenario(
    friction: dict, initial: dict, until: float, body: dict = BODY, **more: Any
) -> dict[str, Any]:
    more.setdefault("contact", {"e_n": 0.5})
    return {"system": "tippe-top", "parameters": body, "friction": friction, "initial": initial,
            "run": {"until": until}, **more}  # fmt: skip


CASES = {
    "bounces": scenario(COULOMB, TOSSED, 0.3),
    "stem": scenario(VISCOUS, ROCKING, 0.2, LEINE_GLOCKER, stem=STEM),
    "drilling": scenario(DRILLING, TOSSED, 0.1, LEINE_GLOCKER),
}


def times(run: Any, kind: str) -> np.ndarray:
    return run.events.time.values[flagged(run.events.kind, kind)]


@pytest.mark.parametrize("case", ["bounces", "stem", at_night("drilling")])
def test_events_and_columns_of_users_mean_the_same_in_every_phase(case: str) -> None:
    """Every passage of a dense scan, on the ground, on the stem and in the air."""
    rows = tt.run(CASES[case], output_step=2e-5).trajectory
    level, low = (
        float(np.ptp(v) / 2 + v.min()) for v in (np.cos(rows.theta.values), rows.z.values)
    )
    radius = CASES[case]["parameters"]["R"]
    above = tt.extending.Event(
        "above",
        "z rises",
        formula(lambda s, b: level - s.z),
        kept=(tt.extending.Kept("times", "count", "n"),),
    )
    high = tt.extending.Event(
        "high", "the centre of mass is high", formula(lambda s, b: s.height - low / radius * b.R)
    )
    twice = tt.extending.Quantity("twice", "2z", ONE, "twice z", formula(lambda s, b: 2 * s.z))
    run = tt.run(CASES[case], events=[above, high], columns=["theta", twice])
    for name, values in (
        ("above", level - np.cos(rows.theta.values)),
        ("high", rows.z.values - low),
    ):
        passed = np.flatnonzero(np.diff(np.sign(values)))
        assert_near(times(run, name), rows.time.values[passed], 2.1e-5)
    assert run.summary.kept["times"] == len(times(run, "above")) > 1
    assert_near(run.trajectory.twice, 2 * np.cos(run.trajectory.theta), 1e-14)


@pytest.mark.parametrize("case", CASES)
def test_a_replay_has_the_bits_of_the_rows(case: str, tmp_path: Path) -> None:
    span = {"until": 0.125}
    run = tt.run(
        CASES[case], output="keyframes", keyframe_steps=10, out=tmp_path / "run.zarr", **span
    )
    rows, whole = (
        run.replay(0.0625, 0.125, 2**-9),
        tt.run(CASES[case], output_step=2**-9, **span).trajectory,
    )
    for name in ("theta", "x", "energy", "phase", "ball"):
        np.testing.assert_array_equal(rows[name].values, whole[name].values[32:], err_msg=name)


def test_a_top_that_may_fly_settles_when_one_that_may_not_does() -> None:
    runs = [
        tt.run("inverting", until=300.0, stop_when="settled", output="events", on_liftoff=w)
        for w in ("stop", "fly")
    ]
    assert [run.summary.status for run in runs] == ["settled", "settled"]
    assert [run.summary.outcome for run in runs] == ["inverted", "inverted"]
    assert times(runs[1], "settled")[-1] == pytest.approx(times(runs[0], "settled")[-1], rel=1e-6)


def test_a_run_of_phases_ends_soon_after_it_has_settled() -> None:
    run = tt.run("cohen-coulomb", until=30.0, stop_when="settled")
    settled, unit = times(run, "settled")[-1], 2.0**-4
    assert 200 * unit < run.summary.t_end - settled < 210 * unit
    assert [*run.phases.phase.values] == [0, 1]  # it slips, then rolls to the end
    assert run.phases.end.values[-1] == pytest.approx(run.summary.t_end, abs=1e-12)


ROLLS = (tt.friction.Coulomb(0.3), 0.1, 155.0)
RESTS = (tt.friction.Contensou(0.3, patch=2e-3), 1.2, 0.0)


@pytest.mark.parametrize(("law", "theta", "omega3"), [ROLLS, RESTS])
def test_what_does_not_slide_from_its_start_settles(law: Any, theta: float, omega3: float) -> None:
    start = {"theta": theta, "omega3": omega3, "nu_x": 0.0}
    run = tt.run(tt.TippeTop(**BODY), law, start=start, until=30.0, stop_when="settled")
    assert run.summary.status == "settled"
    assert len(run.phases.phase) == 1
    unit = float(run.problem.scales.of(SECOND))
    assert 200 * unit < run.summary.t_end < 220 * unit
    assert "nothing slid from the start" in run.summary.reason


@pytest.mark.parametrize("preset", ["rolling", "heavy-top", "rolling-cylinder"])
def test_a_system_in_which_nothing_slides_cannot_settle(preset: str) -> None:
    with refusal("in which nothing slides"):
        tt.run(preset, until=1.0, stop_when="settled")


def test_a_spin_is_not_called_final_before_friction_that_drills_ends_it() -> None:
    """This top stands inverted at 2.5 s, and has left that spin at 13 s."""
    law = tt.friction.Contensou(mu=0.3, patch=5e-4)
    run = tt.run("inverting", law, output_times=[0.0, 2.5, 13.0], until=13.0)
    assert run.trajectory.theta.values[1] > np.pi - 0.1 > run.trajectory.theta.values[2] + 0.1
    assert tt.run("inverting", law, until=2.5).summary.outcome == "under-way"


def test_what_slides_without_friction_has_not_settled() -> None:
    start = {"theta": 0.5, "omega3": 100.0}
    law = tt.friction.Coulomb(0.0)
    run = tt.run(tt.TippeTop(**BODY), law, start=start, until=20.0, stop_when="settled")
    assert run.summary.status == "finished"


def test_an_unstable_spin_that_does_not_slide_yet_has_not_settled_in_a_lane() -> None:
    """It spins at the pole, where its step is as long as the run."""
    top, law, start = tt.TippeTop(**BODY), tt.friction.Viscous(0.3), {"theta": 0.0}
    tops = tt.ensemble(top, {"omega3": [160.0]}, law, start=start, until=60.0, stop_when="settled")
    assert tops.t_end.values == [60.0]
    assert tops.status.values == [Status.FINISHED.code]


def test_a_body_in_the_air_is_not_at_rest() -> None:
    """It bounces upright without spin, so nothing of it moves but its height."""
    dropped = {"theta": 0, "omega3": 0, "gap": 0.0075, "nu_z": -0.1}
    law = {"law": "viscous", "mu": 1.0, "mu_r": 1.5e-5}
    run = tt.run(scenario(law, dropped, 0.2, contact={"e_n": 0.8}))
    assert run.trajectory.z.values[-1] > run.trajectory.z.values.min() + 1e-3
    assert run.summary.outcome == "bouncing"


def test_a_body_that_torques_stop_is_at_rest_alone_and_in_a_sweep() -> None:
    body = tt.TippeTop(**BODY)
    for law in (tt.friction.Coulomb(0.3, mu_d=1e-4), tt.friction.Viscous(0.3, mu_d=1e-4)):
        run = tt.run(body, law, start={"theta": 0.0, "omega3": 1.0}, until=0.3)
        assert abs(run.trajectory.omega3.values[-1]) < 1e-6
        assert run.summary.outcome == "at-rest"
        tops = tt.ensemble(body, {"omega3": [1.0]}, law, start={"theta": 0.0}, until=0.3)
        assert flag_words(tops["class"])[0] == "at-rest"


def test_a_run_whose_contact_may_open_ends_at_a_liftoff_if_it_is_told_to() -> None:
    run = tt.run(scenario(COULOMB, TOSSED, 0.3), on_liftoff="stop")
    flying = tt.run(scenario(COULOMB, TOSSED, 0.3))
    assert run.summary.status == "liftoff"
    assert "the body lifted off" in run.attributes["reason"]
    assert run.summary.t_end == times(run, "liftoff")[0] == times(flying, "liftoff")[0]


def test_a_top_in_the_air_has_not_settled() -> None:
    dropped = scenario(VISCOUS, {"theta": 0.0, "omega3": 10.0, "gap": 1.0}, 0.2)
    run = tt.run(dropped, stop_when="settled", output="events")
    assert run.summary.status == "finished"
    assert run.summary.outcome == "bouncing"


@pytest.mark.parametrize(
    ("law", "start", "until"),
    [
        (COULOMB, TOSSED, 0.06),
        (COULOMB, {"theta": 0.1, "omega3": 155.0, "nu_x": 0.01}, 0.05),
        (VISCOUS, {"theta": 0.5, "omega3": 180.0, "gap": 1e-4}, 0.02),
        ({"law": "none"}, {"theta": 0.5, "omega3": 180.0, "gap": 1e-4}, 0.01),
    ],
)
def test_runs_of_phases_in_quad_agree_with_80_bits(law: dict, start: dict, until: float) -> None:
    """To what 80 bits can show: through liftoff, impact and stick."""
    wide, quad = (
        tt.run(scenario(law, start, until), precision=p, on_liftoff="fly")
        for p in ("longdouble", "quad")
    )
    np.testing.assert_array_equal(wide.events.kind, quad.events.kind)
    assert_near(wide.events.time, quad.events.time, 1e-16)
    assert_near(wide.trajectory.theta, quad.trajectory.theta, 1e-15)
    assert_below(1e-16, quad.summary.drift)


def test_a_law_of_a_user_may_have_literals_in_any_precision() -> None:
    class Halved(tt.extending.FrictionLaw):
        """Viscous friction of half the coefficient."""

        mu = tt.extending.number(SECOND_PER_METRE, "twice the coefficient", least=0)
        coefficient = formula(lambda v2, z, law: 0.5 * law.mu)

    tt.extending.register(Halved)
    for precision in ("longdouble", "quad"):
        run, halved = (
            tt.run("flying", law, until=0.02, precision=precision, on_liftoff="fly")
            for law in (tt.friction.Viscous(0.2), Halved(0.4))
        )
        np.testing.assert_array_equal(run.trajectory.theta, halved.trajectory.theta)


def test_events_and_columns_read_the_reaction_from_the_start_on() -> None:
    def ratio(s: Any, b: Any) -> Any:
        return (s.Fx * s.Fx + s.Fy * s.Fy) / s.force**2 - 1e-3

    half = tt.extending.Event("half", "friction", ratio)
    used = tt.extending.Quantity("used", "", ONE, "friction", ratio)
    run = tt.run("leine-glocker-stem", until=0.1, events=[half], columns=[used])
    at = times(run, "half")
    rows = tt.run("leine-glocker-stem", output_times=at, columns=[used], until=0.1).trajectory
    assert len(at) > 3
    assert_near(rows.used, 0.0, 1e-12)


def test_a_slide_that_begins_outside_the_friction_cone_has_its_row_at_once() -> None:
    """Its first steps are so short that their polynomials mean nothing before them."""
    body = {**LEINE_GLOCKER, "alpha": 0.45773133498543367}
    start = {
        "theta": 1.4074573419766757,
        "phi_dot": 7.937053797883742,
        "omega3": 41.604276802429794,
        "nu_x": 0.0,
    }
    rows = tt.run(
        scenario({"law": "coulomb", "mu": 0.2}, start, 0.003, body), output_step=0.001
    ).trajectory
    assert rows.omega3.values[0] == pytest.approx(start["omega3"], rel=1e-7)
    assert np.ptp(rows.normal_force.values) < 1e-3


@pytest.mark.parametrize("precision", ["double", "longdouble"])
def test_an_impact_that_ends_a_steady_flight_is_no_turning(precision: str) -> None:
    """In flight rounding alone changes the inclination here, so theta' has no definite sign."""
    start = {"gap": 1e-3, "theta": 0.7, "omega3": 200.0}
    law = tt.friction.Coulomb(0.3)
    run = tt.run("flying", law, until=0.05, precision=precision, start=start)
    assert run.impacts.time[0] < times(run, "turning")[0] - 1e-3

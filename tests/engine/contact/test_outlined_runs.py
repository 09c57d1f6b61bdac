"""Runs of bodies with an outline: against multi-precision references, closed forms, and the tippe
top; `test_surroundings.py` has them against Newton and Euler.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nightly import at_night

import tippetop as tt
from tippetop.exchange.simulators import text_of
from tippetop.runs.certificate import certificate_violations


REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "outlines.json").read_text())
EGG = tt.Spheroid(m=0.06, a=0.03, b=0.02, c=0.0, I1=1.56e-5, I3=9.6e-6, g=9.81)
JUMPS = {"theta": 1.5, "phi_dot": 190.0}


# --- references ---------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["vector", "euler"])
@pytest.mark.parametrize("name", ["spheroid-gliding", "disc-rolling", "tippe-top-gliding"])
def test_a_motion_is_that_of_the_reference(name: str, form: str) -> None:
    case = REFERENCE[name]
    kind = tt.Disc if "ring" in case["parameters"] else tt.Spheroid
    law = tt.friction.Viscous(mu=case["mu"]) if case["mu"] else None
    times = [row[0] for row in case["rows"]]
    options = {"until": times[-1], "output_times": times, "form": form}
    rows = tt.run(kind(**case["parameters"]), law, start=case["initial"], **options).trajectory
    for i, (_, *expected) in enumerate(case["rows"]):
        found = [rows[n].values[i] for n in ("axis", "L", "energy", "normal_force", "x")]
        for mine, theirs in zip(found, expected, strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12 * np.max(np.abs(theirs)))


def test_an_egg_jumps_when_the_reference_does() -> None:
    options = {"start": JUMPS, "contact": {"e_n": 0.0}}
    phases = tt.run(EGG, tt.friction.Viscous(mu=1.0), until=0.3, **options).phases
    case = REFERENCE["spheroid-jump"]
    expected = [case["liftoff"], case["landing"]]
    np.testing.assert_allclose(phases.end.values[:2], expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("e_n", [0.0, 0.5])
def test_many_jumps_of_an_egg_keep_its_balance(e_n: float) -> None:
    run = tt.run(EGG, tt.friction.Viscous(mu=1.0), start=JUMPS, until=1.0, contact={"e_n": e_n})
    assert run.summary.event_counts["liftoff"] == 24
    assert run.drift["energy_balance"] < 1e-13


@pytest.mark.parametrize(
    "law",
    [
        tt.friction.Coulomb(mu=0.3),
        tt.friction.Contensou(mu=0.3, patch=1e-4),
        tt.friction.Coulomb(mu=0.2, mu_r=1e-5),
    ],
)
@pytest.mark.parametrize("precision", ["double", "longdouble"])
def test_every_phase_keeps_its_balance(law: Any, precision: str) -> None:
    start = {"theta": 1.0, "phi_dot": 20.0, "omega3": 10.0, "nu_x": 0.1, "gap": 1e-3}
    run = tt.run(EGG, law, start=start, until=0.2, contact={"e_n": 0.4}, precision=precision)
    assert run.summary.event_counts["impact"] > 0
    assert run.drift["energy_balance"] < (1e-14 if precision == "double" else 1e-16)


# --- closed forms -------------------------------------------------------------------------------


def test_an_egg_on_its_side_rocks_as_a_pendulum() -> None:
    """In pure rolling: omega^2 = m g (a^2/b - b)/(I1 + m b^2)."""
    start = {"theta": np.pi / 2 + 1e-5, "omega3": 0.0}
    times = tt.run(EGG, start=start, until=2.0, events=["equator"]).events.time.values
    e = EGG
    omega = np.sqrt(e.m * e.g * (e.a**2 / e.b - e.b) / (e.I1 + e.m * e.b**2))
    np.testing.assert_allclose(np.diff(times), np.pi / omega, rtol=1e-8)


def test_a_sharp_disc_rolls_steadily() -> None:
    """I1 phi'^2 cos(theta) = (I3 + m r^2) phi' omega_3 + m g r cot(theta)."""
    coin = tt.Disc(m=0.01, ring=0.02, tube=0.0, c=0.0, I1=1e-6, I3=2e-6, g=9.81)
    theta, phi_dot, r = 1.1, 12.0, coin.ring
    drive = coin.I1 * phi_dot**2 * np.cos(theta) - coin.m * coin.g * r / np.tan(theta)
    omega3 = drive / ((coin.I3 + coin.m * r**2) * phi_dot)
    rolls = tt.run(coin, start={"theta": theta, "phi_dot": phi_dot, "omega3": omega3}, until=2.0)
    np.testing.assert_allclose(rolls.trajectory.theta, theta, rtol=0, atol=1e-12)


@pytest.mark.parametrize("top", [EGG, tt.Disc(0.01, 0.02, 1e-3, 1e-3, 1e-6, 2e-6, 9.81)])
def test_without_friction_two_momenta_stay(top: Any) -> None:
    start = {"theta": 1.0, "phi_dot": 10.0, "omega3": 30.0, "theta_dot": 1.0}
    rows = tt.run(top, tt.friction.Frictionless(), start=start, until=0.5).trajectory
    L3 = (rows.L.values * rows.axis.values).sum(axis=1)
    for momentum in (L3, rows.L.values[:, 2]):
        np.testing.assert_allclose(momentum, momentum[0], rtol=1e-13)


def test_a_disc_that_falls_flat_ends_by_an_event() -> None:
    coin = tt.Disc(m=0.01, ring=0.02, tube=0.0, c=0.0, I1=1e-6, I3=2e-6, g=9.81)
    run = tt.run(coin, tt.friction.Frictionless(), start={"theta": 1.0, "omega3": 0.0}, until=1.0)
    assert run.summary.event_counts["flat"] == 1
    assert run.summary.status == "ended"
    for start in ({"theta": 0.0}, {"theta": np.pi}, {}):
        for options in ({}, {"on_liftoff": "fly"}):
            with pytest.raises(tt.InputError, match="lies flat"):
                tt.run(coin, tt.friction.Frictionless(), start=start, until=1.0, **options)


@pytest.mark.parametrize(
    ("law", "options"),
    [
        (None, {}),
        (tt.friction.Viscous(mu=1.0), {}),
        (tt.friction.Coulomb(mu=1.0, mu_r=1e-9), {"contact": {}}),
    ],
)
def test_a_disc_that_lies_nearly_flat_keeps_its_balance(law: Any, options: dict[str, Any]) -> None:
    """Its ball has a radius of some hundred discs there, and R - c z cancels."""
    theta = 0.004
    phi_dot = 2 * np.sqrt(9.81 / (0.036 * theta))
    start = {"theta": theta, "phi_dot": phi_dot, "omega3": -0.01} | ({"nu_x": 0.0} if law else {})
    disc = tt.Disc(m=0.44, ring=0.036, tube=0.0015)
    run = tt.run(disc, law, start=start, until=0.1, on_liftoff=None, **options)
    assert np.ptp(run.trajectory.theta.values) > 1e-5
    assert run.drift["energy_balance"] < 2e-15


# --- the tippe top ------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["vector", "euler"])
@pytest.mark.parametrize("law", [None, tt.friction.Viscous(mu=0.3)])
def test_a_round_spheroid_is_the_tippe_top(law: Any, form: str) -> None:
    assert_tippe_top(law, {"theta": 0.1, "omega3": 155.0}, form=form)


@pytest.mark.parametrize(
    "law", [tt.friction.Coulomb(mu=0.3), tt.friction.Contensou(mu=0.3, patch=5e-4, mu_r=1e-5)]
)
def test_a_round_spheroid_strikes_slips_and_rolls_as_the_tippe_top(law: Any) -> None:
    start = {"theta": 0.5, "omega3": 60.0, "gap": 1e-3}
    assert_tippe_top(law, start, contact={"e_n": 0.5})


def assert_tippe_top(law: Any, start: dict[str, float], **options: Any) -> None:
    """The same rows of a sphere, as its record and as a spheroid."""
    numbers = {"m": 0.02, "I1": 2.994e-6, "I3": 3.2e-6, "g": 9.82}
    tops = (
        tt.TippeTop(R=0.02, alpha=0.3, **numbers),
        tt.Spheroid(a=0.02, b=0.02, c=0.006, **numbers),
    )
    options = {"start": start, "until": 0.5, **options}
    one, two = (
        tt.run(top, law, system=top.resting if law is None else None, **options).trajectory
        for top in tops
    )
    for name in ("axis", "L", "energy", "modified_energy", "normal_force", "x", "orientation"):
        size = np.max(np.abs(one[name].values))
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-12 * size)


def test_thresholds_of_an_egg_are_those_of_its_regime() -> None:
    """Upright spin above sqrt(5 g a^3)/b^2 is stable under friction."""
    found = tt.theory.thresholds("spinning-egg")
    assert found["spin_upright"].value == pytest.approx(np.sqrt(5 * 9.81 * 0.03**3) / 0.02**2)
    assert tt.theory.thresholds("rolling-egg")["spin_upright"].value < 50


# --- presets ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rpm", "jumps"), [(1500, 0), (2000, 35)])
def test_an_egg_jumps_if_it_spins_fast_enough(rpm: int, jumps: int) -> None:
    run = tt.run("jumping-egg", start={"phi_dot": f"{rpm} rpm"})
    assert run.summary.event_counts.get("liftoff", 0) == jumps
    assert run.drift["energy_balance"] < 1e-13


def test_the_disc_of_euler_lies_flat_in_the_end() -> None:
    """Before, it goes round ever faster: phi'^2 sin(theta) is constant for small theta."""
    run = tt.run("euler-disc")
    assert run.summary.status == "ended"
    assert run.summary.event_counts["flat"] == 1
    assert run.drift["energy_balance"] < 1e-13
    last = run.trajectory.isel(time=slice(-200, None))
    scaled = np.sqrt(np.sin(last.theta)) * last.phi_dot
    assert float(last.phi_dot[-1]) > 500
    assert float(scaled.std() / scaled.mean()) < 0.02


@pytest.mark.parametrize(
    "law",
    [
        tt.friction.Viscous(mu=3.0, mu_r=2e-4, mu_d=2e-4),
        at_night(tt.friction.Contensou(mu=0.3, patch=4e-4, mu_r=4e-4)),
        at_night(tt.friction.Coulomb(mu=0.3, mu_r=4e-4, mu_d=2e-4)),
        at_night(tt.friction.Coulomb(mu=0.4, mu_r=5e-4)),
    ],
)
def test_a_disc_that_loses_energy_ends_flat(law: Any) -> None:
    disc = tt.Disc(m=0.1, ring=0.02, tube=0.001)
    start = {"theta": 0.3, "phi_dot": 48.0, "nu_x": 0.0}
    run = tt.run(disc, law, start=start, until=10.0)
    assert (run.summary.status, run.summary.event_counts["flat"]) == ("ended", 1)
    assert run.drift["energy_balance"] < 1e-13


# --- what surrounds a run -----------------------------------------------------------------------


def test_a_run_of_jumps_certifies_and_its_end_is_a_start(tmp_path: Path) -> None:
    law, store = tt.friction.Coulomb(mu=0.1), tmp_path / "a.zarr"
    run = tt.run(EGG, law, start={**JUMPS, "nu_x": 0.0}, until=0.3, out=store, contact={"e_n": 0.3})
    begins = tt.run(EGG, law, start=store, until=1e-3, contact={"e_n": 0.3}).trajectory.axis[0]
    np.testing.assert_array_equal(begins, run.trajectory.axis[-1])
    assert certificate_violations(run.certify()) == []


def test_derivatives_by_the_shape_are_those_of_differences() -> None:
    law, options = tt.friction.Viscous(mu=1.0), {"start": {"theta": 1.5, "phi_dot": 110.0}}
    found = tt.derivatives.sensitivities(EGG, ["a"], law, until=0.05, **options)
    step = 1e-6
    ends = [
        tt.run(EGG._replace(a=EGG.a + h), law, until=0.05, **options).trajectory.theta.values[-1]
        for h in (-step, step)
    ]
    by_a = float(found.trajectory.theta.sel(parameter="parameters.a").values[-1])
    assert by_a == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-6)


def test_the_ensemble_is_that_of_single_runs() -> None:
    spins, law = [60.0, 110.0], tt.friction.Viscous(mu=1.0)
    ends = tt.ensemble(EGG, {"phi_dot": spins}, law, start={"theta": 1.5}, until=1.0).theta_end
    for spin, end in zip(spins, ends.values, strict=True):
        start = {"theta": 1.5, "phi_dot": spin}
        alone = tt.run(EGG, law, start=start, until=1.0).trajectory.theta.values[-1]
        assert end == pytest.approx(alone, abs=1e-11)


@pytest.mark.parametrize(
    ("preset", "formats"), [("spinning-egg", ["urdf"]), ("rolling-coin", ["mjcf", "urdf", "sdf"])]
)
def test_no_file_has_a_ball_in_place_of_another_body(preset: str, formats: list[str]) -> None:
    for to in formats:
        with pytest.raises(tt.InputError, match=r"one that `.*` can express"):
            text_of(tt.load(preset), to)

"""Runs of bodies with an outline: against multi-precision references, closed forms, and the tippe
top; `test_surroundings.py` has them against Newton and Euler.
"""

from typing import Any

import numpy as np
import pytest
from examples import stored_reference
from limits import assert_near
from nightly import at_night
from refusals import refusal

import tippetop as tt
from tippetop.exchange.simulators import text_of


EGG = tt.Spheroid(m=0.06, a=0.03, b=0.02, c=0.0, I1=1.56e-5, I3=9.6e-6, g=9.81)
JUMPS = {"theta": 1.5, "phi_dot": 190.0}


# --- references ---------------------------------------------------------------------------------

KINDS = {"ring": tt.Disc, "delta": tt.Ellipsoid}
REFERENCE = {
    name: case
    for file in ("outlines", "ellipsoids")
    for name, case in stored_reference(file).items()
    if name != "source"
}
MOTIONS = [
    (name, form)
    for name, case in REFERENCE.items()
    if "rows" in case
    for form in (["vector"] if "delta" in case["parameters"] else ["vector", "euler"])
]


@pytest.mark.parametrize(("name", "form"), MOTIONS)
def test_a_motion_is_that_of_the_reference(name: str, form: str) -> None:
    """To rounding; errors grow where a rattleback reverses."""
    case = REFERENCE[name]
    tolerance = 1e-11 if name == "rattleback-rolling" else 1e-12
    kind = next((kind for key, kind in KINDS.items() if key in case["parameters"]), tt.Spheroid)
    law = tt.friction.Viscous(mu=case["mu"]) if case["mu"] else None
    times = [row[0] for row in case["rows"]]
    options = {"until": times[-1], "output_times": times, "form": form}
    rows = tt.run(kind(**case["parameters"]), law, start=case["initial"], **options).trajectory
    for i, (_, *expected) in enumerate(case["rows"]):
        found = [rows[n].values[i] for n in ("axis", "L", "energy", "normal_force", "x")]
        for mine, theirs in zip(found, expected, strict=True):
            assert_near(mine, theirs, tolerance, relative=True)


def test_an_egg_jumps_when_the_reference_does() -> None:
    options = {"start": JUMPS, "contact": {"e_n": 0.0}}
    phases = tt.run(EGG, tt.friction.Viscous(mu=1.0), until=0.3, **options).phases
    case = REFERENCE["spheroid-jump"]
    expected = [case["liftoff"], case["landing"]]
    assert_near(phases.end.values[:2], expected, 1e-15)


BOAT = tt.Ellipsoid(**tt.load("rattleback").parameters)
TURNS = {"theta": 1.0, "phi_dot": 20.0, "omega3": 10.0, "nu_x": 0.1, "gap": 1e-3}
ROCKS = {"tilt": 0.01, "roll": 0.02, "heading": 0.3, "spin": -5.0}
SKEW = {"theta": 0.01, "psi": 1 - BOAT.delta, "phi_dot": -5.0, "omega3": -5.0, "nu_x": 0.0}


@pytest.mark.parametrize(
    ("body", "law", "start", "until", "precision"),
    [
        *(
            as_often(EGG, law, TURNS, 0.2, precision)
            for law in (
                tt.friction.Coulomb(mu=0.3),
                tt.friction.Contensou(mu=0.3, patch=1e-4),
                tt.friction.Coulomb(mu=0.2, mu_r=1e-5),
            )
            for precision, as_often in (("double", pytest.param), ("longdouble", at_night))
        ),
        (BOAT, tt.friction.Coulomb(mu=0.05), ROCKS | {"gap": 1e-3}, 0.15, "double"),
        # it rolls, and slides for milliseconds
        (BOAT, tt.friction.Coulomb(mu=0.3), ROCKS | {"gap": 1e-3}, 0.15, "double"),
        # near the edge of the cone, where explicit steps were too stiff
        at_night(BOAT, tt.friction.Coulomb(mu=0.3), SKEW, 2.2, "double"),
    ],
)
def test_every_phase_keeps_its_balance(
    body: Any, law: Any, start: dict[str, float], until: float, precision: str
) -> None:
    run = tt.run(body, law, start=start, until=until, contact={"e_n": 0.4}, precision=precision)
    assert run.summary.status == "finished"
    assert run.summary.event_counts.get("impact", 0) > 0 or start is SKEW
    rounding = {"double": 1e-13 if body is BOAT else 1e-14, "longdouble": 1e-16}[precision]
    assert run.drift["energy_balance"] < rounding


# --- closed forms -------------------------------------------------------------------------------


def test_a_disc_that_falls_flat_ends_by_an_event() -> None:
    coin = tt.Disc(m=0.01, ring=0.02, tube=0.0, c=0.0, I1=1e-6, I3=2e-6, g=9.81)
    run = tt.run(coin, tt.friction.Frictionless(), start={"theta": 1.0, "omega3": 0.0}, until=1.0)
    assert run.summary.event_counts["flat"] == 1
    assert run.summary.status == "ended"
    for start in ({"theta": 0.0}, {"theta": np.pi}, {}):
        for options in ({}, {"on_liftoff": "fly"}):
            with refusal("lies flat"):
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


@pytest.mark.parametrize(
    ("preset", "formats"), [("spinning-egg", ["urdf"]), ("rolling-coin", ["mjcf", "urdf", "sdf"])]
)
def test_no_file_has_a_ball_in_place_of_another_body(preset: str, formats: list[str]) -> None:
    for to in formats:
        with refusal(r"one that `.*` can express"):
            text_of(tt.load(preset), to)

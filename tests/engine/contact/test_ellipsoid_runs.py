"""Runs of bodies without an axis of symmetry: against closed forms, mirror images, and the tippe
top; `test_outlined_runs.py` has them against multi-precision references, and `test_surroundings.py`
against Newton and Euler.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from measured import written
from refusals import refusal

import tippetop as tt
from tippetop.friction import Coulomb, Viscous
from tippetop.runs.certificate import certificate_violations


BOAT = tt.Ellipsoid(**tt.load("rattleback").parameters)
START = {"tilt": 0.01, "roll": 0.02, "heading": 0.3, "spin": -5.0}
EULER = {"theta": 0.2, "phi": 0.3, "psi": 1.0, "phi_dot": -5.0, "omega3": -4.0}


# --- phases, closed forms and limits ------------------------------------------------------------


@pytest.mark.parametrize(("name", "half", "inertia"), [("tilt", "a", "I2"), ("roll", "b", "I1")])
def test_a_resting_boat_rocks_with_two_frequencies(name: str, half: str, inertia: str) -> None:
    """Rolling with delta = 0: omega^2 = m g (r - k)/(I + m k^2), k the height, r the radius."""
    boat, k = BOAT._replace(delta=0.0), BOAT.c - BOAT.h
    start = {name: 1e-6, "spin": 0.0}
    times = tt.run(boat, start=start, until=5.0, events=[f"{name}_peak"]).events.time.values
    r, I = getattr(boat, half) ** 2 / boat.c, getattr(boat, inertia)
    omega = np.sqrt(boat.m * boat.g * (r - k) / (I + boat.m * k**2))
    np.testing.assert_allclose(np.diff(times), np.pi / omega, rtol=1e-6)


BALL = {"m": 0.02, "g": 9.82, "I1": 2.994e-6, "I3": 3.2e-6}
ROUND = [
    tt.Spheroid(a=0.02, b=0.02, c=0.006, **BALL),
    tt.Ellipsoid(a=0.02, b=0.02, c=0.02, delta=0.4, x=0.0, y=0.0, h=0.006, I2=BALL["I1"], **BALL),
]


@pytest.mark.parametrize("law", [None, Viscous(mu=0.3), Coulomb(mu=0.3)])
@pytest.mark.parametrize("other", ROUND, ids=lambda other: type(other).__name__)
def test_a_round_body_is_the_tippe_top(other: Any, law: Any) -> None:
    """It rolls, glides, or falls, strikes, slides and rolls."""
    top = tt.TippeTop(R=0.02, alpha=0.3, **BALL)
    options: dict[str, Any] = {"start": {"theta": 0.5, "psi": 0.3, "omega3": 60.0}, "until": 0.5}
    if law and law.key == "coulomb":
        options["start"]["gap"], options["contact"] = 1e-3, {"e_n": 0.5}
    one, two = (
        tt.run(body, law, system=body.resting if law is None else None, **options).trajectory
        for body in (top, other)
    )
    for name in ("axis", "L", "energy", "normal_force", "x", "orientation"):
        assert_near(two[name], one[name], 1e-12, name, relative=True)


@pytest.mark.parametrize("law", [None, Viscous(mu=3.0), Coulomb(mu=0.1)])
def test_mirror_images_are_exact(law: Any) -> None:
    """(phi, psi, phi', omega_3, nu_y, delta, y) -> -(...); no bit differs."""
    start = EULER | ({"nu_y": 0.1} if law else {})
    image = {n: v if n == "theta" else -v for n, v in start.items()}
    top, other = BOAT._replace(y=2e-3), BOAT._replace(delta=-BOAT.delta, y=-2e-3)
    one, two = (
        tt.run(t, law, start=s, until=0.5).trajectory for t, s in ((top, start), (other, image))
    )
    for name, sign in {"theta": 1, "spin": -1, "energy": 1, "tilt": 1, "roll": -1, "y": -1}.items():
        np.testing.assert_array_equal(two[name].values, sign * one[name].values)


# --- what surrounds a run -----------------------------------------------------------------------


def test_a_run_certifies_and_its_end_is_a_start(tmp_path: Path) -> None:
    law, store = Coulomb(mu=0.1), tmp_path / "a.zarr"
    run = tt.run(BOAT, law, start=START, until=0.03, out=store)
    begins = tt.run(BOAT, law, start=store, until=1e-3).trajectory.orientation[0]
    np.testing.assert_array_equal(begins, run.trajectory.orientation[-1])
    assert certificate_violations(run.certify()) == []


def test_both_ways_to_start_are_one_and_lanes_are_runs() -> None:
    spins = [-3.0, -2.0]
    ends = tt.ensemble(BOAT, {"spin": spins}, start=START, until=3.0)
    for k, spin in enumerate(spins):
        run = tt.run(BOAT, start=START | {"spin": spin}, until=3.0)
        assert float(ends.reversed_at[k]) == pytest.approx(run.summary.kept["reversed_at"], 1e-9)
        row = run.trajectory.isel(time=0)
        for name, value in (START | {"spin": spin}).items():
            assert float(row[name]) == pytest.approx(value, abs=1e-15)
        start = {name: float(row[name]) for name in (*EULER, "theta_dot")}
        again = tt.run(BOAT, start=start, until=1e-3).trajectory.L.values[0]
        assert_near(again, row.L, 1e-13, relative=True)


@pytest.mark.slow
def test_numbers_of_a_film_are_fitted_and_an_exported_run_is_compared(tmp_path: Path) -> None:
    t = np.linspace(0.05, 1.0, 20)
    scenario = tt.run(BOAT, Viscous(mu=3.0), start=START, until=1.0, output_times=[*t])
    film = {"t [s]": t, "q_w,q_x,q_y,q_z": scenario.trajectory.orientation}
    written(tmp_path / "film.csv", film)
    guess = BOAT._replace(delta=1.01 * BOAT.delta), Viscous(mu=3.1)
    problem = tt.run(*guess, start=START, until=1e-3).problem
    free = ["friction.mu", "parameters.delta"]
    fit = tt.fit(tmp_path / "film.csv", problem, free, systematic=False)
    assert fit.trustworthy
    assert fit.estimates["friction.mu"].value == pytest.approx(3.0, rel=1e-9)
    assert fit.estimates["friction.mu"].sigma < 1e-6
    scenario.export(tmp_path / "run.csv")
    (found,) = tt.compare(tmp_path / "run.csv", scenario).motions
    assert max(found.curves[name].max() for name in ("attitude", "place")) < 1e-14


def run_boat(law: Any, **more: Any) -> Any:
    return tt.run(BOAT, law, start=START, until=0.1, **more)


@pytest.mark.parametrize(
    ("word", "refused"),
    [
        ("mu_r", lambda: run_boat(Coulomb(mu=0.3, mu_r=1e-4))),
        ("contensou", lambda: run_boat(tt.friction.Contensou(mu=0.3, patch=1e-3))),
        ("stem", lambda: run_boat(Viscous(mu=3.0), stem={"r": 1e-3, "h": 0.03})),
        ("Painleve", lambda: run_boat(Coulomb(mu=9.0))),
        ("TippeTop", lambda: tt.theory.thresholds(BOAT)),
        ("I1", lambda: tt.Ellipsoid(**{**BOAT._asdict(), "I1": 1.0})),
        ("uniform", lambda: tt.Ellipsoid(m=1, a=0.2, b=0.03, c=0.02, h=0.01)),
        ("inside of the body", lambda: tt.Ellipsoid(**{**BOAT._asdict(), "x": 0.2})),
        ("inside of the body", lambda: tt.Spheroid(m=1, a=0.2, b=0.3, c=-0.2, I1=1, I3=1)),
        ("given alone", lambda: tt.run(BOAT, start=START | {"theta": 0.1}, until=0.1)),
    ],
)
def test_what_does_not_fit_such_bodies_is_refused(word: str, refused: Callable) -> None:
    with refusal(word):
        refused()

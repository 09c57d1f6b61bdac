"""The tables [air] and [plane]: what is read, refused, and withheld."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refusal

import tippetop as tt


AIR = {"c1": "1e-8 N m s", "c2": 1e-10}
PLANE = {"tilt": "1 deg", "azimuth": 0.3}
AROUND: dict[str, Any] = {"air": AIR, "plane": PLANE}


SHAKES = {"plane": PLANE | {"amplitude": "0.1 mm", "frequency": "30 Hz"}}


@pytest.mark.parametrize("around", [AROUND, SHAKES], ids=["tilted", "vibrating"])
@pytest.mark.parametrize("preset", ["flying", "rolling"])
def test_surroundings_pass_through_pickles_stores_and_resumes(
    preset: str, around: dict[str, Any], tmp_path: Path
) -> None:
    whole = tt.run(preset, **around, until=0.3)
    problem = whole.problem
    again = pickle.loads(pickle.dumps(problem))
    assert again.surroundings == problem.surroundings
    assert again.system is problem.system
    assert problem.surroundings["plane.tilt"] == np.pi / 180
    stored = tt.run(preset, **around, until=0.2, out=tmp_path / "r.zarr")
    assert stored.problem.surroundings == problem.surroundings
    again = tt.resume(tmp_path / "r.zarr", until=0.3)
    assert again.attributes["report"]["theta_end"] == whole.attributes["report"]["theta_end"]
    assert tt.run(problem).trajectory.equals(whole.trajectory)
    with refusal("`plane` must be that of"):
        tt.run(preset, start=tmp_path / "r.zarr", plane={"omega": 1.0}, until=0.1)


@pytest.mark.parametrize(
    "around",
    [
        {"air": {}},
        {"plane": {}},
        {"plane": {"omega": 0}},
        {"plane": dict(amplitude=0, frequency=9)},
    ],
)
@pytest.mark.parametrize("preset", ["flying", "rolling"])
def test_surroundings_that_do_nothing_change_nothing(preset: str, around: Any) -> None:
    one = tt.run(preset, until=0.3).trajectory
    other = tt.run(preset, **around, until=0.3).trajectory
    for name in ("theta", "x", "y", "normal_force"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-11, atol=1e-13, err_msg=name)


@pytest.mark.parametrize("preset", ["inverting", "rolling"])
def test_tops_of_an_ensemble_have_surroundings_of_their_own(preset: str) -> None:
    tilts = np.array([0.0, 0.05])
    found = tt.ensemble(preset, {"plane.tilt": tilts}, plane={}, air=AIR, until=0.3)
    for tilt, theta in zip(tilts, found.theta_end.values, strict=True):
        alone = tt.run(preset, plane={"tilt": float(tilt)}, air=AIR, until=0.3)
        assert np.isclose(alone.attributes["report"]["theta_end"], theta, rtol=1e-12)
    assert {*found["class"].values} == {found["class"].flag_meanings.split().index("under-way")}


def test_numbers_of_another_plane_do_not_vary() -> None:
    turns: dict[str, Any] = {"plane": {"omega": 1.0}, "until": 0.1}
    for ask in (
        lambda: tt.ensemble("inverting", {"plane.tilt": [0.0, 0.1]}, **turns),
        lambda: tt.derivatives.sensitivities("inverting", ["plane.tilt"], **turns),
    ):
        with refusal(r"Give the scenario a `plane\.tilt`"):
            ask()


@pytest.mark.parametrize("omega", [3.0, -30.0])
def test_a_slide_from_rest_on_a_turntable_keeps_the_balance_of_energy(omega: float) -> None:
    plane = {"omega": omega, "x": 1.0}
    start = {"theta": 0.1, "omega3": 155.0, "nu_x": 0.0}
    run = tt.run("inverting", tt.friction.Coulomb(mu=0.2), plane=plane, start=start, until=0.02)
    assert run.attributes["report"]["contact_phases"]["counts"] == {"slip": 1}
    assert run.attributes["report"]["drift"]["energy_balance"] < 1e-13
    # at first the centre moves as the forces at rest turn it: outwards, and by Coriolis' to a side
    slow = tt.run("inverting", tt.friction.Coulomb(0.2, 1e-7), plane=plane, start=start, until=0.02)
    for name in ("x", "y", "theta"):
        one, other = (each.trajectory[name].values[-1] for each in (run, slow))
        assert np.isclose(one, other, rtol=1e-5, atol=1e-9)


REFUSED = {
    "fixed tip": ("heavy-top", {"air": AIR}, "`air` must be of a tippe-top"),
    "name": ("inverting", {"air": {"c3": 1.0}}, "The keys of `air` are c1, c2"),
    "other groups": ("inverting", {"plane": {"omeg": 1}}, "did you mean `plane.omega`"),
    "overflow": (
        "inverting",
        {"plane": {"amplitude": 1e-3, "frequency": 1e200}},
        "`plane` and `initial` must stay finite together",
    ),
    "interval": ("inverting", {"plane": {"tilt": 1.6}}, "must be less than 1.5"),
    "sign": ("inverting", {"air": {"c1": -1.0}}, "must be at least 0"),
    "form": ("rolling", {"air": AIR, "form": "reduced"}, "`form` must be 'auto' or 'vector'"),
    "turns and falls": ("inverting", {"plane": {"omega": 1, "tilt": 0}}, "must be level"),
    "turns a cylinder": ("gliding-cylinder", {"plane": {"omega": 1}}, "no cylinder"),
    "sideways": ("gliding-cylinder", {"plane": {"azimuth": 1}}, "must be 0 for a cylinder"),
    "frequency": ("inverting", {"plane": {"amplitude": 1e-4}}, "`plane.frequency` must be given"),
    "settled": ("inverting", {"air": AIR, "stop_when": "settled"}, 'must be "until" in air'),
}


@pytest.mark.parametrize(("preset", "given", "words"), REFUSED.values(), ids=REFUSED)
def test_wrong_surroundings_are_refused_in_a_sentence(
    preset: str, given: dict[str, Any], words: str
) -> None:
    with refusal(words):
        tt.run(preset, until=0.1, **given)


def test_theory_of_a_level_plane_in_still_air_is_withheld() -> None:
    run = tt.run("inverting", **AROUND, until=0.1)
    rolled = tt.run("rolling", **AROUND, until=0.1)
    assert run.attributes["report"]["outcome"] == "under-way"
    for ask in (
        lambda: tt.theory.thresholds(run),
        lambda: tt.theory.linear_modes(run, omega3=100.0),
        lambda: tt.theory.reconstruct(rolled),
        lambda: tt.landscapes.minimal_surface(run, D=0.0, lam=1e-6),
        lambda: run.plot("band"),
        lambda: run.plot("states"),
    ):
        with refusal("on a level plane at rest in still air"):
            ask()


def test_exports_tilt_gravity_and_refuse_air(tmp_path: Path) -> None:
    from tippetop.exchange.simulators import text_of

    problem = tt.run("inverting", plane=PLANE, until=0.1).problem
    tilt, g = np.pi / 180, problem.parameters["g"]
    expected = g * np.array([np.sin(tilt) * np.cos(0.3), np.sin(tilt) * np.sin(0.3), -np.cos(tilt)])
    text = text_of(problem, "mjcf")
    found = text.partition('gravity="')[2].partition('"')[0].split()
    np.testing.assert_allclose([float(part) for part in found], expected, rtol=1e-11)
    with refusal(r"in still air, but has `air\.c1`, which must be removed"):
        text_of(tt.run("inverting", air=AIR, until=0.1).problem, "mjcf")


def test_a_page_names_the_plane_in_whose_axes_it_shows_the_body() -> None:
    page = tt.run("inverting", plane=PLANE, until=0.1).view().text
    assert "in the axes of the plane: tilt = 0.01745 rad, azimuth = 0.3 rad." in page

"""What people measure on a real top: a chip in the body, cameras, a tachometer. The reference is an
own engine: rotation matrix and momentum in space, finite differences of places, and pinhole
cameras.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tilted
from limits import assert_below
from measured import written
from nightly import at_night
from refusals import refusal
from scipy.integrate import solve_ivp

import tippetop as tt
from tippetop.exchange.motion import turned


M, R, C, I1, I3, G, MU = 0.02, 0.02, 0.006, 2.994286e-6, 3.2e-6, 9.82, 0.3
UP = np.array([0.0, 0.0, 1.0])
TOP = tt.TippeTop(m=M, R=R, alpha=C / R, I1=I1, I3=I3, g=G)
ARM = np.array([0.004, -0.003, 0.01])
H = 1e-4
SCENARIO = {
    "system": "tippe-top",
    "parameters": TOP._asdict(),
    "friction": {"law": "viscous", "mu": MU},
    "initial": dict(theta=0.3, omega3=155.0, psi=0.7, centre_at_rest=True),
    "run": {"until": 1.0},
}


def times_around(t: np.ndarray) -> np.ndarray:
    """Return five times around each, for differences."""
    return np.ravel(t[:, None] + H * np.arange(-2, 3))


def felt_by(chip: np.ndarray, places: np.ndarray, turns: np.ndarray, gravity: Any) -> np.ndarray:
    """Return what an accelerometer reads at the middle of five times, in axes of the body."""
    p = places + turns @ chip
    bent = (-p[:, 0] + 16 * p[:, 1] - 30 * p[:, 2] + 16 * p[:, 3] - p[:, 4]) / (12 * H**2)
    return np.einsum("nji,nj->ni", turns[:, 2], bent - gravity)


@pytest.fixture(scope="module")
def film() -> dict[str, np.ndarray]:
    """Columns of a measured motion for 0.4 s, SI."""
    start = [[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]]
    about = [[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]]
    turn = np.array(start) @ np.array(about)
    place = [0, 0, R - C * turn[2, 2]]
    s = np.concatenate([place, np.zeros(3), I3 * 155.0 * turn[:, 2], turn.ravel(), [0.0]])
    t = np.linspace(0.01, 0.4, 40)
    rates = tilted.motion(tilted.sliding(lambda v: MU), tilted.body_of(TOP))
    found = solve_ivp(rates, (0, 0.41), s, "DOP853", times_around(t), rtol=1e-13, atol=1e-15).y.T
    found = found.reshape(40, 5, -1)
    turns, places = found[..., 9:18].reshape(40, 5, 3, 3), found[..., :3]
    moved = (turns[:, 0] - 8 * turns[:, 1] + 8 * turns[:, 3] - turns[:, 4]) / (12 * H)
    in_space = moved @ turns[:, 2].transpose(0, 2, 1)
    in_body = turns[:, 2].transpose(0, 2, 1) @ moved
    axes = [(2, 1), (0, 2), (1, 0)]
    columns = {"t [s]": t}
    for c, (i, k), n in zip("xyz", axes, range(3), strict=True):
        columns[f"omega_body_{c} [rad/s]"] = in_body[:, i, k]
        columns[f"omega_{c} [rad/s]"] = in_space[:, i, k]
        columns[f"accelerometer_{c} [m/s^2]"] = felt_by(ARM, places, turns, -G * UP)[:, n]
        columns[f"centre_{c}"] = felt_by(0 * ARM, places, turns, -G * UP)[:, n]
    columns["omega3 [rpm]"] = in_body[:, 1, 0] * 60 / (2 * np.pi)
    columns |= {"x [m]": places[:, 2, 0], "y [m]": places[:, 2, 1]}
    for azimuth, elevation in ((0, 0), (90, 0), (-37.5, 20)):
        name = f"camera_{azimuth}" + (f"_{elevation}" if elevation else "")
        columns[f"{name} [deg]"] = np.rad2deg(seen(turns[:, 2, :, 2], azimuth, elevation))
    return columns


def seen(axis: np.ndarray, azimuth: float, elevation: float) -> np.ndarray:
    """The direction of a short rod along the axis in the picture of a pinhole camera 1 km away."""
    a, e = np.deg2rad([azimuth, elevation])
    camera = 1e3 * np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    ahead = -camera / 1e3
    right = np.cross(ahead, UP)
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)

    def pixel(point: np.ndarray) -> np.ndarray:
        ray = point - camera
        return np.stack([ray @ right, ray @ up], axis=1) / (ray @ ahead)[:, None]

    x, y = (pixel(1e-3 * axis) - pixel(0 * axis)).T
    return np.arctan2(x, y)


def table(folder: Path, columns: dict[str, np.ndarray], *kinds: str) -> Path:
    chosen = {name: c for name, c in columns.items() if name.startswith(("t ", *kinds))}
    return written(folder / "film.csv", chosen)


@pytest.mark.parametrize(
    ("kinds", "most"),
    [
        (("x", "y", "omega_body", "omega_x", "omega_y", "omega_z", "omega3"), 1e-6),
        (("x", "y", "camera"), 1e-6),
        (("x", "y", "accelerometer"), 1e-4),
    ],
)
def test_each_column_is_that_of_an_own_engine(
    film: dict[str, np.ndarray], tmp_path: Path, kinds: tuple[str, ...], most: float
) -> None:
    found = tt.compare(table(tmp_path, film, *kinds), SCENARIO, chip=ARM).to_dict()
    errors = {name: found[name]["max"] for name in found if isinstance(found[name], dict)}
    assert len(errors) >= len({kind.partition("_")[0] for kind in kinds}) - 1
    assert_below(most, errors, "error")


def test_the_chip_is_at_the_centre_of_mass_by_default(
    film: dict[str, np.ndarray], tmp_path: Path
) -> None:
    centre = {name: film[name] for name in ("t [s]", "x [m]")}
    centre |= {f"accelerometer_{c} [m/s2]": film[f"centre_{c}"] for c in "xyz"}
    path = table(tmp_path, centre, "x", "accelerometer")
    found = [tt.compare(path, SCENARIO, chip=chip).to_dict() for chip in (None, "0.001,0,0")]
    assert found[0]["accelerometer"]["max"] < 1e-4
    assert found[1]["accelerometer"]["max"] > 20  # omega^2 times 1 mm


def test_a_fit_to_a_chip_and_a_camera_finds_the_numbers_of_the_own_engine(
    film: dict[str, np.ndarray], tmp_path: Path
) -> None:
    some = {name: values[::4] for name, values in film.items()}
    path = table(tmp_path, some, "omega_body", "accelerometer", "camera_0")
    guess = SCENARIO | {
        "friction": {"law": "viscous", "mu": 0.33},
        "initial": SCENARIO["initial"] | {"omega3": 152.0, "psi": 0.6},
    }
    free = ["friction.mu", "initial.omega3", "initial.psi"]
    found = tt.fit(path, guess, free, starts=1, within=0.2, chip=ARM, systematic=False)
    assert set(found.residuals) == {"gyroscope", "accelerometer", "camera_0"}
    for name, true in zip(free, (MU, 155.0, 0.7), strict=True):
        assert found.estimates[name].value == pytest.approx(true, rel=1e-5), name


SEMI_AXES = {  # of an ellipsoid, its turn about body axis 3, and the height of its centre
    "spinning-egg": ([0.02, 0.02, 0.03], 0.0, 0.0),
    "rattleback": ([0.2, 0.03, 0.02], -0.01428182891938001, 0.01),
}


CASES = [("heavy-top", 0.0), ("rolling", 0.2), ("flying", 0.0), ("rattleback", 0.0)]
CASES += [at_night(*case) for case in (("rolling", 0.0), ("flying", 0.2), ("rattleback", 0.2))]
CASES += [("gliding-cylinder", 0.0), ("spinning-egg", 0.2), at_night("spinning-egg", 0.0)]


@pytest.mark.parametrize(("preset", "tilt"), CASES)
def test_a_chip_is_where_places_and_attitudes_of_a_run_have_it(
    preset: str, tilt: float, tmp_path: Path
) -> None:
    """Where the contact may change it is at the centre of mass; z is the normal of the plane."""
    chip = ARM * (preset != "flying" and (preset, tilt) != ("spinning-egg", 0.2))
    t = np.linspace(0.05, 0.09, 5)
    times = times_around(t)
    changes = [f"plane.tilt={tilt}", "plane.azimuth=0.5"] if tilt else []
    top = tt.load(preset, [*changes, "form=euler"] if preset == "heavy-top" else changes)
    run = tt.run(tt.load(preset, [*changes, f"run.output_times={times.tolist()}"], 0.1))
    rows, body = run.trajectory, run.problem.body()
    turns = np.stack([turned(rows.orientation.values, e) for e in np.eye(3)], axis=2)
    down = np.array([np.sin(tilt) * np.cos(0.5), np.sin(tilt) * np.sin(0.5), -np.cos(tilt)])
    gravity = run.problem.parameters["g"] * down
    up = turns[:, 2]  # in body axes
    if "z" in rows:
        height = rows["z"].values
    elif preset in SEMI_AXES:
        half, delta, centre = SEMI_AXES[preset]
        k, n = np.cos(delta), np.sin(delta)
        own = up @ np.array([[k, -n, 0], [n, k, 0], [0, 0, 1]])
        height = np.linalg.norm(own * half, axis=1) - centre * up[:, 2]
    else:
        height = body.R - body.c * up[:, 2]
    if preset == "heavy-top":
        place = -body.c * turns[:, :, 2]
    else:
        place = np.stack([rows.x, rows.get("y", 0 * rows.x), height], axis=1)
    felt = felt_by(chip, place.reshape(5, 5, 3), turns.reshape(5, 5, 3, 3), gravity)
    columns = {"t [s]": t, "theta [rad]": rows.theta.values[2::5]}
    columns |= {f"accelerometer_{c} [m/s2]": felt[:, n] for n, c in enumerate("xyz")}
    path = table(tmp_path, columns, "theta", "accelerometer")
    found = tt.compare(path, top, chip=chip).to_dict()
    assert found["accelerometer"]["max"] < 1e-6 * np.abs(felt).max()


def test_a_chip_off_the_centre_of_mass_is_refused_where_the_contact_may_open(
    film: dict[str, np.ndarray], tmp_path: Path
) -> None:
    path = table(tmp_path, film, "x", "accelerometer")
    with refusal("`chip` must be 0,0,0 to be compared where the contact"):
        tt.compare(path, "flying", chip=ARM)
    with refusal("`chip` must be three lengths x,y,z"):
        tt.compare(path, "flying", chip="1,2")


IN_SPACE = tuple(f"omega_{c}" for c in "xyz")  # psi has no effect on it


@pytest.mark.parametrize(("kinds", "count"), [at_night(["omega_body"], 3), at_night(IN_SPACE, 2)])
def test_a_gyroscope_is_fitted_where_the_contact_may_open(
    film: dict[str, np.ndarray], tmp_path: Path, kinds: tuple[str, ...], count: int
) -> None:
    guess = SCENARIO | {"initial": SCENARIO["initial"] | {"omega3": 154.0, "psi": 0.69}}
    guess |= {"run": {"until": 1.0, "on_liftoff": "fly"}}
    true = {"parameters.I1": I1, "initial.omega3": 155.0, "initial.psi": 0.7}
    free = list(true)[:count]
    found = tt.fit(table(tmp_path, film, *kinds), guess, free, starts=1, within=0.01)
    for name in free:
        assert found.estimates[name].value == pytest.approx(true[name], rel=1e-5), name
    path = table(tmp_path, film, "accelerometer")
    with refusal("an accelerometer is fitted only where the contact never"):
        tt.fit(path, guess, free)
    smooth = SCENARIO | {"friction": {"law": "coulomb", "mu": MU, "eps": 0.01}}
    assert not tt.fit(path, smooth, free[:1], starts=1).influences  # the contact might open

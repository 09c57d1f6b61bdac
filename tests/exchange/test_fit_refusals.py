"""What a fit refuses before it computes, and what its words leave: no measurement is lost, no
number is a pretence.
"""

from pathlib import Path

import numpy as np
import pytest
from measured import AXIS, written
from nightly import at_night

import tippetop as tt
from tippetop.errors import InputError
from tippetop.exchange.observation import Observation, observed


def film(folder: Path, *rows: str) -> Path:
    """Write a table of times and angles."""
    path = folder / "film.csv"
    path.write_text("\n".join(["t [s],theta [deg]", *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("rows", "free", "words"),
    [
        (
            ["-1,5", "0,5", "1,5"],
            "friction.mu",
            r"begin at -1 s: shift them, or let `time\.offset`",
        ),
        (
            ["0,5", "0.1,5", "0.2,5"],
            "initial.phi",
            "`initial.phi` must change the measurements, but has no effect on them",
        ),
        (
            ["0,5", "0.1,5", "0.2,5"],
            "run.til",
            r"parameters\.m, .*initial\.psi, but is not|but is none",
        ),
        (
            ["0,5.7", "33,5.6", "9000,5.8"],
            "friction.mu",
            r"must be at most .* but is 9000 s \(2\.5 hours\): is `t` in ms\?",
        ),
    ],
)
def test_what_cannot_be_fitted_is_a_sentence(
    tmp_path: Path, rows: list[str], free: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        tt.fit(film(tmp_path, *rows), "inverting", free)


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        (None, r"3\.17894 rad \(182\.14 deg\) in row 3: noise may explain it \(--noise\)"),
        (
            "0.3 deg",
            r"\(182\.14 deg\) in row 3: noise may explain it \(--noise\)",
        ),
        ("1 deg", ""),
        ("0 deg", "`noise` must be an angle between 0 and pi"),
        ("1 m", "`noise` must be in rad"),
    ],
)
def test_noise_explains_angles_beyond_the_poles(
    tmp_path: Path, noise: str | None, words: str
) -> None:
    path = film(tmp_path, "0,179", "0.1,-0.6", "0.2,182.14", "0.3,180.5")

    def read() -> Observation:
        return observed(path, tt.load("inverting"), ["friction.mu"], noise=noise)

    if words:
        with pytest.raises(InputError, match=words):
            read()
    else:
        assert np.rad2deg(read().groups["theta"][2, 0]) == pytest.approx(182.14)


@pytest.mark.parametrize(("first", "offset"), [(-1.0, 1.0), (12.3, -12.3), (0.02, 0.0)])
def test_a_clock_that_is_free_starts_where_the_table_begins_near_the_start_of_the_motion(
    tmp_path: Path, first: float, offset: float
) -> None:
    path = film(tmp_path, *(f"{first + k},5" for k in range(3)))
    free = ["time.offset"]
    observation = observed(path, tt.load("inverting"), free)
    assert observation.start() == {"time.offset": offset}


ATTITUDES = {  # columns that a row may lack, and the measurement that they make of it
    "phi [rad]": "axis",
    AXIS: "axis",
    "q_w,q_x,q_y,q_z": "orientation",
}


@pytest.mark.parametrize("head", ["phi [rad]", *map(at_night, list(ATTITUDES)[1:])])
def test_theta_counts_in_every_row_that_lacks_a_fuller_attitude(head: str, tmp_path: Path) -> None:
    """A wrong theta in such a row cannot hide; the report counts the rows."""
    t = np.arange(11) / 60
    rows = tt.run("heavy-top", until=t[-1], output_times=t).trajectory
    whole = {"phi": rows.phi, "axis": rows.axis, "orientation": rows.orientation}
    name = "phi" if head == "phi [rad]" else ATTITUDES[head]
    fuller = np.where(np.arange(11)[:, None] % 5 == 0, whole[name].values.reshape(11, -1), np.nan)
    theta = rows.theta.values
    path = tmp_path / "table.csv"
    free = ["initial.omega3"]
    how = {"within": 0.05, "systematic": False, "starts": 1}
    written(path, {"t [s]": t, "theta [rad]": theta, head: fuller})
    right = tt.fit(path, "heavy-top", free, **how)
    assert "the residuals" not in right.reason
    assert f"rows used: {ATTITUDES[head]} 3, theta 8 of 11" in str(right)
    kinds = {kind: np.isfinite(off).all(axis=1).sum() for kind, off in right.residuals.items()}
    assert right.to_dict()["rows_used"] == kinds == {ATTITUDES[head]: 3, "theta": 8}
    theta = np.where(np.arange(11) % 5 == 0, theta, theta + 0.01 * (-1) ** np.arange(11))
    written(path, {"t [s]": t, "theta [rad]": theta, head: fuller})
    wrong = tt.fit(path, "heavy-top", free, noise="0.1 deg", **how)
    assert "the residuals of theta are larger than the stated noise" in wrong.reason


@pytest.mark.parametrize(
    ("header", "kind"), [("x [m],y [m]", "place"), ("theta [rad],phi [rad]", "phi")]
)
def test_a_cell_counts_where_its_neighbour_is_missing(
    header: str, kind: str, tmp_path: Path
) -> None:
    t = np.arange(9) / 100
    rows = tt.run("inverting", until=t[-1], output_times=t).trajectory
    both = np.stack([rows[name.partition(" ")[0]] for name in header.split(",")], axis=1)
    both[3:, 0], both[:2, 1] = np.nan, np.nan
    columns = {"t [s]": t, header: both, "omega3 [rad/s]": rows.omega3}
    found = tt.fit(
        written(tmp_path / "table.csv", columns),
        "inverting",
        "friction.mu",
        starts=1,
        within=0.05,
        systematic=False,
    )
    off = found.residuals[kind]
    assert np.isfinite(off).sum() == {"place": 3 + 7, "phi": 6}[kind]
    assert np.nanmax(np.abs(off)) < 1e-12
    assert found.to_dict()["rows_used"][kind] == {"place": 9, "phi": 6}[kind]


def test_parts_of_an_attitude_are_refused_with_their_time(tmp_path: Path) -> None:
    axis = np.array([[0, 0, 1], [0, 0, 1], [0, 0, np.nan], [0, 0, 1]])
    film = written(tmp_path / "table.csv", {"t [s]": np.arange(4) / 10, AXIS: axis})
    with pytest.raises(InputError, match=r"all 3 numbers of the axis .* are missing at 0\.2 s"):
        tt.fit(film, "heavy-top", "initial.omega3")

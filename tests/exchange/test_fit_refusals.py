"""What a fit refuses before it computes, and what its words leave: no measurement is lost, no
number is a pretence.
"""

from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.errors import InputError
from tippetop.exchange import measurements


@pytest.fixture
def film(tmp_path: Path) -> Path:
    path = tmp_path / "film.csv"
    path.write_text("t [s],theta [deg]\n0,5.7\n0.1,5.6\n0.2,5.8\n0.3,5.6\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "free", "words"),
    [
        (
            "t [s],theta [deg]\n-1,5\n0,5\n1,5\n",
            "friction.mu",
            r"begin at -1 s: shift them, or let `time\.offset`",
        ),
        (
            "t [s],theta [deg]\n0,5\n0.1,5\n0.2,5\n",
            "initial.phi",
            "`initial.phi` must change the measurements, but has no effect on them",
        ),
        (
            "t [s],theta [deg]\n0,5\n0.1,5\n0.2,5\n",
            "run.til",
            r"parameters\.m, .*initial\.psi, but is not|but is none",
        ),
        (
            "t [s],theta [deg]\n0,5.7\n33,5.6\n9000,5.8\n",
            "friction.mu",
            r"must be at most .* but is 9000 s \(2\.5 hours\): is `t` in ms\?",
        ),
    ],
)
def test_what_cannot_be_fitted_is_a_sentence(
    tmp_path: Path, text: str, free: str, words: str
) -> None:
    path = tmp_path / "film.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        tt.fit(path, "inverting", free)


@pytest.mark.parametrize(
    "changes",
    [
        ["friction.law=contensou", "friction.patch=1e-4"],
        ["friction.law=coulomb"],
        ['run.on_liftoff="fly"'],
    ],
)
def test_laws_and_contacts_without_fits_are_not_supported_yet(
    film: Path, changes: list[str]
) -> None:
    scenario = tt.load("inverting", [*changes, "friction.mu=0.3"])
    with pytest.raises(
        InputError,
        match="exact Coulomb friction, stems and hops are not supported yet: give a smooth",
    ):
        tt.fit(film, scenario, "friction.mu")


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
    path = tmp_path / "film.csv"
    path.write_text("t [s],theta [deg]\n0,179\n0.1,-0.6\n0.2,182.14\n0.3,180.5\n", encoding="utf-8")

    def observed() -> measurements.Observation:
        scenario, convention = tt.load("inverting"), measurements.Convention()
        return measurements.observation_of(scenario, path, ["friction.mu"], convention, None, noise)

    if words:
        with pytest.raises(InputError, match=words):
            observed()
    else:
        assert np.rad2deg(observed().groups["theta"][2, 0]) == pytest.approx(182.14)


@pytest.mark.parametrize(("first", "offset"), [(-1.0, 1.0), (12.3, -12.3), (0.02, 0.0)])
def test_a_clock_that_is_free_starts_where_the_table_begins_near_the_start_of_the_motion(
    tmp_path: Path, first: float, offset: float
) -> None:
    path = tmp_path / "film.csv"
    path.write_text(
        f"t [s],theta [deg]\n{first},5\n{first + 1},5\n{first + 2},5\n", encoding="utf-8"
    )
    free = ["time.offset"]
    assert measurements.observation_of(
        tt.load("inverting"), path, free, measurements.Convention(), None
    ).start() == {"time.offset": offset}

"""What a fit refuses before it computes, and what its words leave: no measurement is lost, no
number is a pretence.
"""

from pathlib import Path

import numpy as np
import pytest

import tippetop as tt
from tippetop.errors import InputError
from tippetop.exchange import measurements


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
        (["0,5", "0.1,5"], "friction.nu", "friction.mu"),
        (["0,5", "0.1,5"], "time.of", "time.offset"),
        (["0,5", "0.1,5"], ",", "must be names such as"),
    ],
)
def test_what_cannot_be_fitted_is_a_sentence(
    tmp_path: Path, rows: list[str], free: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        tt.fit(film(tmp_path, *rows), "inverting", free)


@pytest.mark.parametrize(
    "changes",
    [
        ["friction.law=contensou", "friction.patch=1e-4"],
        ["friction.law=coulomb"],
        ['run.on_liftoff="fly"'],
    ],
)
def test_laws_and_contacts_without_fits_are_not_supported_yet(
    tmp_path: Path, changes: list[str]
) -> None:
    scenario = tt.load("inverting", [*changes, "friction.mu=0.3"])
    with pytest.raises(
        InputError,
        match="exact Coulomb friction, stems and hops are not supported yet: give a smooth",
    ):
        tt.fit(film(tmp_path, "0,5.7", "0.1,5.6", "0.2,5.8", "0.3,5.6"), scenario, "friction.mu")


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
    path = film(tmp_path, *(f"{first + k},5" for k in range(3)))
    free = ["time.offset"]
    assert measurements.observation_of(
        tt.load("inverting"), path, free, measurements.Convention(), None
    ).start() == {"time.offset": offset}

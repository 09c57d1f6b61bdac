"""Several runs in one panel, named by what is different in them; parts of runs; pictures that are
there stay.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from refusals import refusal
from typed import refused

from tippetop.figures import catalogue, drawing, labels, overlay
from tippetop.figures.style import COLOURS, figure
from tippetop.figures.window import in_window


def a_run(**more: Any) -> tuple[xr.Dataset, dict[str, Any]]:
    """A top that rises evenly."""
    t = np.linspace(0, 8, 81)
    attrs = {
        "title": "rolling and gliding tippe top",
        "system": "tippe-top",
        "form": "vector",
        "status": "finished",
        "friction": {"law": "viscous", "mu": 0.3},
        "initial": {"theta": 0.1},
        "parameters": {"m": 0.02, "g": 9.82},
        "units": {"theta": "rad", "mu": "s m-1"},
        "run": {"precision": "double"},
        "report": {"drift": {}},
    }
    return xr.Dataset(
        {"theta": ("time", 0.1 + 0.3 * t), "energy": ("time", 1 + t)}, {"time": t}
    ), attrs | more


def test_runs_are_named_by_what_is_different_in_them() -> None:
    laws = [
        {"law": "viscous", "mu": 0.3},
        {"law": "coulomb", "mu": 0.3, "eps": 0.01},
        {"law": "none"},
    ]
    runs = [a_run(friction=law) for law in laws]
    runs[1][1]["units"] = {"theta": "rad", "eps": "m s-1"}
    ax = drawing.several("theta", runs, ["a", "b", "c"])
    words = [line.get_label() for line in ax.get_lines()]
    assert words == [
        "viscous friction, μ = 0.3 s m⁻¹",
        "regularised Coulomb friction, μ = 0.3, ε = 0.01 m s⁻¹",
        "no friction",
    ]
    assert ax.get_title(loc="left") == "Rolling and gliding tippe top\nθ(0) = 0.1 rad"
    assert {line.get_color() for line in ax.get_lines()} == set(COLOURS[:3])
    np.testing.assert_array_equal(ax.get_lines()[1].get_ydata(), runs[1][0]["theta"])
    slower = [
        drawing.with_records(a_run(friction={"law": "viscous", "mu": mu})[1]) for mu in (0.1, 0.2)
    ]
    assert labels.differences(slower, ["a", "b"]) == ["μ = 0.1 s m⁻¹", "μ = 0.2 s m⁻¹"]
    assert labels.differences(slower[:1] * 2, ["a", "b"]) == ["a", "b"]
    ended = labels.differences([slower[0], slower[1] | {"status": "lifted-off"}], ["a", "b"])
    assert ended[1] == "μ = 0.2 s m⁻¹, ends: lifted off"


def test_the_kinds_that_compare_runs_are_those_that_say_so() -> None:
    assert overlay.LABELS.keys() | overlay.CHANGES == {
        name for name, kind in catalogue.FIGURES.items() if kind.compares
    }
    with refusal(r"several runs are drawn together as theta, .*; `sphere` is drawn of one"):
        drawing.several("sphere", [a_run(), a_run()], ["a", "b"])


def test_a_part_of_a_run_keeps_its_first_row_for_the_changes() -> None:
    trajectory, attrs = a_run()
    events = xr.Dataset({"theta": ("event", [1.0])}, {"time": ("event", [3.0])})
    cut, known = in_window({"trajectory": trajectory, "events": events}, attrs, 2.0, 4.0)
    assert cut["trajectory"]["time"].values[[0, -1]].tolist() == [2.0, 4.0]
    assert cut["events"].sizes["event"] == 1
    assert known["first_row"]["energy"] == 1.0
    for start, until in ((4.0, 2.0), (9.0, 10.0)):
        with refusal("must be"):
            in_window({"trajectory": trajectory, "events": events}, attrs, start, until)


def test_a_picture_that_is_there_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    path.write_text("mine")
    for words in (
        "plot none.zarr --out",
        "run inverting --until 0.01 --figure",
        "surface inverting --figure",
    ):
        assert f"`{path}` must not exist yet, but does: use --overwrite" in refused(
            f"{words} {path}", 5
        )
    assert path.read_text() == "mine"
    with pytest.raises(Exception, match="must not exist"):
        drawing.write(figure(1, 1).subplots(), path)
    drawing.write(figure(1, 1).subplots(), path, overwrite=True)
    assert path.read_bytes().startswith(b"\x89PNG")

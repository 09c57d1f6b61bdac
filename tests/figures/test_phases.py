"""Figures over time shade the phases of a contact and mark its impacts: read back from
the artists.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from limits import assert_near
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_rgb
from typed import typed

import tippetop as tt
from tippetop.figures import conservation, shading
from tippetop.figures.style import LIGHT, figure


FLAGS = {
    "phase": "slip roll flight both",
    "ball": "body stem",
}


def table(**columns: Any) -> xr.Dataset:
    """Rows of a table; phase and ball by their words."""
    made = xr.Dataset()
    for name, values in columns.items():
        words = FLAGS.get(name, "").split()
        numbers = [words.index(value) for value in values] if words else list(values)
        made[name] = ("row", np.array(numbers, dtype=np.int8 if words else float))
        made[name].attrs = {"flag_meanings": FLAGS[name]} if words else {}
    return made


def shades(axes: Any) -> tuple[np.ndarray, np.ndarray]:
    """Edges and colours of the phases behind a panel."""
    (mesh,) = [c for c in axes.collections if isinstance(c, QuadMesh)]
    assert mesh.get_zorder() < min(line.get_zorder() for line in axes.get_lines())
    return mesh.get_coordinates()[0, :, 0], np.asarray(mesh.get_array()).reshape(-1, 3)


MARKS = {"body": "_impacts", "stem": "_impacts of the stem"}


def ticks(axes: Any, ball: str) -> list[float]:
    """Times of the marks of a ball's impacts."""
    (marks,) = [
        c
        for c in axes.collections
        if isinstance(c, LineCollection) and c.get_label() == MARKS[ball]
    ]
    return [float(segment[0, 0]) for segment in marks.get_segments()]


def legend(fig: Any) -> list[str]:
    return [text.get_text() for text in fig.legends[-1].get_texts()]


def panels() -> Any:
    fig = figure(6, 4)
    for axes in fig.subplots(2):
        axes.plot([0, 4], [1, 2])
        axes.set(xlim=(0, 4), ylim=(0.5, 3))
    return fig


def test_phases_are_shaded_from_start_to_end_in_every_panel() -> None:
    fig = panels()
    spans = table(
        start=[0, 1, 1.5, 2],
        end=[1, 1.5, 2, 4],
        phase=["slip", "flight", "roll", "slip"],
        ball=["body", "stem", "body", "stem"],
    )
    shading.mark(list(fig.axes), spans, table(time=[1.5, 2.0], ball=["body", "stem"]))
    for axes in fig.axes:
        edges, colors = shades(axes)
        assert list(edges) == [0, 1, 1.5, 2, 4]
        kinds = [("slip", 0), ("flight", 0), ("roll", 0), ("slip", 1)]
        np.testing.assert_allclose(
            colors, [to_rgb(LIGHT.shades[phase][stem]) for phase, stem in kinds]
        )
        assert (axes.get_xlim(), axes.get_ylim()) == ((0, 4), (0.5, 3))
        assert (ticks(axes, "body"), ticks(axes, "stem")) == ([1.5], [2.0])
    assert legend(fig) == [
        "slip: 25.0 %",
        "roll: 12.5 %",
        "flight: 12.5 %",
        "slip on the stem: 50.0 %",
        "1 impact",
        "1 impact of the stem",
    ]


def test_phases_of_a_user_s_system_have_shades_of_their_own() -> None:
    """They have no ball and no impacts; names of ours keep their colours."""
    fig = panels()
    spans = table(start=[0, 1, 3], end=[1, 3, 4])
    spans["phase"] = ("row", np.array([1, 0, 1], np.int8), {"flag_meanings": "slip fall stuck"})
    shading.mark(list(fig.axes), spans, None)
    fall, slip, again = shades(fig.axes[0])[1]
    np.testing.assert_allclose(slip, to_rgb(LIGHT.shades["slip"][0]))
    np.testing.assert_array_equal(fall, again)
    assert not np.allclose(fall, slip)
    assert legend(fig) == ["slip: 50.0 %", "fall: 50.0 %"]


def test_the_drift_of_jellett_s_integral_begins_anew_with_another_ball() -> None:
    """lambda is that of the ball in contact: its jump at a hand-over is no drift, not even if both
    came back between two rows; nor is what drilling takes.
    """
    trajectory = xr.Dataset(
        {"time": ("time", np.arange(4.0)), "jellett": ("time", np.array([2.0, 2.0, 5.0, 5.0]))}
    )
    attrs = {"report": {"drift": {"jellett": 0.0}}, "title": "a top", "initial": {}}
    ((*_, changes),) = conservation.changes(trajectory, attrs | {"handed_over": [1.5, 1.7]})
    assert list(changes) == [0, 0, 0, 0]
    ((*_, changes),) = conservation.changes(trajectory, attrs)
    assert list(changes) == [0, 0, 1.5, 1.5]
    drilling = trajectory.assign(jellett_lost=("time", np.array([0.0, 0.0, -3.0, -3.0])))
    ((words, _, changes),) = conservation.changes(drilling, attrs)
    assert (words, list(changes)) == ("λ + lost to torques", [0, 0, 0, 0])


@pytest.fixture(scope="module")
def sticking(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a top that slides, and rolls from 0.0288 s on."""
    store = tmp_path_factory.mktemp("phases") / "run.zarr"
    assert typed(f"run cohen-coulomb --until 0.05 --out {store}") == 0
    return store


@pytest.mark.parametrize("kind", ["theta", "normal-force", "drift", "energy"])
def test_a_stored_run_is_drawn_with_its_phases(sticking: Path, kind: str) -> None:
    made = tt.open(sticking).plot(kind)
    for axes in made.axes:
        assert_near(shades(axes)[0], [0, 0.02878761568, 0.05], 1e-11)
    assert legend(made) == ["slip: 57.6 %", "roll: 42.4 %"]

"""Figures as wide as a journal column, panels of users' figures, line styles."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from refusals import refusal

import tippetop as tt
from tippetop.figures.catalogue import FIGURES


COLUMN = (3.4, 2.5)


@pytest.fixture(scope="module")
def run() -> tt.Run:
    return tt.run("inverting", until=0.5, output_step=0.002)


@pytest.mark.parametrize("kind", sorted(FIGURES))
def test_all_of_a_small_figure_is_within_it_and_the_curves_have_half_of_it(
    run: tt.Run, kind: str
) -> None:
    figure = run.plot(kind, size=COLUMN)
    figure.draw_without_rendering()
    drawn = figure.get_tightbbox()
    assert min(drawn.x0, drawn.y0) > -0.03
    assert (drawn.max < np.array(COLUMN) + 0.03).all()
    if kind not in {"surface", "film", "potential", "sphere"}:
        box = figure.axes[0].get_position()
        assert box.height > 0.5
        assert box.width > 0.6


def test_a_panel_of_a_users_figure_keeps_its_settings(run: tt.Run) -> None:
    with mpl.rc_context({"font.size": 5.0, "axes.titlesize": 6.0, "legend.fontsize": 4.0}):
        axes = Figure().subplots()
        assert run.plot("theta", ax=axes) is axes.figure
    assert axes.xaxis.label.get_size() == 5
    assert axes.get_legend().get_texts()[0].get_size() == 4


def test_the_growth_of_a_run_of_keyframes_is_drawn(tmp_path: Path) -> None:
    words = {"until": 2.0, "output": "keyframes", "keyframe_steps": 50}
    run = tt.run("rolling", out=tmp_path / "run.zarr", **words)
    line = run.plot("growth").axes[0].lines[0]
    assert np.nanmax(line.get_ydata()) <= max(run.drift.to_dict().values())
    assert len(line.get_xdata()) > 3
    with refusal("requires rows"):
        run.plot("theta")

"""A few figures beside stored pictures.

`pytest -n0 --mpl-generate-path=tests/figures/baseline` stores them anew.
"""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from tippetop.figures import film, theta
from tippetop.figures.style import LIGHT, styled
from tippetop.runs.shape import axes_of


BALL = {
    "kind": "ball",
    "unit": 0.02,
    "balls": [{"offset": 0.006, "radius": 0.02}],
    "ellipsoid": [0.02, 0.02],
    "fixed": False,
    "axes": axes_of,
}
ATTRS: dict[str, Any] = {"title": "a top", "initial": {"theta": 0.3}, "units": {"theta": "rad"}}
pytestmark = pytest.mark.filterwarnings("ignore")  # of the comparison itself
SAME = pytest.mark.mpl_image_compare(
    baseline_dir="baseline", tolerance=8, remove_text=True, savefig_kwargs={"dpi": 40}
)


def swinging() -> tuple[xr.Dataset, xr.Dataset]:
    """theta(t) that swings with a slow trend, and its turnings."""
    t = np.linspace(0, 4, 401)
    angle = 0.6 + 0.2 * t + 0.3 * np.cos(2 * np.pi * 2 * t)
    inside = np.flatnonzero(np.diff(np.sign(np.diff(angle)))) + 1
    signs = np.where(angle[inside] > angle[inside - 1], -1, 1)
    flags = {"flag_meanings": "turning liftoff"}
    events = xr.Dataset(
        {
            "kind": ("event", np.zeros(len(inside), np.int8), flags),
            "theta": ("event", angle[inside]),
            "theta_dot_sign": ("event", signs),
            "amplitude": ("event", np.full(len(inside), 0.6)),
            "significant": ("event", np.ones(len(inside), bool)),
            "time": ("event", t[inside]),
        }
    )
    tilt = {
        "axis": (("time", "xyz"), np.stack([np.sin(angle), 0 * t, np.cos(angle)], axis=1)),
        "orientation": (
            ("time", "wxyz"),
            np.stack([np.cos(angle / 2), 0 * t, np.sin(angle / 2), 0 * t], axis=1),
        ),
    }
    return xr.Dataset({"theta": ("time", angle)} | tilt, {"time": t}), events


@SAME
@pytest.mark.parametrize("dark", [False, True])
def test_theta_with_its_band(dark: bool) -> Figure:
    with styled(dark=dark):
        axes = theta.theta(*swinging(), ATTRS)
    figure: Any = axes.get_figure(root=True)
    assert (figure.get_facecolor()[:3] == (1, 1, 1)) != dark
    assert LIGHT.paper == "#ffffff"
    return figure


@SAME
def test_the_film_strip() -> Figure:
    with styled():
        figure: Any = film.film(swinging()[0], ATTRS, BALL).get_figure(root=True)
    return figure

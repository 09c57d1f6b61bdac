"""The film strip: facets of the body at eight times."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from examples import HEAVY

from tippetop.figures import film
from tippetop.runs.shape import rotation, shape


BALL = {
    "kind": "ball",
    "unit": 0.02,
    "axes": np.eye(3).tolist(),
    "surfaces": [{"centre": [0.0, 0.0, 0.006], "half": [0.02] * 3}],
    "meridian": [],
    "fixed": False,
}
ATTRS = {"title": "a top", "initial": {"theta": 0.1}, "units": {"theta": "rad"}}


def posed(*quaternion: float, body: dict[str, Any] = BALL) -> tuple[np.ndarray, ...]:
    row = xr.Dataset({"orientation": ("wxyz", np.array(quaternion))})
    return film.pose(row, body, rotation)


def test_a_ball_is_a_disc_of_its_radius_on_the_floor() -> None:
    facets, shadow, _, mass = posed(1.0, 0, 0, 0)
    middle = film.SCREEN @ [0, 0, 1]
    rim = np.linalg.norm(facets.reshape(-1, 2) - middle, axis=1).max()
    assert rim == pytest.approx(1, abs=0.01)
    assert mass == pytest.approx(film.SCREEN @ [0, 0, 0.7])
    assert shadow[..., 0].mean() > 0  # the lamp is at the left


def test_rows_become_poses_at_their_times() -> None:
    """Theta rises from 0 to pi between 4 and 6 s: there the poses are, and the labels say when."""
    t = np.linspace(0, 10, 1001)
    theta = np.pi * np.clip((t - 4) / 2, 0, 1)
    columns: dict[str, Any] = {
        "theta": ("time", theta),
        "axis": (("time", "xyz"), np.stack([np.sin(theta), 0 * t, np.cos(theta)], axis=1)),
        "orientation": (
            ("time", "wxyz"),
            np.stack([np.cos(theta / 2), 0 * t, np.sin(theta / 2), 0 * t], axis=1),
        ),
    }
    trajectory = xr.Dataset(columns, {"time": t})
    ax = film.film(trajectory, ATTRS, BALL, rotation)
    labels = [tick.get_text() for tick in ax.get_xticklabels()]
    assert len(labels) == film.POSES
    times = [float(label.split()[2]) for label in labels]
    assert 3.5 < times[0] < times[-1] < 6.5
    np.testing.assert_allclose(np.diff(times), np.mean(np.diff(times)), atol=0.11)
    angles = [float(label.split()[-1].rstrip("°")) for label in labels]
    assert angles == sorted(angles)
    assert angles[-1] > 150


def test_every_kind_of_body_has_a_picture() -> None:
    heavy = {"system": "heavy-top", "parameters": HEAVY}
    cylinder = {
        "system": "rolling-cylinder",
        "parameters": {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 4e-6, "g": 9.82},
    }
    for attrs in (heavy, cylinder):
        body = shape(attrs)
        facets, _, colours, _ = posed(1.0, 0, 0, 0, body=body)
        assert len(facets) == len(colours) > 50
        assert np.isfinite(facets).all()

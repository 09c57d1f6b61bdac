"""The film strip shows the body as it stands: rays meet what is there, and each pose is that of its
time.
"""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from tippetop.figures import film, raycast
from tippetop.runs.shape import axes_of, with_shape


BALL = {
    "kind": "ball",
    "unit": 0.02,
    "balls": [{"offset": 0.006, "radius": 0.02}],
    "ellipsoid": [0.02, 0.02],
    "fixed": False,
    "axes": axes_of,
}
ATTRS = {"title": "a top", "initial": {"theta": 0.1}, "units": {"theta": "rad"}}


def upright(theta: float, mass: float = 0.7) -> raycast.Scene:
    """A ball on the floor, its centre of mass below or above its middle."""
    c, s = np.cos(theta), np.sin(theta)
    axes = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return raycast.Scene(
        "ball", axes, np.array([0.0, 0.0, mass]), [(np.array([0.0, 0.0, 1.0]), 1.0)], (1.0, 1.0)
    )


def test_a_ball_is_a_disc_and_its_shadow_lies_beside_it() -> None:
    seen = raycast.picture(upright(0.0), -1.5, 2.5, -0.6, 2.4, 150)
    assert seen.shape == (150, 200, 4)
    opaque = seen[..., 3] > 0.99
    assert (seen[..., 3] > 0.5).mean() == pytest.approx(
        np.pi / 12, rel=0.01
    )  # a disc of radius 1 in 4 by 3
    shadow = (seen[..., 3] > 0.1) & (seen[..., 3] < 0.9)
    assert np.nonzero(shadow)[1].mean() > np.nonzero(opaque)[1].mean()  # the lamp is at the left
    assert seen[..., 3][:60, -20:].max() < 1e-9  # nothing in the air


def test_the_light_half_is_above_until_the_top_is_inverted() -> None:
    """Mean brightness of the upper and of the lower half of the ball; the cap is seen at the start
    only.
    """
    for theta, above in ((0.0, True), (np.pi, False)):
        seen = raycast.picture(upright(theta), -1, 1, -0.04, 1.96, 100)
        upper, lower = (
            half[..., :3].sum() / half[..., 3].sum() for half in (seen[20:50], seen[50:80])
        )
        assert (upper > lower) == above
        red = seen[..., 0] - seen[..., 2]
        assert (red.max() > 0.5) == above


def test_a_turn_about_the_axis_is_seen() -> None:
    still, turned = upright(0.0), upright(0.0)
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    turned = turned._replace(axes=np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    pictures = [raycast.picture(scene, -1, 1, 0, 2, 60) for scene in (still, turned)]
    assert np.abs(pictures[0] - pictures[1]).max() > 0.1


def test_rows_become_poses_at_their_times(monkeypatch: pytest.MonkeyPatch) -> None:
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
    monkeypatch.setattr(film, "PIXELS", 20)
    ax = film.film(trajectory, ATTRS, BALL)
    labels = [tick.get_text() for tick in ax.get_xticklabels()]
    assert len(labels) == len(ax.images) == film.POSES
    times = [float(label.split()[2]) for label in labels]
    assert 3.5 < times[0] < times[-1] < 6.5
    np.testing.assert_allclose(np.diff(times), np.mean(np.diff(times)), atol=0.11)
    angles = [float(label.split()[-1].rstrip("°")) for label in labels]
    assert angles == sorted(angles)
    assert angles[-1] > 150


def test_poses_of_a_cylinder_are_those_before_it_has_come_to_rest() -> None:
    t = np.linspace(0, 20, 2001)
    rows = film._rows(xr.Dataset({"theta": ("time", np.exp(-2 * t) * np.cos(9 * t))}, {"time": t}))
    assert len(rows) == film.POSES
    assert 1.5 < t[rows[-1]] < 2.5
    still = film._rows(xr.Dataset({"theta": ("time", 0 * t)}, {"time": t}))
    assert t[still].tolist() == pytest.approx(np.linspace(0, 20, film.POSES).tolist(), abs=0.02)


def test_a_body_on_its_stem_stands_higher() -> None:
    """R = 1, the stem's ball of radius 0.2 with its middle 1.2 above that of the sphere."""
    stem = BALL | {"balls": [*BALL["balls"], {"offset": 0.03, "radius": 0.004}]}
    trajectory = xr.Dataset(
        {"orientation": (("time", "wxyz"), np.array([[1.0, 0, 0, 0], [0.0, 1.0, 0, 0]]))}
    )
    first, last = (film._scene(trajectory, stem, row) for row in (0, 1))
    assert first.balls[0][0][2] == pytest.approx(1.0)
    assert last.balls[0][0][2] == pytest.approx(1.4)
    assert last.balls[1][0][2] == pytest.approx(0.2)


def test_every_kind_of_body_has_a_picture() -> None:
    heavy = {
        "system": "heavy-top",
        "parameters": {"m": 0.1, "l": 0.04, "I1": 8e-5, "I3": 5e-5, "g": 9.82},
    }
    cylinder = {
        "system": "rolling-cylinder",
        "parameters": {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 4e-6, "g": 9.82},
    }
    for attrs in (heavy, cylinder):
        trajectory = xr.Dataset({"orientation": (("time", "wxyz"), np.array([[1.0, 0, 0, 0]]))})
        _, _, body = with_shape(trajectory, None, attrs)
        scene = film._scene(trajectory, body, 0)
        reach, bottom, top = film._extent([scene])
        seen = raycast.picture(scene, -reach, reach, bottom, top, 60)
        assert 0.02 < (seen[..., 3] > 0.99).mean() < 0.9
        edges = np.concatenate([seen[0, :, 3], seen[:, 0, 3]])
        assert not (edges > 0.99).any()  # nothing is cut off

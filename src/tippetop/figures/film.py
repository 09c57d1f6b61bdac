"""A film strip: the top as it stands at eight times, on one line."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from . import raycast
from .labels import title
from .sphere import busy, turned
from .style import compact, figure, ink
from .thinning import span


POSES = 8
PIXELS = 320  # the height of a pose
GAP = 0.12  # between two poses
SHADOW = 0.8  # of half a pose: how far a shadow reaches beyond it


def film(
    trajectory: Any, attrs: dict[str, Any], shape: dict[str, Any], ax: Axes | None = None
) -> Axes:
    """Eight poses of the body by their times: evenly spread over the part of the run in which it
    turns over, if it does, else over the whole.

    `trajectory` has time, theta, orientation and, where the contact may open, z; `shape` is the
    body as `runs.shape.with_shape` gives it.
    """
    rows = _rows(trajectory)
    scenes = [_scene(trajectory, shape, row) for row in rows]
    reach, bottom, top = _extent(scenes)
    step = 2 * reach + GAP
    if ax is None:
        width = 12.0
        strip = width * (top - bottom) / (len(rows) * step + SHADOW * reach)
        ax = figure(width, 0.6 + 0.19 * len(title(attrs).splitlines()) + strip).subplots()
    for i, scene in enumerate(scenes):
        right = reach + SHADOW * reach
        seen = raycast.picture(scene, -reach, right, bottom, top, PIXELS)
        ax.imshow(
            seen,
            extent=(i * step - reach, i * step + right, bottom, top),
            interpolation="antialiased",
            zorder=2,
        )
    t, theta = trajectory["time"].values[rows], trajectory["theta"].values[rows]
    between = float(np.min(np.diff(t))) if len(t) > 1 else 1.0
    decimals = max(0, 1 - int(np.floor(np.log10(max(between, 1e-12)))))
    names = ("", "") if compact() else ("t = ", "θ = ")
    words = [
        f"{names[0]}{when:.{decimals}f} s\n{names[1]}{np.degrees(angle):.1f}°".replace("-", "−")
        for when, angle in zip(t, theta, strict=True)
    ]
    ax.set_xticks(np.arange(len(rows)) * step, words)
    ax.set_yticks([])
    ax.grid(visible=False)
    ax.spines[["left", "top", "right"]].set_visible(False)
    ax.spines["bottom"].set_color(ink().quiet)
    ax.tick_params(axis="x", color=ink().quiet, labelsize="small")
    ax.set(
        xlim=(-reach - GAP / 2, (len(rows) - 1) * step + (1 + SHADOW) * reach),
        ylim=(bottom, top),
        aspect="equal",
    )
    ax.set_title(title(attrs))
    if scenes[0].kind != "heavy" and not compact():
        ax.set_title("grey dot: centre of mass", loc="right", fontsize="small", color=ink().quiet)
    return ax


def _rows(trajectory: Any) -> np.ndarray:
    """The rows that are drawn."""
    t = trajectory["time"].values
    first, last = (
        busy(trajectory["axis"].values, t) if "axis" in trajectory else _moving(trajectory, t)
    )
    wanted = np.linspace(max(first, t[0]), min(last, t[-1]), POSES)
    return np.unique(np.clip(np.searchsorted(t, wanted), 0, len(t) - 1))


def _moving(trajectory: Any, t: np.ndarray) -> tuple[float, float]:
    """The time in which a body that stays upright turns, but for the rest of its way before and
    after.
    """
    way = (
        np.cumsum(np.abs(np.diff(trajectory["theta"].values)))
        if "theta" in trajectory
        else np.zeros(0)
    )
    if not len(way) or not way[-1] > 0:
        return span(t)
    first, last = turned(way)
    return float(t[first]), float(t[last])


def _scene(trajectory: Any, shape: dict[str, Any], row: int) -> raycast.Scene:
    """The body at a row, in units of itself."""
    unit = shape["unit"]
    axes = shape["axes"](trajectory["orientation"].values[row])
    third = axes[:, 2]
    balls = [(ball["offset"] / unit, ball["radius"] / unit) for ball in shape["balls"]]
    if "z" in trajectory:
        height = float(trajectory["z"].values[row]) / unit
    elif shape["fixed"]:
        height = -balls[0][0] * third[2]
    else:  # the lowest point is on the floor
        height = max(radius - offset * third[2] for offset, radius in balls)
    mass = np.array([0.0, 0.0, height]) - balls[0][0] * third * (
        1,
        1,
        0,
    )  # the ball, or tip, stays in the middle
    tip = mass + balls[0][0] * third if shape["kind"] == "heavy" else None
    places = [(mass + offset * third, radius) for offset, radius in balls]
    across, along = (half / unit for half in shape["ellipsoid"])
    return raycast.Scene(shape["kind"], axes, mass, places, (across, along), tip)


def _extent(scenes: list[raycast.Scene]) -> tuple[float, float, float]:
    """Half the width of every pose, its bottom and its top in the picture."""
    points: list[tuple[np.ndarray, float]] = []
    for scene in scenes:
        if scene.tip is not None:
            end = scene.mass + (scene.ellipsoid[1] + 0.3) * scene.axes[:, 2]
            points += [(scene.mass, max(scene.ellipsoid)), (end, 0.06), (scene.tip, 0.06)]
        else:
            wide = 1.25 if scene.kind == "cylinder" else 1.0
            points += [(centre, radius * wide) for centre, radius in scene.balls]
    reach = max(float(np.hypot(*centre[:2])) + radius for centre, radius in points)
    height = [(float(centre @ raycast.UP), radius) for centre, radius in points]
    bottom = min(min(y - radius for y, radius in height), -0.45 * min(reach, 1.0))
    return reach + 0.1, bottom - 0.05, max(y + radius for y, radius in height) + 0.08

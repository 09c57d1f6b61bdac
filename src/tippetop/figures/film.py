"""A film strip, the body at eight times on one line, and the frames of a film.

The body is made of ellipsoids and surfaces of revolution; their facets are painted from the far
ones to the near ones. The camera looks along y, from somewhat above; z is up. Lengths are in units
of the body.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from .labels import Attributes, number, title
from .sphere import busy
from .style import compact, figure, ink, users_panel


POSES = 8
GAP = 0.1  # between two poses
FACETS = 128  # around an axis of revolution
SECTORS = 8  # alternately light and dark around the axis: they show the spin
ELEVATION = np.radians(16.0)  # of the camera
SCREEN = np.array([[1, 0, 0], [0, np.sin(ELEVATION), np.cos(ELEVATION)]])
AHEAD = np.array([0, np.cos(ELEVATION), -np.sin(ELEVATION)])
LIGHT = np.array([-0.42, -0.62, 0.66])
LIGHT /= np.linalg.norm(LIGHT)
HALF = np.array([-2.1, 2.1])  # from the middle to the edges of a frame, in units of the body
STEP = 0.5  # between dots of the floor, likewise
FLOOR = STEP * np.moveaxis(np.mgrid[-40:40, -32:32], 0, -1)
CREAM, BLUE, ORANGE, WOOD, IRON = (
    np.array(rgb) / 255
    for rgb in ((243, 232, 205), (44, 92, 143), (217, 95, 30), (196, 142, 84), (35, 38, 44))
)

Array = np.ndarray


def film(
    trajectory: Any,
    attrs: Attributes,
    shape: dict[str, Any],
    rotation: Callable[[Array], Array],
) -> Axes:
    """Draw eight poses of the body, evenly spread over the part of the run in which it turns over.

    `trajectory` has time, theta, orientation and, where the contact may open, z; `shape` is the
    body as `runs.shape.shape` returns it, `rotation` is `runs.shape.rotation`, which returns the
    matrix of an orientation.
    """
    t = trajectory["time"].values
    theta = trajectory["theta"].values
    rows = np.searchsorted(t, np.linspace(*busy(theta, t), POSES))
    rows = np.unique(np.clip(rows, 0, len(t) - 1))
    poses = [pose(trajectory.isel(time=row), shape, rotation) for row in rows]
    # of facets and shadows
    corners = np.concatenate([each.reshape(-1, 2) for parts in poses for each in parts[:2]])
    left, bottom = corners.min(axis=0)
    right, top = corners.max(axis=0)
    step = right - left + GAP
    places = step * np.arange(len(rows))
    if (ax := users_panel()) is None:
        strip = 12.0 * (top - bottom) / (len(rows) * step)
        ax = figure(12.0, 0.6 + 0.19 * len(title(attrs).splitlines()) + strip).subplots()
    for x, (facets, shadow, colours, mass) in zip(places, poses, strict=True):
        aside = np.array([x, 0.0])
        _paint(ax, facets + aside, shadow + aside, colours)
        if shape["kind"] != "heavy":  # the hidden mass shines through
            ax.plot(*(mass + aside), "o", color=IRON, alpha=0.5, ms=4)
    names = ("", "") if compact() else ("t = ", "θ = ")
    shown = [
        f"{names[0]}{number(t[row])} s\n{names[1]}{number(np.degrees(theta[row]), 4)}°"
        for row in rows
    ]
    ax.grid(visible=False)
    ax.spines[["left", "top", "right"]].set_visible(False)
    ax.tick_params(axis="x", labelsize="small")
    ax.set(
        xticks=places,
        xticklabels=shown,
        yticks=[],
        xlim=(left - GAP / 2, places[-1] + right + GAP / 2),
        ylim=(bottom - 0.08, top + 0.08),
        aspect="equal",
        title=title(attrs),
    )
    if shape["kind"] != "heavy" and not compact():
        ax.set_title("grey dot: centre of mass", loc="right", fontsize="small", color=ink().quiet)
    return ax


def _paint(ax: Axes, facets: Any, shadow: Any, colours: Array) -> None:
    """Draw a body with its shadow into a panel.

    `facets` (n, 4, 2), the far ones first, and `shadow` are polygons on the screen, `colours` those
    of the facets.
    """
    ax.add_collection(PolyCollection(shadow, facecolor="black", alpha=0.2, lw=0))
    painted = PolyCollection(facets, facecolors=colours, edgecolors=colours, lw=0.5)
    painted.set_rasterized(True)
    ax.add_collection(painted)


def frames(
    orientations: Array,
    places: Array,
    texts: list[str],
    shape: dict[str, Any],
    rotation: Callable[[Array], Array],
    size: list[int],
) -> Iterator[bytes]:
    """Yield frames of a film, RGBA bytes row by row: the body on a floor of dots below it.

    The centre of the ball, or the tip, stays in the middle; the dots move instead.

    Parameters
    ----------
    orientations, places, texts
        Of each frame: orientation, centre of mass [m], and a line of text.
    shape, rotation
        See `film`.
    size
        Width and height [pixels].
    """
    width, height = size
    fig = figure(width / 100, height / 100)
    fig.set_dpi(100)
    fig.set_layout_engine("none")
    ax = fig.add_axes((0, 0, 1, 1))
    centre = shape["surfaces"][0]["centre"] @ np.array(shape["axes"])
    for q, place, text in zip(orientations, places, texts, strict=True):
        below = (place + rotation(q) @ centre)[:2] / shape["unit"]
        dots = (FLOOR - below % STEP) @ SCREEN[:, :2].T
        ax.clear()
        ax.set(xlim=HALF * width / height, ylim=1 + HALF)
        ax.axis("off")
        ax.plot(*dots.T, ".", color=ink().grid, ms=height / 150, zorder=0)
        _paint(ax, *pose({"orientation": q, "z": place[2]}, shape, rotation)[:3])
        ax.text(0.02, 0.03, text, transform=ax.transAxes, fontsize=height / 36)
        fig.canvas.draw()
        yield bytes(fig.canvas.buffer_rgba())  # type: ignore[attr-defined]


def pose(
    row: Any, shape: dict[str, Any], rotation: Callable[[Array], Array]
) -> tuple[Array, Array, Array, Array]:
    """Return the body on the screen, at one row of its trajectory.

    Facets (n, 4, 2), the far ones first, shadows, colours of the facets, centre of mass. `row` is
    a Dataset, or a dict, of the orientation and, if it has it, the height z of the centre of mass.
    """
    axes = rotation(np.asarray(row["orientation"])) @ np.transpose(shape["axes"])
    unit = shape["unit"]
    down = -axes[2]
    profile = np.array(_capsule(1.0, 1.0))
    if shape["meridian"]:  # from the top down, by height and radius
        profile = np.array(shape["meridian"])[::-1, 1::-1].T
    surfaces = [
        (np.array(each["centre"]) / unit, np.array(each["half"]) / unit)
        for each in shape["surfaces"]
    ]
    (offset, _), *stems = surfaces
    if "z" in row:
        height = float(row["z"]) / unit
    elif shape["fixed"]:
        height = -(axes @ offset)[2]
    else:  # the lowest point is on the floor
        height = max(down @ (at + _farthest(down, size, profile)) for at, size in surfaces)
    # the ball, or the tip, stays in the middle
    mass = np.array([0, 0, height]) - axes @ offset * (1, 1, 0)
    thick = [(mass + axes @ at, size) for at, size in surfaces]
    if shape["kind"] == "heavy":
        thick = [(mass, np.array(shape["ellipsoid"]) / unit)]
    centre, half = thick[0]
    parts = [_facets(centre, axes * half, profile[0], profile[1], None)]
    if shape["kind"] == "heavy":
        for ends in ((offset[2], -half[2]), (half[2], half[2] + 0.3)):
            parts.append(_facets(mass, axes, *_capsule(0.05, 0.05, *ends), IRON))
    elif shape["kind"] == "cylinder":
        radius = half[0]
        wide = 0.7 * radius
        can = np.array([0, radius, radius, 0]), np.array([-wide, -wide, wide, wide])
        paint = np.where(_even()[:, None], CREAM, BLUE)
        parts = [_facets(centre, axes[:, [2, 0, 1]], *can, paint)]
    for at, size in stems:
        rod = np.sqrt(half[0] ** 2 - size[0] ** 2), at[2] - offset[2]
        parts.append(_facets(centre, axes, *_capsule(size[0], size[0], *rod), WOOD))
    corners, colours = (np.concatenate(each) for each in zip(*parts, strict=True))
    far_first = np.argsort(-corners.mean(axis=1) @ AHEAD)
    hangs = shape["fixed"] and (axes @ offset)[2] > 0  # then there is no floor
    shadows = np.array(
        [_shadow(at, axes, size, profile) for at, size in ([] if hangs else thick)]
    ).reshape(-1, FACETS, 3)
    screen = (corners[far_first] @ SCREEN.T, shadows @ SCREEN.T)
    return *screen, colours[far_first], mass @ SCREEN.T


def _farthest(direction: Array, half: Array, profile: Array) -> Array:
    """Return the point of a surface that lies farthest in a direction, in axes of the surface.

    `profile` (2, n) has the radii and heights of the surface, in units of its half axes.
    """
    x, y, z = half * direction
    across = np.hypot(x, y)
    radius, height = profile[:, np.argmax([across, z] @ profile)]
    radius /= across or 1.0  # across = 0: the term is 0 in any direction
    return half * [radius * x, radius * y, height]


def _capsule(across: float, along: float, low: float = 0, high: float = 0) -> tuple[Array, Array]:
    """Return radii and heights, (n,) each, of an ellipsoid of revolution, from its lowest point up.

    Its half axes are `across` and `along`; its halves are moved to the heights `low` and `high`.
    """
    t = np.linspace(0, np.pi / 2, FACETS // 4)
    end = along * np.cos(t)
    return across * np.r_[np.sin(t), np.cos(t)], np.r_[low - end, high + end[::-1]]


def _even() -> Array:
    """Return whether each of the FACETS around the axis is in an even sector, (FACETS,)."""
    return np.arange(FACETS) * SECTORS // FACETS % 2 == 0


def _facets(
    place: Array, axes: Array, radii: Array, heights: Array, paint: Array | None
) -> tuple[Array, Array]:
    """Return the corners (n, 4, 3) and the lit colours of the facets that face the camera.

    Parameters
    ----------
    place, axes
        Origin and axes of the surface; the last column is the axis of revolution.
    radii, heights
        Its profile, heights ascending, so that the normals of facets point outwards.
    paint
        Colours, which broadcast to (n - 1, FACETS, 3); None: a light and a dark half, with sectors
        and a cap.
    """
    angle = np.linspace(0, 2 * np.pi, FACETS + 1)
    around = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    local = radii[:, None, None] * around + heights[:, None, None] * [0, 0, 1]
    points = place + local @ axes.T
    corners = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2)
    normal = np.cross(
        corners[:, :, 2] - corners[:, :, 0], corners[:, :, 3] - corners[:, :, 1], axis=-1
    )
    if paint is None:
        middle = (heights[1:] + heights[:-1])[:, None, None] / 2
        paint = np.where(middle > 0, CREAM, BLUE) * np.where(_even(), 1.0, 0.75)[:, None]
        top = (middle > 0.93 * heights.max()) & (radii[:-1, None, None] < 0.4)
        paint = np.where(top, ORANGE, paint)
    seen = normal @ AHEAD < 0
    normal = normal[seen] / np.linalg.norm(normal[seen], axis=1, keepdims=True)
    bright = 0.42 + 0.64 * np.clip(normal @ LIGHT, 0, 1)[:, None]
    return corners[seen], np.clip(np.broadcast_to(paint, (*seen.shape, 3))[seen] * bright, 0, 1)


def _shadow(centre: Array, axes: Array, half: Array, profile: Array) -> Array:
    """Return the rim (FACETS, 3) of the shadow of a surface on the floor z = 0.

    `centre` and `axes` (3, 3) place it in space; half axes and profile as of `_farthest`.
    """
    angle = np.linspace(0, 2 * np.pi, FACETS)[:, None]
    # one, other: unit vectors across LIGHT; where it grazes the surface the shadow has its rim
    _, one, other = np.linalg.svd(LIGHT[None])[2]
    around = (np.cos(angle) * one + np.sin(angle) * other) @ axes
    rim = centre + [axes @ _farthest(way, half, profile) for way in around]
    return rim - rim[:, 2:] / LIGHT[2] * LIGHT

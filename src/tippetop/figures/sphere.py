"""The path of a top's axis on the unit sphere, coloured by the time: from the side, from above,
from below.
"""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from .labels import title
from .style import compact, figure, ink, legend
from .thinning import MOST_POINTS, span


SMALL = 0.3  # a path within this of the vertical is drawn larger, from above or below
FLAT = 0.01  # a path no further above or below the equator is seen from the side
# of the whole way: what the axis does before and after is shown in the colours of its ends
CALM = 0.02
INCLINED = (
    0.3  # rad: a top whose mean inclination changes by less has its colours over the whole run
)


class View(NamedTuple):
    """A view on the sphere: its name, the directions to the right, up and towards us, as rows, and
    labels of two.
    """

    words: str
    frame: np.ndarray
    labels: tuple[str, str]


SIDE = View("from the side", np.eye(3)[[1, 2, 0]], ("y", "z"))
ABOVE = View("from above", np.eye(3), ("x", "y"))
BELOW = View("from below", np.diag([1.0, -1.0, -1.0]), ("x", "−y"))


def sphere(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """The path of 3hat on the unit sphere; the far side is left out, and so are views in which
    nothing is seen.

    In a panel that is given there is one view: that which shows most of the path.
    """
    path, t = trajectory["axis"].values, trajectory["time"].values
    limits = busy(np.arccos(np.clip(path[:, 2], -1, 1)), t)
    step = max(1, len(path) // MOST_POINTS)
    path, t = path[::step], t[::step]
    views = _worth_showing(path)
    if compact():
        views = views[:1]
    ends = {(True, True): "both", (True, False): "min", (False, True): "max"}
    beyond = ends.get((bool(limits[0] > t[0]), bool(limits[1] < t[-1])), "neither")
    bar: Any = {"shrink": 0.8, "label": "time t (s)", "extend": beyond}
    if ax is not None:
        lines = _view(ax, views[0], path, t, limits)
        ax.set_title(title(attrs))
        ax.get_figure(root=True).colorbar(lines, ax=ax, **bar)  # type: ignore[union-attr]
        return ax
    fig = figure(max(7.0, 1.2 + 3.6 * len(views)), 4.9 if len(views) > 1 else 6.0)
    panels = np.atleast_1d(fig.subplots(1, len(views)))
    for axes, view in zip(panels, views, strict=True):
        lines = _view(axes, view, path, t, limits)
        axes.set_title(view.words)
    fig.colorbar(lines, ax=list(panels), pad=0.01, **bar)
    fig.suptitle(title(attrs), x=0.01, ha="left")
    legend(panels[0], "lower center", ncols=3)
    return panels[0]


def _worth_showing(path: np.ndarray) -> list[View]:
    """The views in which there is something: a path near a pole is a dot from the side."""
    seen = [view for view in (ABOVE, BELOW) if (path @ view.frame[2] > FLAT).any()]
    from_side = path[path[:, 0] >= 0]
    if len(from_side) > 1 and max(np.ptp(from_side[:, 1]), np.ptp(from_side[:, 2])) > SMALL:
        return [SIDE, *seen]
    return seen or [SIDE]


def _view(
    axes: Axes, view: View, path: np.ndarray, t: np.ndarray, limits: tuple[float, float]
) -> Any:
    """One view; its lines, coloured by the time."""
    colours = ink()
    *plane, depth = view.frame @ path.T
    plane = np.stack(plane, axis=1)
    near = (depth[1:] >= 0) & (depth[:-1] >= 0)
    segments = np.stack([plane[:-1], plane[1:]], axis=1)[near]
    lines = LineCollection(list(segments), array=t[1:][near], cmap="viridis", lw=0.6)
    lines.set_clim(*limits)
    axes.add_patch(Circle((0, 0), 1, fill=False, color=colours.quiet, lw=0.8))
    axes.add_collection(lines)
    for angle in (np.pi / 6, np.pi / 3):  # circles of latitude, 30 and 60 degrees
        if view is not SIDE:
            axes.add_patch(
                Circle((0, 0), np.cos(angle), fill=False, color=colours.grid, lw=0.6, zorder=0)
            )
        else:
            for z in (np.sin(angle), -np.sin(angle)):
                axes.hlines(z, -np.cos(angle), np.cos(angle), color=colours.grid, lw=0.6, zorder=0)
    _ends(axes, plane, depth)
    axes.grid(visible=False)
    reach = float(np.max(np.abs(plane[depth >= 0]))) if (depth >= 0).any() else 1.0
    size = 1.08 if reach > SMALL or view is SIDE else 1.15 * max(reach, 1e-3)
    along, up = (f"$\\hat{{3}}$ along {label}" for label in view.labels)
    axes.set(xlim=(-size, size), ylim=(-size, size), aspect="equal", xlabel=along, ylabel=up)
    if size > 1:
        axes.set(xticks=(-1, 0, 1), yticks=(-1, 0, 1))
    else:
        axes.locator_params(nbins=5)
    return lines


def _ends(axes: Axes, plane: np.ndarray, depth: np.ndarray) -> None:
    """The start, the end, and an arrow that shows which way the axis goes; on the far side they are
    not seen.
    """
    mark = ink().mark
    for place, style, words, face in ((0, "o", "start", mark), (-1, "D", "end", "none")):
        seen = depth[place] >= 0
        axes.plot(
            *(plane[[place]].T if seen else ([], [])),
            style,
            color=mark,
            mfc=face,
            ms=5,
            label=words,
            zorder=4,
        )
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(plane, axis=0), axis=1))])
    if not way[-1] > 0:
        return
    visible = np.flatnonzero(depth >= 0)
    first = visible[0] if len(visible) else 0
    size = min(0.12, 0.15 * float(np.max(np.abs(plane))) + 1e-12)
    here, there = np.searchsorted(way, way[first] + (3 * size, 4 * size))
    if there < len(way) and here < there and (depth[here : there + 1] >= 0).all():
        axes.annotate(
            "",
            plane[there],
            plane[here],
            zorder=5,
            arrowprops={
                "arrowstyle": "-|>",
                "color": mark,
                "lw": 0,
                "mutation_scale": 14,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )


def busy(theta: np.ndarray, t: np.ndarray) -> tuple[float, float]:
    """Return the time in which the mean inclination changes, else the whole run."""
    width = max(1, len(theta) // 40)
    mean = np.convolve(theta, np.ones(width) / width, mode="valid")
    if len(mean) < 3 or np.ptp(mean) < INCLINED:
        return span(t)
    way = np.cumsum(np.abs(np.diff(mean)))
    first, last = np.searchsorted(way, (CALM * way[-1], (1 - CALM) * way[-1]))
    return float(t[first]), float(t[min(last + width, len(t) - 1)])

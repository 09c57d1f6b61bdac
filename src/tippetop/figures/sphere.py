"""The path of a top's axis on the unit sphere, coloured by the time, in up to three views.

`trajectory` and `events` are Datasets of a run in SI units, `attrs` the root attributes of its
store; t is the time [s].
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from .labels import Attributes, title
from .style import compact, figure, ink, legend, users_panel
from .thinning import every, span


# A path within this of the vertical is enlarged in the views from above and below
SMALL = 0.3
# Fractions of the way that the axis goes before and after its colours change
CALM = 0.02
# Colours cover the whole run if the mean inclination [rad] changes by less
INCLINED = 0.3
VIEWS = {
    "from the side": (np.eye(3)[[1, 2, 0]], "y", "z"),
    "from above": (np.eye(3), "x", "y"),
    "from below": (np.diag([1.0, -1.0, -1.0]), "x", "−y"),
}
"""Directions to the right, up and to the viewer as rows, and labels of the first two."""


def sphere(trajectory: Any, events: Any, attrs: Attributes) -> Axes:
    """Draw the near side of the path of 3hat on the unit sphere, in each view that shows it.

    A panel of the user's and a small figure have one view.
    """
    path = trajectory["axis"].values
    t = trajectory["time"].values
    limits = busy(np.arccos(np.clip(path[:, 2], -1, 1)), t)
    path = path[every(len(t))]
    t = t[every(len(t))]
    views = [name for name, (frame, *_) in VIEWS.items() if (path @ frame[2] > 0).any()]
    ax = users_panel()
    if ax is not None or compact():
        views = views[:1]
    panels: Any = [ax]
    if ax is None:
        size = max(7.0, 1.2 + 3.6 * len(views)), 4.9 if len(views) > 1 else 6.0
        panels = figure(*size).subplots(1, len(views), squeeze=False)[0]
    for axes, view in zip(panels, views, strict=True):
        lines = _view(axes, view, path, t)
        lines.set_clim(*limits)
    whole = panels[0].get_figure(root=True)
    extend = "both" if limits != span(t) else "neither"
    whole.colorbar(lines, ax=list(panels), shrink=0.8, label="time t (s)", extend=extend)
    if ax is None:
        whole.suptitle(title(attrs), x=0.01, ha="left")
        legend(panels[0], "lower center", ncols=3)
    else:
        ax.set_title(title(attrs))
    return panels[0]


def _view(axes: Axes, view: str, path: np.ndarray, t: np.ndarray) -> Any:
    """Draw one view, a key of VIEWS, of a path (n, 3) at the times t; return its lines.

    They are coloured by the time; the caller sets the limits of the colours, for all views.
    """
    colours, (frame, along, up) = ink(), VIEWS[view]
    seen = path @ frame.T
    plane = seen[:, :2]
    near = seen[:, 2] >= 0
    both = near[1:] & near[:-1]
    segments = np.stack([plane[:-1], plane[1:]], axis=1)[both]
    lines = LineCollection(list(segments), array=t[1:][both], cmap="viridis", lw=0.6)
    axes.add_collection(lines)
    reach = np.abs(plane[near]).max(initial=1e-3)
    size = 1.08 if reach > SMALL or view == "from the side" else 1.15 * reach
    axes.add_patch(Circle((0, 0), 1, fill=False, color=colours.quiet, lw=0.8))
    for row, style, words, face in ((0, "o", "start", colours.mark), (-1, "D", "end", "none")):
        if near[row]:
            axes.plot(*plane[row], style, color=colours.mark, mfc=face, ms=5, label=words, zorder=4)
    axes.set(xlim=(-size, size), ylim=(-size, size), aspect="equal", title=view)
    axes.set(xlabel=f"$\\hat{{3}}$ along {along}", ylabel=f"$\\hat{{3}}$ along {up}")
    axes.locator_params(nbins=5)
    return lines


def busy(theta: np.ndarray, t: np.ndarray) -> tuple[float, float]:
    """Return the time in which the mean inclination changes, else the whole run.

    `sphere` spreads its colours, and `film` its poses, over this time [s].
    """
    width = max(1, len(theta) // 40)
    mean = np.convolve(theta, np.ones(width) / width, mode="valid")
    if len(mean) < 3 or np.ptp(mean) < INCLINED:
        return span(t)
    way = np.cumsum(np.abs(np.diff(mean)))
    first, last = np.searchsorted(way, (CALM * way[-1], (1 - CALM) * way[-1]))
    # a mean begins at the row of its number and ends `width` rows later
    return float(t[first]), float(t[min(last + width, len(t) - 1)])

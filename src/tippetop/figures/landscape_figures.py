"""Figures of the landscape: the minimal surface and the band.

Datasets of `landscape` go in, Axes come out.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from ..columns import greek, units_text
from ..sampling import spread
from .style import (
    compact,
    figure,
    heading,
    ink,
    legend,
    mark_ends,
    panels_over_time,
    ticks_of_inclination,
    users_panel,
)
from .thinning import every


FACETS = 140  # of the surface in 3-D, along each axis
EXACT = 1e-17  # [rad] smaller distances from the edge of the band are not drawn


def surface(grid: Any, lines: Any, run: Any = None, title: str = "") -> Any:
    """Draw F(D, lambda) in 3-D [figure 4.1 of the source], with the spinning states and a run.

    Parameters
    ----------
    grid, lines
        As returned by `minimal_surface` and `marked_lines`.
    run
        routh, jellett and modified_energy along `time` of a run, NaN while it is not on its sphere.
    title
        The body.
    """
    axes: Any = users_panel() or figure(8.6, 6.4).add_subplot(
        projection="3d", computed_zorder=False
    )
    F = grid["F"][*(spread(n, FACETS) for n in grid["F"].shape)]
    X, Y = np.meshgrid(*(F[name] for name in F.dims), indexing="ij")
    axes.plot_surface(X, Y, F, cmap="viridis", rstride=1, cstride=1, lw=0, antialiased=False)
    high = F.max()
    _spinning(axes, lines, X.min(), X.max())
    if run is not None:
        run = run.isel(time=every(run.sizes["time"]))
        path = [run[name].values for name in ("routh", "jellett", "modified_energy")]
        axes.plot(*path, color=ink().mark, lw=1.1, label="run", zorder=4)
        mark_ends(axes, *path)
        high = max(high, np.nanmax(path[2]))
    small = compact()
    for axis, name in zip((axes.xaxis, axes.yaxis), F.dims, strict=True):
        about = F[name].attrs
        words = name if small else about["long_name"]
        axis.set_label_text(f"{greek(words)} ({units_text(about['units'])})")
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("energy (J)", rotation=90)
    for axis, pad in ((axes.xaxis, 12), (axes.yaxis, 12), (axes.zaxis, 6)):
        axis.labelpad = -4 if small else pad
        axis.set_major_formatter(EngFormatter(sep=""))
        axis.set_pane_color(ink().paper)
    axes.locator_params(nbins=4 if small else 5)
    axes.tick_params(pad=-2 if small else 3)
    axes.set_zlim(F.min(), high)
    axes.set_box_aspect((1.15, 1, 0.75), zoom=0.85 if small else 1.0)
    axes.view_init(elev=28, azim=-108)
    words = f"Minimal surface F({greek(', '.join(F.dims))}), the least energy"
    axes.set_title(f"{title}\n{words}" if title and not small else words)
    legend(axes, "lower center", ncols=3)
    return axes


def _spinning(axes: Any, lines: Any, least: float, most: float) -> None:
    """Draw the spinning states as lines: solid on the surface, dotted above it.

    `lines` are those of `marked_lines`, theta = 0 first; `least` and `most` are limits of D.
    """
    for i, color in enumerate((ink().lower, ink().upper)):
        end = lines.isel(end=i)
        words = f"spinning, {greek(end['end'].item())}"
        path = [end[name].values for name in ("D", "lambda", "E")]
        inside = (least <= path[0]) & (most >= path[0])
        on = inside & end["on_surface"].values
        for keep, style, label in ((inside, ":", f"{words}: above F"), (on, "-", words)):
            if keep.any() and (style == "-" or (inside != on).any()):
                known = (np.where(keep, values, np.nan) for values in path)
                axes.plot(*known, color=color, ls=style, lw=2.0, label=label, zorder=3)


def band(dataset: Any, events: Any, title: str) -> Axes:
    """Draw theta(t) on the predicted band; below, the distances of turnings from its edge.

    The arguments are those that `run_landscape.band` returns; events: time, theta, edge
    (predicted).
    """
    colours = ink()
    away = np.abs(events["theta"].values - events["edge"].values)
    ax, *lower = panels_over_time(1.4 if np.isfinite(away).any() else 0)
    dataset = dataset.isel(time=every(dataset.sizes["time"]))
    t, low, high = (dataset[name].values for name in ("time", "theta_min", "theta_max"))
    words = "predicted band, V(θ) ≤ Ẽ(t)"
    if not np.isfinite(high).all():
        words += "; none on the stem, in the air"
    ax.fill_between(t, low, high, color=colours.upper, alpha=0.18, lw=0, label=words)
    ax.plot(t, high, color=colours.upper, lw=0.5, label="its upper edge")
    ax.plot(t, low, color=colours.lower, lw=0.5, label="its lower edge")
    least = np.where(np.isfinite(high), dataset["theta_star"].values, np.nan)
    ax.plot(t, least, color=colours.quiet, lw=0.8, ls="--", label="θ of least V")
    if "theta" in dataset:
        ax.plot(t, dataset["theta"], color=colours.run, lw=0.7, label="θ(t)")
    when = events["time"].values
    if away.size:
        dots: Any = {"s": 6, "lw": 0, "zorder": 3, "label": "logged turnings"}
        ax.scatter(when, events["theta"], color=colours.mark, **dots)
    ax.margins(y=0.04)
    ticks_of_inclination(ax)
    ax.set(ylabel="inclination θ (rad)", title=heading(title), xlim=(t[0], t[-1]))
    legend(ax, "upper right", ncols=4, markerscale=2)
    for below in lower:
        shown = np.where(away > EXACT, away, np.nan)
        below.semilogy(when, shown, ".", ms=3, color=colours.run)
        below.set_ylabel("|logged − edge|\n(rad)")
    return ax

"""Figures of the landscape: the minimal surface and the band."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..columns import SUPERSCRIPTS, greek, units_text
from .labels import end_of
from .style import (
    compact,
    figure,
    heading,
    ink,
    legend,
    mark_ends,
    panels_over_time,
    ticks_of_inclination,
)
from .thinning import every


FACETS = 140  # of the surface in 3-D, along each axis
EXACT = 1e-17  # [rad] smaller distances from the edge of the band are not drawn


def surface(grid: Any, lines: Any = None, run: Any = None, title: str = "", ax: Any = None) -> Any:
    """Draw F(D, lambda) in 3-D [figure 4.1 of the source], with the spinning states and a run.

    Parameters
    ----------
    grid, lines
        As returned by `minimal_surface` and `marked_lines`.
    run
        routh, jellett and modified_energy of a run.
    title
        The body.
    ax
        Axes in 3-D of the user's.
    """
    axes: Any = (
        figure(8.6, 6.4).add_subplot(projection="3d", computed_zorder=False) if ax is None else ax
    )
    few = (np.unique(np.linspace(0, n - 1, FACETS).astype(int)) for n in grid["F"].shape)
    part = grid["F"][*few]
    momenta = [part[name] for name in part.dims]
    sizes = [_size(momentum.values) for momentum in momenta]
    X, Y = np.meshgrid(*(v / s for v, s in zip(momenta, sizes, strict=True)), indexing="ij")
    F = 1e3 * part.values
    axes.plot_surface(X, Y, F, cmap="viridis", rstride=1, cstride=1, lw=0, antialiased=False)
    low, high = np.nanmin(F), np.nanmax(F)
    if lines is not None:
        _spinning(axes, lines, X.min(), X.max(), sizes)
    if run is not None:
        run = run.isel(time=every(run.sizes["time"]))
        x, y, z = run["routh"] / sizes[0], run["jellett"] / sizes[1], 1e3 * run["modified_energy"]
        axes.plot(x, y, z, color=ink().mark, lw=1.1, label="run", zorder=4)
        mark_ends(axes, x.values, y.values, z.values, last=end_of(z.values))
        high = max(high, float(np.nanmax(z)))
    small = compact()
    for name, momentum, size in zip("xy", momenta, sizes, strict=True):
        label = _label(momentum, size, brief=small)
        getattr(axes, f"set_{name}label")(label, labelpad=-4 if small else 12)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("energy (mJ)", labelpad=-2 if small else 6, rotation=90)
    axes.locator_params(nbins=4 if small else 5)
    axes.tick_params(pad=-2 if small else 3)
    axes.set_zlim(low, high)
    axes.set_box_aspect((1.15, 1, 0.75), zoom=0.85 if small else 1.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color(ink().paper)
    axes.view_init(elev=28, azim=-108)
    words = f"Minimal surface F({greek(', '.join(part.dims))}), the least energy"
    axes.set_title(f"{title}\n{words}" if title and not small else words)
    legend(axes, "lower center", ncols=3)
    return axes


def _spinning(axes: Any, lines: Any, least: float, most: float, sizes: list[float]) -> None:
    """Draw the spinning states as lines: solid on the surface, dotted above it."""
    for i, color in enumerate((ink().lower, ink().upper)):
        end = lines.isel(end=i)
        angle = end["end"].item().replace("theta", "θ").replace("pi", "π")
        words = f"spinning, {angle}"
        D = end["D"].values / sizes[0]
        inside = (least <= D) & (most >= D)
        on = inside & end["on_surface"].values
        for keep, style, label in ((inside, ":", f"{words}: above F"), (on, "-", words)):
            if keep.any() and (style == "-" or (inside != on).any()):
                place = (D, end["lambda"].values / sizes[1], 1e3 * end["E"].values)
                known = (np.where(keep, values, np.nan) for values in place)
                axes.plot(*known, color=color, ls=style, lw=2.0, label=label, zorder=3)


def band(dataset: Any, events: Any, title: str, ax: Axes | None = None) -> Axes:
    """Draw theta(t) on the predicted band; below, the distances of turnings from its edge.

    `dataset` as returned by `band`; events: time, theta, edge (predicted).
    """
    colours = ink()
    away = np.abs(events["theta"].values - events["edge"].values)
    ax, below = panels_over_time(ax, 1.4 if np.isfinite(away).any() else 0)
    dataset = dataset.isel(time=every(dataset.sizes["time"]))
    t, low, high = (dataset[name].values for name in ("time", "theta_min", "theta_max"))
    words = "predicted band, V(θ) ≤ Ẽ(t)"
    if not np.isfinite(high).all():
        words += "; none on the stem, in the air"
    ax.fill_between(t, low, high, color=colours.upper, alpha=0.18, lw=0, label=words)
    ax.plot(t, high, color=colours.upper, lw=0.5)
    ax.plot(t, low, color=colours.lower, lw=0.5)
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
    if below is not None:
        shown = np.where(away > EXACT, away, np.nan)
        below.semilogy(when, shown, ".", ms=3, color=colours.run)
        below.set_ylabel("|logged − edge|\n(rad)")
    (below or ax).set_xlabel("time t (s)")
    return ax


def _size(values: np.ndarray) -> float:
    """Return the power of ten in units of which values are readable."""
    largest = float(np.nanmax(np.abs(values)))
    return 10.0 ** (3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0)


def _label(values: Any, size: float, *, brief: bool = False) -> str:
    """Return the label of an axis: the name of a momentum, a power of ten and its unit."""
    power = str(round(np.log10(size))).translate(SUPERSCRIPTS)
    words = greek(values.name if brief else values.attrs["long_name"])
    return f"{words} ({f'10{power} ' if size != 1 else ''}{units_text(values.attrs['units'])})"

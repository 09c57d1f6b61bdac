"""Figures of the landscape: the minimal surface, the band, the inversion in its plane.

No physics.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..columns import SUPERSCRIPTS, units_text
from .labels import end_of
from .style import (
    compact,
    figure,
    heading,
    ink,
    legend,
    mark_ends,
    panel,
    panels_over_time,
    ticks_of_pi,
)
from .theta import WIDE


MOST_POINTS = 20_000
FACETS = 140  # of the surface in 3-D, along each axis
EXACT = 1e-17  # rad: a turning angle nearer to the edge of the band is on it


def surface(grid: Any, lines: Any = None, run: Any = None, title: str = "", ax: Any = None) -> Any:
    """F(D, lambda) in 3-D [figure 4.1 of the source], with the spinning states and a run on it.

    `grid` as `minimal_surface` gives it, `lines` as `marked_lines`; `run` has routh, jellett and
    modified_energy. A panel that is given must be one in 3-D.
    """
    axes: Any = (
        figure(8.6, 6.4).add_subplot(projection="3d", computed_zorder=False) if ax is None else ax
    )
    colours = ink()
    x_name, y_name = grid["F"].dims
    rows, columns = (np.unique(np.linspace(0, n - 1, FACETS).astype(int)) for n in grid["F"].shape)
    part = grid["F"][rows, columns]
    x_scale, y_scale = (_scale(grid[name].values) for name in (x_name, y_name))
    X, Y = np.meshgrid(
        part[x_name].values / x_scale[0], part[y_name].values / y_scale[0], indexing="ij"
    )
    F = 1e3 * part.values
    axes.plot_surface(
        X, Y, F, cmap="viridis", rstride=1, cstride=1, lw=0, alpha=0.9, antialiased=False, zorder=1
    )
    low, high = np.nanmin(F), np.nanmax(F)
    if lines is not None:
        _spinning(axes, lines, grid[x_name].values, x_scale[0], y_scale[0])
    if run is not None:
        step = max(1, run["routh"].size // MOST_POINTS)
        sizes = {"routh": 1 / x_scale[0], "jellett": 1 / y_scale[0], "modified_energy": 1e3}
        x, y, z = (run[name].values[::step] * size for name, size in sizes.items())
        axes.plot(x, y, z, color=colours.mark, lw=1.1, label="run", zorder=4)
        mark_ends(axes, x, y, z, last=end_of(z), sizes=(6, 6))
        high = max(high, float(np.nanmax(z)))
    small = compact()
    called, pad = (_symbol, -4) if small else (_name, 12)
    axes.set_xlabel(f"{called(x_name)} ({x_scale[1]}{_unit(grid[x_name])})", labelpad=pad)
    axes.set_ylabel(f"{called(y_name)} ({y_scale[1]}{_unit(grid[y_name])})", labelpad=pad)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel("energy (mJ)", labelpad=0.5 * pad, rotation=90)
    axes.locator_params(nbins=4 if small else 5)
    axes.tick_params(pad=-2 if small else 3)
    axes.set_zlim(low, high)
    axes.set_box_aspect((1.15, 1, 0.75), zoom=0.85 if small else 1.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color(colours.paper)
    axes.view_init(elev=28, azim=-108)
    words = f"Minimal surface F({_symbol(x_name)}, {_symbol(y_name)}), the least energy"
    axes.set_title(f"{title}\n{words}" if title and not small else words)
    legend(axes, "lower center", ncols=3)
    return axes


def _spinning(axes: Any, lines: Any, x: np.ndarray, x_size: float, y_size: float) -> None:
    """The spinning states as lines: solid on the surface, dotted above it; the one begins where the
    other ends.
    """
    colours = ink()
    for i, (end, color) in enumerate(
        zip(lines["end"].values, (colours.lower, colours.upper), strict=True)
    ):
        line = lines.isel(end=i)
        inside = ((line["D"] >= x.min()) & (line["D"] <= x.max())).values
        on = line["on_surface"].values
        words = str(end).replace("theta", "θ").replace("pi", "π")
        for keep, style, more in ((inside & on, "-", ""), (inside & ~on, ":", ": above F")):
            if not keep.any():
                continue
            if more:  # from the last point on the surface on
                keep = keep | (inside & (np.r_[keep[1:], False] | np.r_[False, keep[:-1]]))
            sizes = {"D": 1 / x_size, "lambda": 1 / y_size, "E": 1e3}
            place = (np.where(keep, line[name] * size, np.nan) for name, size in sizes.items())
            axes.plot(
                *place, color=color, ls=style, lw=2.0, label=f"spinning, {words}{more}", zorder=3
            )


def band(dataset: Any, events: Any, title: str, ax: Axes | None = None) -> Axes:
    """theta(t) on the nutational band that the main equation predicts; logged turning angles as
    dots; below, how far they lie from the nearer edge of the band. `dataset` as `band` gives it;
    events: time, theta, edge (predicted).
    """
    colours = ink()
    away = np.abs(events["theta"].values - events["edge"].values)
    ax, below = panels_over_time(ax, 1.4 if np.isfinite(away).any() else 0)
    step = max(1, dataset["time"].size // MOST_POINTS)
    t, low, high = (dataset[name].values[::step] for name in ("time", "theta_min", "theta_max"))
    words = "predicted band, V(θ) ≤ Ẽ(t)"
    if not np.isfinite(high).all():
        words += "; none on the stem, in the air"
    ax.fill_between(t, low, high, color=colours.upper, alpha=0.18, lw=0, label=words)
    ax.plot(t, high, color=colours.upper, lw=0.5)
    ax.plot(t, low, color=colours.lower, lw=0.5)
    least = np.where(np.isfinite(high), dataset["theta_star"].values[::step], np.nan)
    ax.plot(t, least, color=colours.quiet, lw=0.8, ls="--", label="θ of least V")
    values = [low, high]
    if "theta" in dataset:
        values.append(dataset["theta"].values[::step])
        ax.plot(t, values[-1], color=colours.run, lw=0.7, label="θ(t)")
    if away.size:
        ax.scatter(
            events["time"],
            events["theta"],
            s=6,
            color=colours.mark,
            lw=0,
            zorder=3,
            label="logged turnings",
        )
    bottom, top = np.nanmin(np.concatenate(values)), np.nanmax(np.concatenate(values))
    room = max(0.04 * (top - bottom), 1e-3)
    if top - bottom > WIDE:
        ticks_of_pi(ax)
    ax.set(
        ylabel="inclination θ (rad)",
        title=heading(title),
        ylim=(bottom - room, top + room),
        xlim=(t[0], t[-1]),
    )
    legend(ax, "upper right", ncols=4, markerscale=2)
    if below is not None:
        exact = int((away <= EXACT).sum())
        below.semilogy(
            events["time"].values,
            np.where(away > EXACT, away, np.nan),
            ".",
            ms=3,
            color=colours.run,
        )
        below.set_ylabel("|logged − edge|\n(rad)")
        if exact:
            below.set_title(
                f"{exact} of {len(away)} exactly on the edge", fontsize="small", loc="right", pad=2
            )
        apart = away[np.isfinite(away) & (away > EXACT)]
        if len(apart):
            below.set_ylim(apart.min() / 5, apart.max() * 5)
    (below or ax).set_xlabel("time t (s)")
    return ax


def inversion(section: Any, lines: Any, run: Any, title: str = "", ax: Axes | None = None) -> Axes:
    """(D(t), E~(t)) of a run on the plane lambda = const, over the section of the minimal surface.

    `section`: F along D at that lambda; `lines`: marked lines at that lambda: the boundary values
    (D0, E0), (D1, E1).
    """
    colours = ink()
    ax = panel(ax, 9, 5.8)
    D, F = section["D"].values, 1e3 * section["F"].values.ravel()
    size, power = _scale(D)
    step = max(1, run["routh"].size // MOST_POINTS)
    ax.fill_between(
        D / size,
        F,
        F.min() - 10 * np.ptp(F),
        color=colours.quiet,
        alpha=0.22,
        lw=0,
        label="below F: no motion",
    )
    ax.plot(D / size, F, color=colours.quiet, lw=1.4, label="minimal surface F")
    x, y = run["routh"].values[::step] / size, 1e3 * run["modified_energy"].values[::step]
    ax.plot(x, y, color=colours.run, lw=0.8, label="run (D(t), Ẽ(t))")
    mark_ends(ax, x, y)
    for i, (words, color) in enumerate((("θ = 0", colours.lower), ("θ = π", colours.upper))):
        end = lines.isel(end=i)
        where = float(end["D"].values.ravel()[0]) / size, 1e3 * float(end["E"].values.ravel()[0])
        ax.scatter(
            *where,
            s=90,
            facecolors="none",
            edgecolors=color,
            lw=1.6,
            zorder=5,
            label=f"spinning, {words}",
        )
    bottom, top = min(np.nanmin(y), F.min()), max(np.nanmax(y), 1e3 * float(lines["E"].max()))
    ax.set_ylim(bottom - 0.12 * (top - bottom), top + 0.12 * (top - bottom))
    ax.set(
        xlabel=f"Routh's function D ({power}{_unit(section['D'])})",
        ylabel="energy (mJ)",
        title=heading(title),
        xlim=(D[0] / size, D[-1] / size),
    )
    legend(ax, "lower center", ncols=4)
    return ax


def _scale(values: np.ndarray) -> tuple[float, str]:
    """A power of ten that makes the values readable, and how it is written before a unit."""
    largest = float(np.nanmax(np.abs(values)))
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    return 10.0**power, f"10{str(power).translate(SUPERSCRIPTS)} " if power else ""


def _symbol(name: Any) -> str:
    return {"lambda": "λ", "L3": "$L_3$", "Lz": "$L_z$"}.get(str(name), str(name))


def _name(name: Any) -> str:
    """An axis of the surface by name and symbol."""
    words = {"D": "Routh's function", "lambda": "Jellett's integral"}.get(
        str(name), "angular momentum"
    )
    return f"{words} {_symbol(name)}"


def _unit(values: Any) -> str:
    return units_text(str(values.attrs.get("units", "")))

"""Figures of the landscape: the minimal surface, the potential, the band, the inversion in its plane. No physics."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..columns import units_text
from .style import LOWER, QUIET, RUN, UPPER, figure


MOST_POINTS = 20_000
FACETS = 140  # of the surface in 3-D, along each axis


def surface(grid: Any, lines: Any = None, run: Any = None) -> Figure:
    """F(D, lambda) in 3-D [figure 4.1 of the source], with the spinning states and a run on it.

    `grid` as `minimal_surface` gives it, `lines` as `marked_lines`; `run` has routh, jellett and modified_energy.
    """
    fig = figure(9.5, 7.2)
    axes: Any = fig.add_subplot(projection="3d", computed_zorder=False)
    x_name, y_name = grid["F"].dims
    rows, columns = (np.unique(np.linspace(0, n - 1, FACETS).astype(int)) for n in grid["F"].shape)
    part = grid["F"][rows, columns]
    x_scale, y_scale = (_scale(grid[name].values) for name in (x_name, y_name))
    X, Y = np.meshgrid(part[x_name].values / x_scale[0], part[y_name].values / y_scale[0], indexing="ij")
    F = 1e3 * part.values
    axes.plot_surface(X, Y, F, cmap="viridis", rstride=1, cstride=1, lw=0, alpha=0.82, antialiased=True, zorder=1)
    low, high = np.nanmin(F), np.nanmax(F)
    if lines is not None:
        for i, (end, color) in enumerate(zip(lines["end"].values, (LOWER, UPPER), strict=True)):
            line = lines.isel(end=i)
            inside = (line["D"] >= grid[x_name].min()) & (line["D"] <= grid[x_name].max())
            at = {"above": inside & ~line["on_surface"], "on": inside & line["on_surface"]}
            words = str(end).replace("theta", "θ").replace("pi", "π")
            for where, style in (("on", "-"), ("above", ":")):
                keep = at[where].values
                if keep.any():
                    label = f"spinning, {words}" + ("" if where == "on" else ": above F")
                    axes.plot(
                        line["D"].values[keep] / x_scale[0],
                        line["lambda"].values[keep] / y_scale[0],
                        1e3 * line["E"].values[keep],
                        color=color,
                        ls=style,
                        lw=2.0,
                        label=label,
                        zorder=3,
                    )
    if run is not None:
        step = max(1, run["routh"].size // MOST_POINTS)
        path = [run[name].values[::step] for name in ("routh", "jellett", "modified_energy")]
        axes.plot(
            path[0] / x_scale[0], path[1] / y_scale[0], 1e3 * path[2], color="#111111", lw=1.1, label="run", zorder=4
        )
        high = max(high, 1e3 * float(np.max(path[2])))
    axes.set_xlabel(f"{_symbol(x_name)} ({x_scale[1]} {_unit(grid[x_name])})", labelpad=10)
    axes.set_ylabel(f"{_symbol(y_name)} ({y_scale[1]} {_unit(grid[y_name])})", labelpad=10)
    axes.set_zlabel("energy (mJ)", labelpad=6)
    axes.set_zlim(low, high)
    axes.set_box_aspect((1.15, 1, 0.75), zoom=0.92)
    axes.view_init(elev=28, azim=-108)
    axes.set_title(f"minimal surface F({_symbol(x_name)}, {_symbol(y_name)})")
    if lines is not None or run is not None:
        axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.98))
    return fig


def potential(curves: list[tuple[str, Any, Any]]) -> Figure:
    """V(z) with the energy level and the turning angles, a panel for each (title, potential, turning angles).

    The potential has V along z; the turning angles have F, theta_star, and, where a level is drawn, energy, theta_min
    and theta_max.
    """
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    fig = figure(1.2 + 3.6 * columns if columns > 1 else 7.5, 0.6 + (3.0 * rows if columns > 1 else 4.4))
    panels = np.atleast_1d(fig.subplots(rows, columns, sharex=True)).ravel()
    for axes, (title, V, at) in zip(panels, curves, strict=False):
        _well(axes, title, V, at)
    for axes in panels[len(curves) :]:
        axes.set_visible(False)
    for axes in panels[:: max(columns, 1)]:
        axes.set_ylabel("V (mJ)")
    for axes in panels[max(0, len(curves) - columns) : len(curves)]:
        axes.set_xlabel("z = cos θ")
        axes.tick_params(labelbottom=True)
    return fig


def _well(axes: Any, title: str, V: Any, at: Any) -> None:
    """One potential with its level; the numbers stand above, where no curve is."""
    z, values, least = V["z"].values, 1e3 * V["V"].values.ravel(), 1e3 * float(at["F"])
    axes.plot(z, values, color=RUN, lw=1.4)
    axes.scatter([np.cos(float(at["theta_star"]))], [least], s=24, color=QUIET, zorder=3, clip_on=False)
    height = 0.35 * (np.percentile(values[np.isfinite(values)], 70) - least)
    if "energy" in at:
        level = 1e3 * float(at["energy"])
        height = max(level - least, 0.06 * height)
        inner, outer = float(at["theta_min"]), float(at["theta_max"])
        axes.axhline(level, color=UPPER, lw=0.6, ls=":")
        axes.hlines(level, np.cos(outer), np.cos(inner), color=UPPER, lw=1.6)
        for angle, color in ((outer, UPPER), (inner, LOWER)):
            axes.scatter([np.cos(angle)], [level], s=24, color=color, zorder=3, clip_on=False)
        words = f"{np.degrees(inner):.4g}° ≤ θ ≤ {np.degrees(outer):.4g}°, Ẽ = {level:.5g}, F = {least:.5g} mJ"
    else:
        words = f"F = {least:.4g} mJ at θ = {np.degrees(float(at['theta_star'])):.4g}°"
    axes.set_title(f"{title}\n{words}", fontsize=9.5)
    axes.set_xticks([-1, -0.5, 0, 0.5, 1])
    axes.set(xlim=(-1, 1), ylim=(least - 0.2 * height, least + 2.8 * height))


def band(dataset: Any, events: Any = None, title: str = "") -> Figure:
    """theta(t) on the nutational band that the main equation predicts; logged turning angles as dots; below, how far
    they lie from the nearer edge of the band. `found` as `band` gives it; events: time, theta, edge (predicted)."""
    fig = figure(10, 6.4)
    axes, below = fig.subplots(2, sharex=True, height_ratios=(4, 1.4))
    step = max(1, dataset["time"].size // MOST_POINTS)
    t, low, high = (dataset[name].values[::step] for name in ("time", "theta_min", "theta_max"))
    axes.fill_between(t, low, high, color=UPPER, alpha=0.18, lw=0, label="predicted band, V(θ) ≤ Ẽ(t)")
    axes.plot(t, high, color=UPPER, lw=0.5)
    axes.plot(t, low, color=LOWER, lw=0.5)
    axes.plot(t, dataset["theta_star"].values[::step], color=QUIET, lw=0.8, ls="--", label="θ of least V")
    if "theta" in dataset:
        axes.plot(t, dataset["theta"].values[::step], color=RUN, lw=0.7, label="θ(t)")
    if events is not None and events["time"].size:
        axes.scatter(events["time"], events["theta"], s=6, color="#111111", lw=0, zorder=3, label="logged turnings")
        away = np.abs(events["theta"].values - events["edge"].values)
        below.semilogy(events["time"].values, np.maximum(away, 1e-17), ".", ms=3, color=RUN)
    known = np.isfinite(high).any()
    bottom, top = (float(np.nanmin(low)), float(np.nanmax(high))) if known else (0.0, np.pi)
    span = max(top - bottom, 1e-3)
    if span > 1.2:
        axes.set_yticks(np.arange(5) * np.pi / 4, ["0", "π/4", "π/2", "3π/4", "π"])
    room = 0.06 if span > 1.2 else 0.55  # for the legend: an inversion leaves it room at the left
    axes.set(ylabel="θ (rad)", title=title, ylim=(bottom - 0.04 * span, top + room * span), xlim=(t[0], t[-1]))
    axes.legend(loc="upper left", markerscale=2)
    below.set(xlabel="t (s)", ylabel="logged − edge (rad)")
    return fig


def inversion(section: Any, lines: Any, run: Any, title: str = "") -> Figure:
    """(D(t), E~(t)) of a run on the plane lambda = const, over the section of the minimal surface.

    `section`: F along D at that lambda; `lines`: marked lines at that lambda: the boundary values (D0, E0), (D1, E1).
    """
    fig = figure(9, 5.4)
    axes = fig.subplots()
    D, F = section["D"].values, 1e3 * section["F"].values.ravel()
    scale, power = _scale(D)
    step = max(1, run["routh"].size // MOST_POINTS)
    axes.fill_between(D / scale, F, F.min() - 10 * np.ptp(F), color=QUIET, alpha=0.22, lw=0, label="below F")
    axes.plot(D / scale, F, color=QUIET, lw=1.4, label="minimal surface F")
    x, y = run["routh"].values[::step] / scale, 1e3 * run["modified_energy"].values[::step]
    axes.plot(x, y, color=RUN, lw=0.8, label="run (D(t), Ẽ(t))")
    axes.scatter(x[[0, -1]], y[[0, -1]], s=30, color=RUN, marker="x", zorder=4)
    axes.annotate("start", (x[0], y[0]), xytext=(-8, 8), textcoords="offset points", ha="right", color=RUN)
    axes.annotate("end", (x[-1], y[-1]), xytext=(-4, -18), textcoords="offset points", color=RUN)
    for i, (words, color) in enumerate((("θ = 0", LOWER), ("θ = π", UPPER))):
        end = lines.isel(end=i)
        where = float(end["D"].values.ravel()[0]) / scale, 1e3 * float(end["E"].values.ravel()[0])
        axes.scatter(*where, s=46, facecolors="none", edgecolors=color, lw=1.6, zorder=5, label=f"spinning, {words}")
    bottom, top = min(y.min(), F.min()), max(y.max(), 1e3 * float(lines["E"].max()))
    axes.set_ylim(bottom - 0.12 * (top - bottom), top + 0.12 * (top - bottom))
    axes.set(
        xlabel=f"D ({power} {_unit(section['D'])})",
        ylabel="energy (mJ)",
        title=title,
        xlim=(D[0] / scale, D[-1] / scale),
    )
    axes.legend(loc="upper center")
    return fig


def _scale(values: np.ndarray) -> tuple[float, str]:
    """A power of ten that makes the values readable, and how it is written."""
    largest = float(np.nanmax(np.abs(values)))
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    return 10.0**power, f"$10^{{{power}}}$" if power else ""


def _symbol(name: Any) -> str:
    return {"lambda": "λ", "L3": "$L_3$", "Lz": "$L_z$"}.get(str(name), str(name))


def _unit(values: Any) -> str:
    return units_text(str(values.attrs.get("units", "")))

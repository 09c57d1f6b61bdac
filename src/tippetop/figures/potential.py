"""The effective potential V(z) with the level of the energy and the turning angles, a panel for each time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .energetics import in_joules
from .labels import number
from .style import compact, figure, ink, legend


REACH = 2.8  # how high a panel without a level is above the least V
FEW = 3  # every third panel where there is no room for all
MARGIN = np.radians(4.0)  # at least this is shown beside the band


def potential(curves: list[tuple[str, Any, Any]], title: str = "", ax: Axes | None = None) -> Axes:
    """V(z) with the energy level and the turning angles, a panel for each (title, potential, turning angles).

    The potential has V along z; the turning angles have F, theta_star, and, where a level is drawn, energy, theta_min
    and theta_max. In a panel that is given the first of them is drawn.
    """
    if ax is not None:
        _well(ax, *curves[0])
        ax.set(xlabel="z = cos θ", ylabel=f"V ({_unit(curves)[1]})")
        ax.legend()
        return ax
    curves = curves[:: FEW if compact() else 1]
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    fig = figure(1.2 + 3.8 * columns if columns > 1 else 7.5, 1.3 + (2.9 * rows if columns > 1 else 4.4))
    panels = np.atleast_1d(fig.subplots(rows, columns)).ravel()
    for axes, (words, V, at) in zip(panels, curves, strict=False):
        _well(axes, words, V, at, _unit(curves))
    for axes in panels[len(curves) :]:
        axes.remove()
    for axes in panels[: len(curves) : columns]:
        axes.set_ylabel(f"V ({_unit(curves)[1]})")
    for axes in panels[max(0, len(curves) - columns) : len(curves)]:
        axes.set_xlabel("z = cos θ")
    legend(panels[0], "lower center", own=True, ncols=5)
    fig.suptitle(title or "Effective potential V(z)", x=0.01, ha="left")
    return panels[0]


def _unit(curves: list[tuple[str, Any, Any]]) -> tuple[float, str]:
    """The unit of all panels [J] and its name."""
    levels = [abs(float(at[name])) for _, _, at in curves for name in ("F", "energy") if name in at]
    return in_joules(max(levels))


def _degrees(angle: float) -> str:
    """An angle in degrees, to a hundredth."""
    return f"{np.degrees(angle):.2f}".rstrip("0").rstrip(".") + "°"


def _around(
    z: np.ndarray, values: np.ndarray, inner: float, outer: float, least: float
) -> tuple[tuple[float, float], float]:
    """The part of z around a band, and the height to which V is drawn there: to its lower end, or this at least."""
    margin = max(MARGIN, 0.7 * (outer - inner))
    window = float(np.cos(min(np.pi, outer + margin))), float(np.cos(max(0.0, inner - margin)))
    seen = values[(z >= window[0]) & (z <= window[1]) & np.isfinite(values)]
    return window, max(float(min(seen[0], seen[-1])), least)


def _well(axes: Axes, title: str, V: Any, at: Any, unit: tuple[float, str] | None = None) -> None:
    """One potential with its level; the numbers stand above, where no curve is."""
    colours = ink()
    size, name = unit or in_joules(float(at["F"]))
    z, values, least = V["z"].values, V["V"].values.ravel() / size, float(at["F"]) / size
    axes.plot(z, values, color=colours.run, lw=1.4, label="V(z)")
    star = float(at["theta_star"])
    axes.scatter(
        [np.cos(star)], [least], s=28, color=colours.quiet, zorder=3, clip_on=False, label="least V, which is F"
    )
    window = (-1.0, 1.0)
    high = least + REACH * 0.35 * (np.percentile(values[np.isfinite(values)], 70) - least)
    words = f"F = {number(least, 5)} {name} at θ = {_degrees(star)}"
    if "energy" in at:
        level = float(at["energy"]) / size
        inner, outer = float(at["theta_min"]), float(at["theta_max"])
        axes.axhline(level, color=colours.upper, lw=0.6, ls=":")
        if np.isfinite(inner) and level >= least:
            window, high = _around(z, values, inner, outer, level + 0.6 * (level - least))
            axes.hlines(level, np.cos(outer), np.cos(inner), color=colours.upper, lw=1.6, label="level Ẽ")
            for angle, color, dot in ((outer, colours.upper, "θ greatest"), (inner, colours.lower, "θ least")):
                axes.scatter([np.cos(angle)], [level], s=28, color=color, zorder=3, clip_on=False, label=dot)
            words = f"{_degrees(inner)} ≤ θ ≤ {_degrees(outer)}\nẼ = {number(level, 5)}, F = {number(least, 5)} {name}"
        else:
            words = f"no band: Ẽ = {number(level, 5)} {name}\nlies below F = {number(least, 5)} {name}"
    axes.set_title(f"{title}\n{words}" if title else words, fontsize="small")
    axes.set(xlim=window, ylim=(least - 0.08 * (high - least), high))
    axes.locator_params(axis="x", nbins=5)
    axes.tick_params(labelsize="small")

"""The effective potential V(z) with the level of the energy and the turning angles, a panel for
each time.
"""

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
    """V(z) with the energy level and the turning angles, a panel for each (title, potential,
    turning angles).

    The potential has V along z; the turning angles have F, theta_star, and, where a level is drawn,
    energy, theta_min and theta_max. In a panel that is given the first of them is drawn.
    """
    curves = curves[:1] if ax is not None else curves[:: FEW if compact() else 1]
    unit = in_joules(
        max(abs(float(at[name])) for _, _, at in curves for name in ("F", "energy") if name in at)
    )
    labels = {"xlabel": "z = cos θ", "ylabel": f"V ({unit[1]})"}
    if ax is not None:
        _well(ax, *curves[0], unit)
        ax.set(**labels)
        ax.legend()
        return ax
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    fig = figure(
        1.2 + 3.8 * columns if columns > 1 else 7.5, 1.3 + (2.9 * rows if columns > 1 else 4.4)
    )
    panels = np.atleast_1d(fig.subplots(rows, columns)).ravel()
    for i, (axes, curve) in enumerate(zip(panels, curves, strict=False)):
        _well(axes, *curve, unit)
        axes.set_xlabel(labels["xlabel"] if i + columns >= len(curves) else "")
        axes.set_ylabel(labels["ylabel"] if i % columns == 0 else "")
    for axes in panels[len(curves) :]:
        axes.remove()
    legend(panels[0], "lower center", ncols=5)
    fig.suptitle(title or "Effective potential V(z)", x=0.01, ha="left")
    return panels[0]


def _degrees(angle: float) -> str:
    """An angle in degrees, to a hundredth."""
    return f"{np.degrees(angle):.2f}".rstrip("0").rstrip(".") + "°"


def _well(axes: Axes, title: str, V: Any, at: Any, unit: tuple[float, str]) -> None:
    """One potential with its level; the numbers stand above, where no curve is."""
    colours = ink()
    size, name = unit
    z, values, least = V["z"].values, V["V"].values.ravel() / size, float(at["F"]) / size
    axes.plot(z, values, color=colours.run, lw=1.4, label="V(z)")
    star = float(at["theta_star"])
    axes.scatter(
        [np.cos(star)],
        [least],
        s=28,
        color=colours.quiet,
        zorder=3,
        clip_on=False,
        label="least V, which is F",
    )
    window = (-1.0, 1.0)
    high = least + REACH * 0.35 * (np.percentile(values[np.isfinite(values)], 70) - least)
    words = f"F = {number(least, 5)} {name} at θ = {_degrees(star)}"
    if "energy" in at:
        level = float(at["energy"]) / size
        inner, outer = float(at["theta_min"]), float(at["theta_max"])
        axes.axhline(level, color=colours.upper, lw=0.6, ls=":")
        if np.isfinite(inner) and level >= least:
            margin = max(MARGIN, 0.7 * (outer - inner))
            window = (
                float(np.cos(min(np.pi, outer + margin))),
                float(np.cos(max(0.0, inner - margin))),
            )
            seen = values[(z >= window[0]) & (z <= window[1]) & np.isfinite(values)]
            high = max(float(min(seen[0], seen[-1])), level + 0.6 * (level - least))
            axes.hlines(
                level, np.cos(outer), np.cos(inner), color=colours.upper, lw=1.6, label="level Ẽ"
            )
            for angle, color, dot in (
                (outer, colours.upper, "θ greatest"),
                (inner, colours.lower, "θ least"),
            ):
                axes.scatter(
                    [np.cos(angle)], [level], s=28, color=color, zorder=3, clip_on=False, label=dot
                )
            words = (
                f"{_degrees(inner)} ≤ θ ≤ {_degrees(outer)}\nẼ = {number(level, 5)}, F = "
                f"{number(least, 5)} {name}"
            )
        else:
            words = (
                f"no band: Ẽ = {number(level, 5)} {name}\nlies below F = {number(least, 5)} {name}"
            )
    axes.set_title(f"{title}\n{words}" if title else words, fontsize="small")
    axes.set(xlim=window, ylim=(least - 0.08 * (high - least), high))
    axes.locator_params(axis="x", nbins=5)
    axes.tick_params(labelsize="small")

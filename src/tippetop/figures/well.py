"""The effective potential V(z) with the energy level and the turning angles at several times.

Datasets of `landscape.potential` and `turning` go in, Axes come out.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from .style import compact, figure, ink, legend, ticks_in_joules, users_panel


REACH = 0.98  # height of a panel without a level, by that of the 70th percentile of V
FEW = 3  # every third panel in a compact figure
MARGIN = np.radians(4.0)  # at least this is shown on either side of the band


def potential(curves: list[tuple[str, Any, Any]], title: str = "") -> Axes:
    """Draw V(z) with the energy level and the turning angles, a panel for each time.

    `curves` are titles, potentials and turning angles, as `run_landscape.potential` returns them.

    The potential has V along z; the turning angles have F, theta_star, and, where a level is drawn,
    energy, theta_min and theta_max. In a panel of the user's only the first one is drawn.
    """
    if ax := users_panel():
        _well(ax, *curves[0])
        legend(ax, "best")
        return ax
    curves = curves[:: FEW if compact() else 1]
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    size = (1.2 + 3.8 * columns, 1.3 + 2.9 * rows) if columns > 1 else (7.5, 5.7)
    fig = figure(*size)
    for place, curve in enumerate(curves, 1):
        _well(fig.add_subplot(rows, columns, place), *curve)
    legend(fig.axes[0], "lower center", ncols=5)
    fig.suptitle(title or "Effective potential V(z)", x=0.01, ha="left")
    return fig.axes[0]


def _well(axes: Axes, title: str, V: Any, at: Any) -> None:
    """Draw one potential with its level into `axes`; the numbers are added to the title.

    `V` and `at` are Datasets as of `potential`.
    """
    colours = ink()
    joules = EngFormatter("J")
    z = V["z"].values
    values = V["V"].values.ravel()
    least = float(at["F"])
    axes.plot(z, values, color=colours.run, lw=1.4, label="V(z)")
    star = float(at["theta_star"])
    dots = [(star, least, colours.quiet, "least V, which is F")]
    window = (-1.0, 1.0)
    high = least + REACH * (np.percentile(values[np.isfinite(values)], 70) - least)
    words = f"F = {joules(least)} at θ = {np.degrees(star):.4g}°"
    if "energy" in at:
        level, inner, outer = (float(at[name]) for name in ("energy", "theta_min", "theta_max"))
        axes.axhline(level, color=colours.upper, lw=0.9, label="level Ẽ")
        numbers = f"Ẽ = {joules(level)}\nF = {joules(least)}"
        if np.isfinite(inner) and level >= least:
            margin = max(MARGIN, 0.7 * (outer - inner))
            ends = min(np.pi, outer + margin), max(0.0, inner - margin)
            window = (float(np.cos(ends[0])), float(np.cos(ends[1])))
            seen = values[(z >= window[0]) & (z <= window[1]) & np.isfinite(values)]
            high = max(float(min(seen[0], seen[-1])), level + 0.6 * (level - least))
            dots += [
                (outer, level, colours.upper, "θ greatest"),
                (inner, level, colours.lower, "θ least"),
            ]
            words = f"{np.degrees(inner):.2f}° ≤ θ ≤ {np.degrees(outer):.2f}°\n{numbers}"
        else:
            words = f"no band: Ẽ is below F\n{numbers}"
    for angle, height, color, label in dots:
        axes.scatter(np.cos(angle), height, s=28, color=color, zorder=3, clip_on=False, label=label)
    axes.set_title(f"{title}\n{words}" if title else words, fontsize="small")
    axes.set(
        xlim=window, ylim=(least - 0.08 * (high - least), high), xlabel="z = cos θ", ylabel="V"
    )
    ticks_in_joules(axes.yaxis)
    axes.locator_params(axis="x", nbins=5)
    axes.tick_params(labelsize="small")

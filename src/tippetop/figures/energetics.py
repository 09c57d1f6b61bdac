"""Normal force and energies of a run over time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..columns import on_sphere
from .labels import number, title
from .style import dashes, ink, legend, panel, ticks_in_joules
from .thinning import span, thinned


CONSTANT = 1e-9  # relative changes below this cannot be seen; `drift` shows them


def weight(attrs: dict[str, Any]) -> float:
    """Return m g of the body of a run [N]."""
    return float(attrs["parameters"]["m"] * attrs["parameters"]["g"])


def normal_force(
    trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None
) -> Axes:
    """Draw g_n(t) in units of the weight m g."""
    ax = panel(ax, 10, 4.4)
    colours = ink()
    t, mg = trajectory["time"].values, weight(attrs)
    force = trajectory["normal_force"].values / mg
    ax.axhline(1.0, color=colours.quiet, lw=0.8, label="weight")
    ax.axhline(0.0, color=colours.alarm, lw=1.0, ls="--", label="no force")
    ax.plot(*thinned(t, force), color=colours.run, lw=0.8)
    limits = span(t)
    low, high = min(0.0, float(force.min())), max(1.0, float(force.max()))
    extremes = attrs.get("report", {}).get("normal_force") or {}
    for key, color in (("min", colours.lower), ("max", colours.upper)) if extremes else ():
        value, when = extremes[key] / mg, extremes[f"t_{key}"]
        if limits[0] <= when <= limits[1] and np.ptp(force) > CONSTANT and value > CONSTANT:
            words = f"{key} {number(value, 4)} at t = {number(when, 5)} s"
            ax.scatter([when], [value], s=22, color=color, zorder=3, label=words)
    ax.set(
        xlabel="time t (s)", ylabel="normal force $g_n\\,/\\,mg$", title=title(attrs), xlim=limits
    )
    ax.set_ylim(low - 0.12 * (high - low), high + 0.15 * (high - low))
    legend(ax, "upper right", ncols=4)
    return ax


def energy(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """Draw energy E, modified energy E~ and the energy taken by friction."""
    ax = panel(ax, 10, 4.8)
    colours, t = ink(), trajectory["time"].values
    taken = "taken by friction and impacts" if "phase" in trajectory else "taken by friction"
    curves = {
        words: (trajectory[name].values, color)
        for name, words, color in (
            ("modified_energy", "modified energy Ẽ", colours.upper),
            ("energy", "energy E", colours.run),
            ("work", taken, colours.lower),
        )
        if name in trajectory
    }
    touches = on_sphere(trajectory)
    if not touches.all() and "modified energy Ẽ" in curves:
        values, color = curves.pop("modified energy Ẽ")
        words = "modified energy Ẽ; none on the stem, in the air"
        curves[words] = np.where(touches, values, np.nan), color
    energies = trajectory["energy"].values
    change = max(np.nanmax(v) - np.nanmin(v) for v, _ in curves.values() if np.isfinite(v).any())
    level = np.abs(energies).max() or 1.0
    for i, (words, (values, color)) in enumerate(curves.items()):
        ax.plot(*thinned(t, values), color=color, ls=dashes(i), label=words)
    ax.set(xlabel="time t (s)", ylabel="energy", title=title(attrs), xlim=span(t))
    ticks_in_joules(ax.yaxis)
    if change <= CONSTANT * level:
        ax.set_ylim(min(0, 1.3 * energies[0]), max(0, 1.3 * energies[0]))
    legend(ax, "upper right", ncols=3)
    return ax

"""Normal force and energies of a run over time.

`trajectory` and `events` are Datasets of a run in SI units, `attrs` the root attributes of its
store; each function returns the Axes of its panel.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..columns import on_sphere
from .labels import Attributes, number, title
from .style import Curve, draw_curves, ink, legend, panel, ticks_in_joules
from .thinning import span, thinned


CONSTANT = 1e-9  # relative changes below this cannot be seen; `drift` shows them


def draw_over_time(curves: list[Curve], label: str, attrs: Attributes, height: float) -> Axes:
    """Draw curves in a panel of a height [inches], with the label of their values and a title."""
    ax = panel(10, height)
    draw_curves(ax, curves)
    times = np.concatenate([t for _, t, _ in curves])
    ax.set(xlabel="time t (s)", ylabel=label, title=title(attrs), xlim=span(times))
    return ax


def weight(attrs: Attributes) -> float:
    """Return m g of the body of a run [N]."""
    return float(attrs["parameters"]["m"] * attrs["parameters"]["g"])


def normal_force(trajectory: Any, events: Any, attrs: Attributes) -> Axes:
    """Draw g_n(t) in units of the weight m g.

    The least and the greatest value of the run's report, which are those between rows too, are
    marked if they lie in the part that is drawn.
    """
    ax = panel(10, 4.4)
    colours = ink()
    t = trajectory["time"].values
    mg = weight(attrs)
    force = trajectory["normal_force"].values / mg
    ax.axhline(1.0, color=colours.quiet, lw=0.8, label="weight")
    ax.axhline(0.0, color=colours.alarm, lw=1.0, ls="--", label="no force")
    ax.plot(*thinned(t, force), color=colours.run, lw=0.8)
    limits = span(t)
    low = min(0.0, float(force.min()))
    high = max(1.0, float(force.max()))
    extremes = attrs.get("report", {}).get("normal_force") or {}
    for key, color in (("min", colours.lower), ("max", colours.upper)) if extremes else ():
        value = extremes[key] / mg
        when = extremes[f"t_{key}"]
        if limits[0] <= when <= limits[1] and np.ptp(force) > CONSTANT and value > CONSTANT:
            words = f"{key} {number(value, 4)} at t = {number(when, 5)} s"
            ax.scatter([when], [value], s=22, color=color, zorder=3, label=words)
    ax.set(
        xlabel="time t (s)", ylabel="normal force $g_n\\,/\\,mg$", title=title(attrs), xlim=limits
    )
    ax.set_ylim(low - 0.12 * (high - low), high + 0.15 * (high - low))
    legend(ax, "upper right", ncols=4)
    return ax


def energy(trajectory: Any, events: Any, attrs: Attributes) -> Axes:
    """Draw energy E, modified energy E~ and the energy taken by friction.

    The curve of E~ has gaps where the body is not on its sphere.
    """
    t = trajectory["time"].values
    taken = "taken by friction and impacts" if "phase" in trajectory else "taken by friction"
    curves = []
    for name, words in (
        ("modified_energy", "modified energy Ẽ"),
        ("energy", "energy E"),
        ("work", taken),
    ):
        if name in trajectory:
            touches = on_sphere(trajectory) if name == "modified_energy" else np.array(True)
            # `landscape_figures.band` has the same words
            words += "" if touches.all() else "; none on the stem, in the air"
            curves.append((words, t, np.where(touches, trajectory[name].values, np.nan)))
    ax = draw_over_time(curves, "energy", attrs, 4.8)
    ticks_in_joules(ax.yaxis)
    start = trajectory["energy"].values[0]
    if np.ptp(ax.dataLim.intervaly) <= CONSTANT * (abs(start) or 1.0):
        ax.set_ylim(min(0, 1.3 * start), max(0, 1.3 * start))
    legend(ax, "upper right", ncols=3)
    return ax

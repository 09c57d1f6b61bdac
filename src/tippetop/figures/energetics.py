"""The normal force and the energies of a run over the time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..columns import on_sphere
from .labels import number, title
from .style import dashes, ink, label_line, legend, panel
from .thinning import span, thinned


SCALES = ((1e3, "kJ"), (1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ"))
CONSTANT = 1e-9  # relative changes below this cannot be seen; `drift` shows them
SLIGHT = 0.02  # relative changes below this are drawn from the start


def in_joules(largest: float) -> tuple[float, str]:
    """The unit in which energies up to this one [J] are read best: its size [J] and its name."""
    return next(((size, name) for size, name in SCALES if abs(largest) >= 2 * size), SCALES[-1])


def weight(attrs: dict[str, Any]) -> float:
    """m g of the body of a run [N]."""
    return float(attrs["parameters"]["m"] * attrs["parameters"]["g"])


def normal_force(
    trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None
) -> Axes:
    """g_n(t) in units of the weight m g."""
    ax = panel(ax, 10, 4.4)
    colours = ink()
    t, mg = trajectory["time"].values, weight(attrs)
    force = trajectory["normal_force"].values / mg
    ax.axhline(1.0, color=colours.quiet, lw=0.8)
    ax.axhline(0.0, color=colours.alarm, lw=1.0, ls="--")
    ax.plot(*thinned(t, force), color=colours.run, lw=0.8)
    for words, height, color in (("no force", 0.0, colours.alarm), ("weight", 1.0, colours.quiet)):
        label_line(ax, words, height, color, -3)
    limits = span(t)
    low, high = min(0.0, float(force.min())), max(1.0, float(force.max()))
    extremes = attrs.get("report", {}).get("normal_force") or {}
    if extremes and np.ptp(force) < CONSTANT:
        ax.annotate(
            "constant",
            (limits[0], force[0]),
            xytext=(8, 6),
            textcoords="offset points",
            color=colours.run,
        )
        extremes = {}
    for key, color, side in (
        (("min", colours.lower, -14), ("max", colours.upper, 6)) if extremes else ()
    ):
        value, when = extremes[key] / mg, extremes[f"t_{key}"]
        if not limits[0] <= when <= limits[1] or ("phase" in trajectory and value < 1e-9):
            continue  # not in this window; or the body flies, and there is no force
        ax.scatter([when], [value], s=22, color=color, zorder=3)
        late = when > 0.7 * limits[1] + 0.3 * limits[0]
        ax.annotate(
            f"{key} {number(value, 4)} at t = {number(when, 5)} s",
            (when, value),
            color=color,
            xytext=(-8 if late else 8, side),
            textcoords="offset points",
            ha="right" if late else "left",
        )
    ax.set(
        xlabel="time t (s)", ylabel="normal force $g_n\\,/\\,mg$", title=title(attrs), xlim=limits
    )
    ax.set_ylim(low - 0.12 * (high - low), high + 0.15 * (high - low))
    return ax


def energy(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """Energy E, modified energy E~ and what friction has taken; changes since the start, where they
    are slight.
    """
    colours = ink()
    ax = panel(ax, 10, 4.8)
    t = trajectory["time"].values
    taken = "taken by friction and impacts" if "phase" in trajectory else "taken by friction"
    names = (
        ("modified_energy", "modified energy Ẽ", colours.upper, 1.4),
        ("energy", "energy E", colours.run, 0.9),
        ("work", taken, colours.lower, 0.9),
    )
    curves = {name: trajectory[name].values for name, *_ in names if name in trajectory}
    touches = on_sphere(trajectory)
    lost = "" if touches.all() else "; none on the stem, in the air"
    if "modified_energy" in curves:
        modified = np.where(touches, curves.pop("modified_energy"), np.nan)
        curves |= {"modified_energy": modified} if touches.any() else {}
    level = max(float(np.nanmax(np.abs(values))) for values in curves.values()) or 1.0
    changes = {
        name: float(np.nanmax(values) - np.nanmin(values)) for name, values in curves.items()
    }
    if all(change <= CONSTANT * level for change in changes.values()):
        curves.pop("work", None)  # nothing is taken
    origin = float(curves["energy"][0])
    slight = CONSTANT * level < max(changes.values()) < SLIGHT * level
    size, unit = in_joules(max(changes.values()) if slight else level)
    for i, (name, words, color, width) in enumerate(names):
        if name in curves:
            shift = origin if slight and name != "work" else 0.0
            constant = ", constant" if changes[name] <= CONSTANT * level else ""
            label = f"{words}{' − E(0)' if shift else ''}{constant}"
            label += lost if name == "modified_energy" else ""
            ax.plot(
                *thinned(t, (curves[name] - shift) / size),
                color=color,
                ls=dashes(i),
                lw=width,
                label=label,
            )
    at = in_joules(level)
    note = (
        f"change of energy ({unit}), E(0) = {number(origin / at[0], 5)} {at[1]}"
        if slight
        else f"energy ({unit})"
    )
    ax.set(xlabel="time t (s)", ylabel=note, title=title(attrs), xlim=span(t))
    if all(changes[name] <= CONSTANT * level for name in curves):
        ends = [float(values[0]) / size for values in curves.values()]
        ax.set_ylim(min(0, 1.3 * min(ends)), max(0, 1.3 * max(ends)))
    legend(ax, "upper right", ncols=3)
    return ax

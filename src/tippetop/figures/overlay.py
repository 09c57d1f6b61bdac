"""One curve of each of several runs in one panel."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .conserved import changes
from .energetics import in_joules, weight
from .labels import differences, shared, title
from .style import compact, dashes, ink, legend, panel, ticks_of_pi
from .thinning import span, thinned, worst


Curve = tuple[np.ndarray, np.ndarray]
SHOWN = {
    "theta": "inclination θ (rad)",
    "normal-force": "normal force $g_n\\,/\\,mg$",
    "energy": "energy E",
    "drift": "worst relative change since t = 0",
    "growth": "worst relative change up to t",
}
"""What several runs are compared by, and the axis of each."""
COLOURS = ("#1f77b4", "#d95f02", "#1b9e77", "#b3258f", "#8c6d1f", "#666666", "#e7298a", "#5254a3")


def overlay(
    kind: str, runs: list[tuple[Any, dict[str, Any]]], names: list[str], ax: Axes | None = None
) -> Axes:
    """The same curve of several runs, named by what is different in them.

    Parameters
    ----------
    kind
        A name of `SHOWN`.
    runs
        Trajectory and attributes of each.
    names
        What they are called where nothing else differs.
    """
    ax = panel(ax, 10, 5.4)
    attrs = [each for _, each in runs]
    labels = differences(attrs, names)
    size, unit = 1.0, ""
    if kind == "energy":
        size, unit = in_joules(max(float(np.nanmax(np.abs(t["energy"].values))) for t, _ in runs))
        unit = f" ({unit})"
    for i, ((trajectory, each), label) in enumerate(zip(runs, labels, strict=True)):
        t, values = _curve(kind, trajectory, each)
        color = COLOURS[i % len(COLOURS)]
        width = 1.6 - 0.8 * i / len(
            runs
        )  # what is drawn first can be seen below what is drawn last
        ax.plot(t, values / size, color=color, ls=dashes(i), lw=width, label=label)
    times = np.array([trajectory["time"].values[[0, -1]] for trajectory, _ in runs])
    words = SHOWN[kind].partition(" since")[0] if compact() else SHOWN[kind]
    ax.set(xlabel="time t (s)", ylabel=words + unit, title=title(shared(attrs)))
    ax.set_xlim(*span(np.array([times.min(), times.max()])))
    if kind in ("drift", "growth"):
        ax.set_yscale("log")
        ax.axhline(2.2e-16, color=ink().quiet, lw=0.8, ls=":", label="rounding unit")
    if kind == "growth":
        ax.set_xscale("log")
        ax.set_xlim(max(times.min(), 1e-3 * times.max()), times.max())
    angles = np.concatenate([trajectory["theta"].values[[0, -1]] for trajectory, _ in runs])
    if (
        kind == "theta"
        and angles.min() >= 0
        and np.pi / 2 < np.nanmax([t["theta"].values.max() for t, _ in runs]) < 3.2
    ):
        ticks_of_pi(ax)
    longest = max(map(len, labels))
    legend(ax, "lower center", ncols=1 if longest > 60 else 2 if longest > 24 else 4)
    return ax


def _curve(kind: str, trajectory: Any, attrs: dict[str, Any]) -> Curve:
    """Times and values of a run."""
    t = trajectory["time"].values
    if kind == "normal-force":
        return thinned(t, trajectory["normal_force"].values / weight(attrs))
    if kind in ("theta", "energy"):
        return thinned(t, trajectory[kind].values)
    most = np.max([values for _, values, _ in changes(trajectory, attrs)], axis=0)
    when, values = (t, np.maximum.accumulate(most)) if kind == "growth" else worst(t, most)
    return when, np.where(values > 0, values, np.nan)

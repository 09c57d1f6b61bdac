"""The same curve of several runs in one panel."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .conservation import changes
from .energetics import weight
from .labels import differences, shared, title
from .style import compact, dashes, ink, legend, panel, ticks_in_joules, ticks_of_pi
from .theta import WIDE
from .thinning import span, thinned, worst


Curve = tuple[np.ndarray, np.ndarray]
SHOWN = {
    "theta": "inclination θ (rad)",
    "normal-force": "normal force $g_n\\,/\\,mg$",
    "energy": "energy E",
    "drift": "worst relative change since t = 0",
    "growth": "worst relative change up to t",
}
"""Figures of several runs, and the label of their axis."""
COLOURS = ("#1f77b4", "#d95f02", "#1b9e77", "#b3258f", "#8c6d1f", "#666666", "#e7298a", "#5254a3")


def overlay(
    kind: str, runs: list[tuple[Any, dict[str, Any]]], names: list[str], ax: Axes | None = None
) -> Axes:
    """Draw the same curve of several runs, labelled by their differences.

    Parameters
    ----------
    kind
        A name of `SHOWN`.
    runs
        Trajectory and attributes of each.
    names
        Labels of runs without a difference.
    """
    ax = panel(ax, 10, 5.4)
    attrs = [each for _, each in runs]
    labels = differences(attrs, names)
    for i, ((trajectory, each), label) in enumerate(zip(runs, labels, strict=True)):
        t, values = _curve(kind, trajectory, each)
        width = 1.6 - 0.8 * i / len(runs)  # the first curves can be seen below the last
        ax.plot(t, values, color=COLOURS[i % len(COLOURS)], ls=dashes(i), lw=width, label=label)
    times = np.array([trajectory["time"].values[[0, -1]] for trajectory, _ in runs])
    words = SHOWN[kind].partition(" since")[0] if compact() else SHOWN[kind]
    ax.set(xlabel="time t (s)", ylabel=words, title=title(shared(attrs)))
    ax.set_xlim(*span(np.array([times.min(), times.max()])))
    if kind in ("drift", "growth"):
        ax.set_yscale("log")
        ax.axhline(2.2e-16, color=ink().quiet, lw=0.8, ls=":", label="rounding unit")
    if kind == "growth":
        ax.set_xscale("log")
        ax.set_xlim(max(times.min(), 1e-3 * times.max()), times.max())
    low, high = ax.get_ylim()
    if kind == "theta" and low > -0.2 and WIDE < high < np.pi + 0.2:
        ticks_of_pi(ax)
    if kind == "energy":
        ticks_in_joules(ax.yaxis)
    legend(ax, "lower center", ncols=4)
    return ax


def _curve(kind: str, trajectory: Any, attrs: dict[str, Any]) -> Curve:
    """Return times and values of a run."""
    t = trajectory["time"].values
    if kind == "normal-force":
        return thinned(t, trajectory["normal_force"].values / weight(attrs))
    if kind in ("theta", "energy"):
        return thinned(t, trajectory[kind].values)
    most = np.max([values for _, values in changes(trajectory, attrs)], axis=0)
    when, values = (t, np.maximum.accumulate(most)) if kind == "growth" else worst(t, most)
    return when, np.where(values > 0, values, np.nan)

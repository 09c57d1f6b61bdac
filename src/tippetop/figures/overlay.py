"""The same curve of several runs in one panel."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .conservation import changes, draw_drift, draw_growth
from .energetics import weight
from .labels import differences, shared, title
from .style import draw_curves, legend, panel, ticks_in_joules, ticks_of_inclination
from .thinning import span


LABELS = {
    "theta": "inclination θ (rad)",
    "normal-force": "normal force $g_n\\,/\\,mg$",
    "energy": "energy E",
}
"""Quantities of several runs, and the label of their axis."""
CHANGES = {"drift": draw_drift, "growth": draw_growth}
"""Figures of the worst change of each run."""


def overlay(kind: str, runs: list[tuple[Any, dict[str, Any]]], names: list[str]) -> Axes:
    """Draw the same curve of several runs, labelled by their differences.

    Parameters
    ----------
    kind
        A name of `LABELS` or `CHANGES`.
    runs
        Trajectory and attributes of each.
    names
        Labels of runs without a difference.
    """
    attrs = [each for _, each in runs]
    curves = [
        (label, trajectory["time"].values, _values(kind, trajectory, each))
        for label, (trajectory, each) in zip(differences(attrs, names), runs, strict=True)
    ]
    if kind in CHANGES:
        return CHANGES[kind](curves, shared(attrs))
    ax = panel(10, 5.4)
    draw_curves(ax, curves)
    times = span(np.concatenate([t for _, t, _ in curves]))
    ax.set(xlabel="time t (s)", ylabel=LABELS[kind], title=title(shared(attrs)), xlim=times)
    if kind == "theta":
        ticks_of_inclination(ax)
    if kind == "energy":
        ticks_in_joules(ax.yaxis)
    legend(ax, "lower center", ncols=4)
    return ax


def _values(kind: str, trajectory: Any, attrs: dict[str, Any]) -> np.ndarray:
    """Return the values of a run."""
    if kind in CHANGES:
        return np.max([values for *_, values in changes(trajectory, attrs)], axis=0)
    if kind == "normal-force":
        return trajectory["normal_force"].values / weight(attrs)
    return np.asarray(trajectory[kind].values)

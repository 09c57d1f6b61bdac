"""The same curve of several runs in one panel.

`runs` are pairs of a trajectory (a Dataset) and the root attributes of a store.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .conservation import changes, drift, growth
from .energetics import draw_over_time, weight
from .labels import Attributes, differences, shared
from .style import legend, ticks_in_joules, ticks_of_inclination


LABELS = {
    "theta": "inclination θ (rad)",
    "normal-force": "normal force $g_n\\,/\\,mg$",
    "energy": "energy E",
}
"""Quantities of several runs, and the label of their axis."""
CHANGES = {"drift": drift, "growth": growth}
"""Figures of the worst change of each run."""


def overlay(kind: str, runs: list[tuple[Any, Attributes]], names: list[str]) -> Axes:
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
    ax = draw_over_time(curves, LABELS[kind], shared(attrs), 5.4)
    if kind == "theta":
        ticks_of_inclination(ax)
    if kind == "energy":
        ticks_in_joules(ax.yaxis)
    legend(ax, "lower center", ncols=4)
    return ax


def _values(kind: str, trajectory: Any, attrs: Attributes) -> np.ndarray:
    """Return the values (n,) of the curve `kind` of a run; of its changes, the largest in a row."""
    if kind in CHANGES:
        return np.max([values for *_, values in changes(trajectory, attrs)], axis=0)
    if kind == "normal-force":
        return trajectory["normal_force"].values / weight(attrs)
    return np.asarray(trajectory[kind].values)

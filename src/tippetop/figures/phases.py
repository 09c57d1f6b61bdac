"""The phases of a contact behind the curves of a run, as shades, and its impacts, as ticks on the
axis of time.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..columns import flag_names
from .style import ink, is_ours, legend


ORDER = ("slip", "roll", "rest", "flight", "both")
ON_ONE = ("slip", "roll", "rest")  # ball
MOST_SHADES = 100  # with more phases, cells of equal width have the mean of their shades
CELLS = 500  # each wider than a pixel


def mark(panels: list[Axes], phases: Any, impacts: Any) -> None:
    """Shades the phases in panels over time, and marks the impacts; a legend below our own figures
    names both.

    Parameters
    ----------
    panels
        Panels that have the time as their x axis.
    phases, impacts
        The groups of the run's store, Datasets or columns by name.
    """
    begun, ended = phases["start"].values, phases["end"].values
    if not len(begun):
        return
    colours = ink()
    kinds, lengths = _kinds(phases), ended - begun
    edges, colors = cells(
        begun, ended, [colours.shades[phase][on_stem] for phase, on_stem in kinds]
    )
    balls = np.array(flag_names(impacts["ball"]))
    ticks = [
        (ball, color, impacts["time"].values[balls == ball])
        for ball, color in (("body", colours.alarm), ("stem", colours.stem))
    ]
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()
        axes.grid(visible=False, axis="x")
        over: Any = {"transform": axes.get_xaxis_transform()}
        axes.pcolormesh(edges, [0, 1], colors[None], zorder=0, label="_phases", lw=0, **over)
        for ball, color, when in ticks:
            label, when = f"_impacts of the {ball}", _distinct(when, limits[0])
            axes.vlines(when, 0, 0.035, color=color, lw=0.7, label=label, zorder=2.5, **over)
        axes.set(xlim=limits[0], ylim=limits[1])
    total = max(float(lengths.sum()), 1e-300)
    handles: list[Any] = []
    for phase, on_stem in sorted(set(kinds), key=lambda kind: (kind[1], ORDER.index(kind[0]))):
        share = float(lengths[[kind == (phase, on_stem) for kind in kinds]].sum()) / total
        percent = f"{100 * share:.1f} %" if share >= 0.001 else "< 0.1 %"
        words = f"{phase} on the stem" if on_stem else phase
        handles.append(Patch(color=colours.shades[phase][on_stem], label=f"{words}: {percent}"))
    for ball, color, when in ticks:
        if count := len(when):
            words = f"{count} impact" + "s" * (count > 1) + " of the stem" * (ball == "stem")
            handles.append(
                Line2D([], [], color=color, marker="|", ms=9, mew=1.4, ls="none", label=words)
            )
    if is_ours():
        legend(panels[0], "lower center", handles=handles, ncols=len(handles))


def cells(begun: np.ndarray, ended: np.ndarray, shades: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Time in cells: their edges (n + 1,), and their colours (n, 3), means over the phases within.

    Each cell is a phase, unless there are too many.
    """
    edges = np.unique([*begun, ended[-1]])
    if len(edges) > MOST_SHADES:
        edges = np.linspace(begun[0], ended[-1], CELLS + 1)
    elif len(edges) < 2:
        edges = edges[0] + np.array([0.0, 1e-9])
    colors = np.zeros((len(edges) - 1, 3))
    weights = np.zeros(len(edges) - 1)
    names = np.array(shades)
    for shade in sorted(set(shades)):
        lengths = np.where(names == shade, ended - begun, 0.0)
        until = np.interp(
            edges, np.append(begun, ended[-1]), np.concatenate([[0.0], np.cumsum(lengths)])
        )
        colors += np.diff(until)[:, None] * np.array(to_rgb(shade))
        weights += np.diff(until)
    empty = weights <= 0
    colors[empty], weights[empty] = to_rgb(shades[-1]), 1.0
    return edges, np.clip(colors / weights[:, None], 0, 1)


def _kinds(phases: Any) -> list[tuple[str, bool]]:
    """Each phase, and whether it is on the stem; in flight and on both, the ball means nothing."""
    rows = zip(flag_names(phases["phase"]), flag_names(phases["ball"]), strict=True)
    return [(phase, ball == "stem" and phase in ON_ONE) for phase, ball in rows]


def _distinct(when: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Of the times that fall on one pixel, the first."""
    pixels = np.floor((when - limits[0]) / (limits[1] - limits[0]) * 3 * CELLS)
    return when[np.unique(pixels, return_index=True)[1]]

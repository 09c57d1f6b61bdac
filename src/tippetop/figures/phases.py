"""The phases of a contact behind the curves of a run, as shades, and its impacts, as ticks on the axis of time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..columns import flag_names
from .style import ink, legend


ORDER = ("slip", "roll", "rest", "flight", "both")
ON_ONE = ("slip", "roll", "rest")  # ball
BALLS = ("body", "stem")
MOST_SHADES = 100  # with more phases, cells of equal width have the mean of their shades
CELLS = 500  # each wider than a pixel


def mark(panels: list[Axes], phases: Any, impacts: Any, *, own: bool = True) -> None:
    """Shades the phases in panels over time, and marks the impacts; a legend below names both.

    Parameters
    ----------
    panels
        Panels that have the time as their x axis.
    phases, impacts
        The groups of the run's store, Datasets or columns by name.
    own
        Whether the figure is ours: then the legend stands below it.
    """
    begun, ended = phases["start"].values, phases["end"].values
    if not len(begun):
        return
    colours = ink()
    ticks_of = dict(zip(BALLS, (colours.alarm, colours.stem), strict=True))
    kinds, lengths = _kinds(phases), ended - begun
    edges, colors = cells(begun, ended, [colours.shades[phase][ball == "stem"] for phase, ball in kinds])
    names = np.array(flag_names(impacts["ball"]))
    ticks = {ball: impacts["time"].values[names == ball] for ball in BALLS}
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()
        axes.grid(visible=False, axis="x")
        axes.pcolormesh(
            edges, [0, 1], colors[None], transform=axes.get_xaxis_transform(), zorder=0, label="_phases", lw=0
        )
        for ball, when in ticks.items():
            axes.vlines(
                _distinct(when, limits[0]), 0, 0.035, transform=axes.get_xaxis_transform(), color=ticks_of[ball],
                lw=0.7, label=f"_impacts of the {ball}", zorder=2.5,
            )  # fmt: skip
        axes.set(xlim=limits[0], ylim=limits[1])
    total = max(float(lengths.sum()), 1e-300)
    handles: list[Any] = []
    for kind in sorted(set(kinds), key=lambda kind: (kind[1] == "stem", ORDER.index(kind[0]))):
        share = float(lengths[[k == kind for k in kinds]].sum()) / total
        words = kind[0] + (" on the stem" if kind[1] == "stem" else "")
        handles.append(Patch(color=colours.shades[kind[0]][kind[1] == "stem"], label=f"{words}: {_percent(share)}"))
    for ball, when in ticks.items():
        if len(when):
            words = ("impact" if len(when) == 1 else "impacts") + (" of the stem" if ball == "stem" else "")
            handles.append(
                Line2D([], [], color=ticks_of[ball], marker="|", ms=9, mew=1.4, ls="none", label=f"{len(when)} {words}")
            )
    if own:
        legend(panels[0], "lower center", own=True, handles=handles, ncols=len(handles))


def cells(begun: np.ndarray, ended: np.ndarray, shades: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Time in cells: their edges (n + 1,), and their colours (n, 3), means over the phases within. Each cell is a
    phase, unless there are too many."""
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
        until = np.interp(edges, np.append(begun, ended[-1]), np.concatenate([[0.0], np.cumsum(lengths)]))
        colors += np.diff(until)[:, None] * np.array(to_rgb(shade))
        weights += np.diff(until)
    empty = weights <= 0
    colors[empty], weights[empty] = to_rgb(shades[-1]), 1.0
    return edges, np.clip(colors / weights[:, None], 0, 1)


def _kinds(phases: Any) -> list[tuple[str, str]]:
    """Phase and ball of each row; in flight and on both, the ball means nothing."""
    rows = zip(flag_names(phases["phase"]), flag_names(phases["ball"]), strict=True)
    return [(phase, ball if phase in ON_ONE else "body") for phase, ball in rows]


def _distinct(when: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Of the times that fall on one pixel, the first."""
    pixels = np.floor((when - limits[0]) / (limits[1] - limits[0]) * 3 * CELLS)
    return when[np.unique(pixels, return_index=True)[1]]


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= 0.001 else "< 0.1 %"

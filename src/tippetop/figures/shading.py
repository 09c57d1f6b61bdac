"""The phases of a contact as shades behind the curves of a run, and impacts as ticks."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..columns import flag_names, flagged
from .style import ink, is_ours, legend


ORDER = ("slip", "roll", "rest", "flight", "both")
ON_ONE = ("slip", "roll", "rest")  # phases with one ball in contact


def mark(panels: list[Axes], phases: Any, impacts: Any) -> None:
    """Shade the phases and mark the impacts in panels over time, with a legend in our figures.

    Parameters
    ----------
    panels
        Panels whose x axis is the time.
    phases, impacts
        The groups of the run's store, Datasets or columns by name.
    """
    begun, ended = phases["start"].values, phases["end"].values
    if not len(begun):
        return
    colours, lengths = ink(), ended - begun
    kinds = [
        (phase, ball == "stem" and phase in ON_ONE)
        for phase, ball in zip(flag_names(phases["phase"]), flag_names(phases["ball"]), strict=True)
    ]
    shades = np.array([to_rgb(colours.shades[phase][on_stem]) for phase, on_stem in kinds])
    ticks = [
        (ball, color, impacts["time"].values[flagged(impacts["ball"], ball)])
        for ball, color in (("body", colours.alarm), ("stem", colours.stem))
    ]
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()
        axes.grid(visible=False, axis="x")
        over: Any = {"transform": axes.get_xaxis_transform(), "rasterized": True}
        edges = np.append(begun, ended[-1])
        axes.pcolormesh(edges, [0, 1], shades[None], zorder=0, antialiased=True, **over)
        for ball, color, when in ticks:
            label = f"_impacts of the {ball}"
            axes.vlines(when, 0, 0.035, color=color, lw=0.7, label=label, zorder=2.5, **over)
        axes.set(xlim=limits[0], ylim=limits[1])
    handles: list[Any] = []
    for phase, on_stem in sorted(set(kinds), key=lambda kind: (kind[1], ORDER.index(kind[0]))):
        share = lengths[[kind == (phase, on_stem) for kind in kinds]].sum() / lengths.sum()
        words = f"{phase}{' on the stem' if on_stem else ''}: {share:.1%}".replace("%", " %")
        handles.append(Patch(color=colours.shades[phase][on_stem], label=words))
    for ball, color, when in ticks:
        if count := len(when):
            words = f"{count} impact{'s' * (count > 1)}{' of the stem' * (ball == 'stem')}"
            style: Any = {"marker": "|", "ms": 9, "mew": 1.4, "ls": "none"}
            handles.append(Line2D([], [], color=color, label=words, **style))
    if is_ours():
        legend(panels[0], "lower center", handles=handles, ncols=len(handles))

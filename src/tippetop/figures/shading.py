"""The phases of a contact as shades behind the curves of a run, and impacts as ticks.

`phases` and `impacts` are Datasets of a run; `drawing` calls `mark` after a figure over time.
"""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..columns import flag_words, flagged
from .style import ink, legend, users_panel


ON_ONE = ("slip", "roll", "rest")  # phases with one ball in contact


def handed_over(phases: Any) -> np.ndarray:
    """Return the times at which another ball touches the plane than before [s]."""
    if phases is None or "ball" not in phases:
        return np.empty(0)
    return np.asarray(phases["start"].values[1:][np.diff(phases["ball"].values) != 0])


def mark(panels: list[Axes], phases: Any, impacts: Any) -> None:
    """Shade the phases and mark the impacts in panels over time, with a legend in our figures.

    Parameters
    ----------
    panels
        Panels whose x axis is the time.
    phases, impacts
        The groups of the run's store, as Datasets; without impacts None. Each phase must begin
        where the one before ends.
    """
    begun = phases["start"].values
    ended = phases["end"].values
    if not len(begun):
        return
    colours = ink()
    lengths = ended - begun
    known = phases["phase"].attrs["flag_meanings"].split()
    spare = [pair for name, pair in colours.shades.items() if name not in known]
    others = itertools.cycle(spare or colours.shades.values())
    pairs = {name: colours.shades.get(name) or next(others) for name in known}
    names = flag_words(phases["phase"])
    on_stem = np.isin(names, ON_ONE) & ("ball" in phases and flagged(phases["ball"], "stem"))
    shades = [to_rgb(pairs[name][int(stem)]) for name, stem in zip(names, on_stem, strict=True)]
    ticks = [
        (words, color, impacts["time"].values[flagged(impacts["ball"], ball)])
        for ball, color, words in (
            ("body", colours.alarm, ""),
            ("stem", colours.stem, " of the stem"),
        )
        if impacts is not None
    ]
    for axes in panels:
        limits = axes.get_xlim(), axes.get_ylim()  # which shades and ticks would change
        axes.grid(visible=False, axis="x")
        over: Any = {"transform": axes.get_xaxis_transform(), "rasterized": True}
        edges = np.append(begun, ended[-1])
        axes.pcolormesh(edges, [0, 1], [shades], zorder=0, antialiased=True, **over)
        for words, color, when in ticks:
            label = f"_impacts{words}"
            axes.vlines(when, 0, 0.035, color=color, lw=0.7, label=label, zorder=2.5, **over)
        axes.set(xlim=limits[0], ylim=limits[1])
    handles: list[Any] = []
    for stem, words in enumerate(("", " on the stem")):
        for name, pair in pairs.items():
            chosen = (names == name) & (on_stem == stem)
            if chosen.any():
                share = f"{lengths[chosen].sum() / lengths.sum():.1%}".replace("%", " %")
                handles.append(Patch(color=pair[stem], label=f"{name}{words}: {share}"))
    for words, color, when in ticks:
        if count := len(when):
            label = f"{count} impact{'s' * (count > 1)}{words}"
            style: Any = {"marker": "|", "ms": 9, "mew": 1.4, "ls": "none"}
            handles.append(Line2D([], [], color=color, label=label, **style))
    if users_panel() is None:
        legend(panels[0], "lower center", handles=handles, ncols=len(handles))

"""Another program's motion beside the reference: theta of both, differences, and what must be
conserved.
"""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .style import LOWER, QUIET, RUN, UPPER, figure, legend, literal, styled


COLORS = (UPPER, LOWER, "#6d28d9", "#0369a1", "#a16207", "#be185d")
LEVELS = (1e-3, 1e-2, 1e-1)
FLOOR = 1e-17  # below it a difference is not drawn
SHOWN = {
    "theta": ("θ", "rad"),
    "place": ("place", "m"),
    "omega3": ("ω₃", "rad s⁻¹"),
}  # others: by name, in rad


@styled()
def comparison(motions: Sequence[Any], title: str) -> Figure:
    """Three panels over time: theta (rad), differences (rad) with their levels, relative drift.

    Parameters
    ----------
    motions
        Each with `path`, `t`, `theta`, `reference` and `curves`, as `exchange.comparison.Compared`.
    title
        What the reference is.
    """
    drifts = any(name in m.curves for m in motions for name in ("energy", "jellett"))
    fig = figure(9.0, 8.5 if drifts else 6.5)
    panels: Any = fig.subplots(3 if drifts else 2, 1, sharex=True)
    longest = max(motions, key=lambda m: m.t[-1])
    panels[0].plot(longest.t, longest.reference, color=RUN, lw=2.2, alpha=0.55, label="reference")
    for m, color in zip(motions, itertools.cycle(COLORS)):
        if np.isfinite(m.theta).any():
            panels[0].plot(m.t, m.theta, color=color, lw=0.9, label=literal(m.path.stem))
        name = next(n for n in ("attitude", "axis", "theta", "place", "omega3") if n in m.curves)
        _draw(panels[1], m.t, m.curves[name], color=color)
        if name != "theta" and "theta" in m.curves:
            _draw(panels[1], m.t, m.curves["theta"], color=color, lw=0.6, ls=":")
        for kept, style in (("jellett", "-"), ("energy", "--")):
            if kept in m.curves:
                _draw(panels[2], m.t, m.curves[kept], color=color, ls=style)
    if name != "omega3":
        panels[1].hlines(
            LEVELS,
            0,
            1,
            transform=panels[1].get_yaxis_transform(),
            color=QUIET,
            lw=0.7,
            ls="--",
            label="_levels",
        )
    panels[0].set(ylabel="inclination θ (rad)", title=literal(title[:1].upper() + title[1:]))
    dotted = "" if name == "theta" else ", dotted θ alone"
    words, unit = SHOWN.get(name, (name, "rad"))
    panels[1].set(ylabel=f"difference ({unit})", title=f"How far it is off: solid {words}{dotted}")
    if drifts:
        words = "Its change less the exact one: solid Jellett's integral λ, dashed energy E"
        panels[2].set(ylabel="relative change", title=words)
    panels[-1].set_xlabel("time t (s)")
    for axes in panels[1:]:
        _cut(axes)
    legend(panels[0], "upper right", ncols=4)
    return fig


def _draw(axes: Any, t: np.ndarray, values: np.ndarray, **style: Any) -> None:
    """How large differences are; open where they are 0."""
    sizes = np.abs(values)
    axes.semilogy(t, np.where(sizes > FLOOR, sizes, np.nan), **style)


def _cut(axes: Any) -> None:
    """Leaves out what is below nearly all of the curves: the first row of each is often exact."""
    values = np.concatenate(
        [line.get_ydata()[1:] for line in axes.lines if len(line.get_xdata()) > 2]
    )
    values = values[np.isfinite(values)]
    if len(values):
        axes.set_ylim(bottom=max(FLOOR, 0.1 * float(np.quantile(values, 0.01))))

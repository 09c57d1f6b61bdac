"""The relative changes of conserved quantities over time, and the growth of the largest ones.

A trajectory goes in; curves of |change|, and panels come out.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .labels import Attributes, title
from .style import Curve, compact, draw_curves, ink, legend, panel
from .thinning import span, worst


INTEGRALS = {
    "jellett": "Jellett's integral λ",
    "routh": "Routh's function D",
    "L3": "angular momentum $L_3$",
    "Lz": "angular momentum $L_z$",
}
UNIT = 2.2e-16  # rounding unit


def drift(curves: list[Curve], attrs: Attributes) -> Axes:
    """Draw the worst of relative changes per bin; curves are open where they are 0.

    The curves are those of `changes`, or one for each of several runs.
    """
    ax = panel(10, 5.0)
    since = "" if compact() else " since the start, worst per bin"
    times = np.concatenate([t for _, t, _ in curves])
    ax.set(ylabel=f"relative change{since}", xlim=span(times))
    binned = [(words, *worst(t, values)) for words, t, values in curves]
    return _draw(ax, binned, attrs, marker=".")


def growth(curves: list[Curve], attrs: Attributes) -> Axes:
    """Draw the largest of relative changes so far, and sqrt(t) as of a random walk.

    The curves are those of `drift`; t = 0 is left out, because the time axis is logarithmic.
    """
    ax = panel(10, 5.0)
    grown = [(words, t[t > 0], np.maximum.accumulate(values)[t > 0]) for words, t, values in curves]
    t = np.unique(np.concatenate([t for _, t, _ in grown]))
    most = np.concatenate([values for *_, values in grown]).max(initial=0)
    if most > 0:
        ax.plot(t, most * np.sqrt(t / t[-1]), color=ink().quiet, ls="--", label="∝ √t")
    ax.set(ylabel="worst relative change up to t", xscale="log")
    if len(t) > 1:
        ax.set_xlim(t[0], t[-1])
    return _draw(ax, grown, attrs)


def _draw(ax: Axes, curves: list[Curve], attrs: Attributes, **style: Any) -> Axes:
    """Draw curves on a logarithmic axis with the rounding unit, title and legend; return `ax`.

    `attrs` are the root attributes of the run, `style` options of matplotlib's `plot`.
    """
    ax.axhline(UNIT, color=ink().quiet, lw=0.8, ls=":", label="rounding unit")
    shown = [
        (words if values.any() else f"{words}: exactly 0", t, np.where(values > 0, values, np.nan))
        for words, t, values in curves
    ]
    draw_curves(ax, shown, ms=2.5, **style)
    known = np.concatenate([[UNIT], *(values for *_, values in shown)])
    ax.set(xlabel="time t (s)", title=title(attrs), yscale="log")
    ax.set_ylim(min(0.5 * np.nanmin(known), 0.3 * UNIT), max(3 * np.nanmax(known), 20 * UNIT))
    legend(ax, "upper right", ncols=3)
    return ax


def changes(trajectory: Any, attrs: Attributes) -> list[Curve]:
    """Return curves of the relative changes since the start of the conserved quantities.

    Each curve has all rows of `trajectory`, a Dataset: `overlay` takes their largest. `attrs` are
    the root attributes of the run and two further ones: `first_row` of `window.in_window`, values
    at the start of a run of which a part is drawn, and `handed_over` of `drawing.axes_of`, times
    [s] at which another ball takes over.
    """
    t = trajectory["time"].values
    first = attrs.get("first_row", {})
    # Where another ball is in contact
    rows = np.unique(np.searchsorted(t, attrs.get("handed_over", ())))
    rows = rows[(rows > 0) & (rows < len(t))]
    curves: list[Curve] = []
    for name, words in INTEGRALS.items():
        if name not in attrs["report"]["drift"] or name not in trajectory:
            continue
        values = trajectory[name].values
        handed = rows[:0]
        if name == "jellett":  # it is that of the ball in contact
            handed = rows
            if "jellett_lost" in trajectory and (lost := trajectory["jellett_lost"].values).any():
                values = values + lost
                words = "λ + lost to torques"
            if len(handed):
                words += ", since its ball touched first"
        piece, *others = np.split(values, handed)
        # the first row of the whole run may be on another ball, with another lambda
        begun = None if "ball" in trajectory else first.get(name)
        pieces = [relative(piece, begun), *map(relative, others)]
        curves.append((words, t, np.concatenate(pieces)))
    if "energy" in trajectory:
        work = trajectory["work"].values if "work" in trajectory else 0.0
        begun = first["energy"] + first.get("work", 0.0) if first else None
        balance = relative(trajectory["energy"].values + work, begun)
        curves.append(("energy balance E + ∫ friction power", t, balance))
    if "axis" in trajectory:
        length = np.linalg.norm(trajectory["axis"].values, axis=1)
        change = relative(length, 1.0 if first else None)  # every run starts with length 1
        curves.append(("length of the axis $|\\hat{3}|$", t, change))
    return curves


def relative(values: np.ndarray, first: float | None = None) -> np.ndarray:
    """Return the sizes of the changes relative to the first value, or to `first`, (n,).

    They are absolute if that is 0.
    """
    start = values[0] if first is None else first
    return np.abs(values - start) / (abs(start) if start else 1.0)

"""The relative changes of conserved quantities over time, and the growth of the largest ones."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .labels import number, title
from .style import compact, dashes, ink, legend, panel
from .thinning import span, worst


INTEGRALS = {
    "jellett": "Jellett's integral λ",
    "routh": "Routh's function D",
    "L3": "angular momentum $L_3$",
    "Lz": "angular momentum $L_z$",
}
UNIT = 2.2e-16  # rounding unit


def drift(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """Draw the relative changes of the conserved quantities; curves are open where they are 0."""
    ax = panel(ax, 10, 5.0)
    t = trajectory["time"].values
    curves = [(words, *worst(t, values)) for words, values in changes(trajectory, attrs)]
    since = number(0.0 if attrs.get("first_row") else float(t[0]))
    words = (
        "relative change" if compact() else f"relative change since t = {since} s, worst per bin"
    )
    ax.set(ylabel=words, xlim=span(t))
    return _drawn(ax, curves, attrs, marker=".")


def growth(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """Draw the largest change so far over the time, and sqrt(t) as of a random walk."""
    ax = panel(ax, 9, 5.4)
    later = trajectory["time"].values > 0
    t = trajectory["time"].values[later]
    curves = [
        (words, t, np.maximum.accumulate(values)[later])
        for words, values in changes(trajectory, attrs)
    ]
    most = max((grown.max() for _, _, grown in curves if len(grown)), default=0)
    if most > 0:
        label = "∝ √t"
        ax.plot(t, most * np.sqrt(t / t[-1]), color=ink().quiet, lw=1.0, ls="--", label=label)
    ax.set(ylabel="worst relative change up to t", xscale="log")
    if len(t) > 1:
        ax.set_xlim(t[0], t[-1])
    return _drawn(ax, curves, attrs)


def _drawn(
    ax: Axes, curves: list[tuple[str, np.ndarray, np.ndarray]], attrs: dict[str, Any], **style: Any
) -> Axes:
    """Draw curves on a logarithmic axis with the rounding unit, title and legend."""
    ax.set_yscale("log")
    ax.axhline(UNIT, color=ink().quiet, lw=0.8, ls=":", label="rounding unit")
    known = [UNIT]
    for i, ((words, t, values), color) in enumerate(zip(curves, ink()[:5], strict=False)):
        seen = np.where(values > 0, values, np.nan)
        label = words if values.any() else f"{words}: exactly 0"
        ax.plot(t, seen, color=color, ls=dashes(i), lw=1.3, ms=2.5, label=label, **style)
        known += [np.nanmin(seen), np.nanmax(seen)] if values.any() else []
    ax.set_ylim(min(0.5 * min(known), 0.3 * UNIT), max(3 * max(known), 20 * UNIT))
    ax.set(xlabel="time t (s)", title=title(attrs))
    legend(ax, "upper right", ncols=3)
    return ax


def changes(trajectory: Any, attrs: dict[str, Any]) -> list[tuple[str, np.ndarray]]:
    """Return the relative changes since the start of the conserved quantities, with their words."""
    first, rows = attrs.get("first_row", {}), _handed_over(trajectory, attrs)
    curves: list[tuple[str, np.ndarray]] = []
    for name, words in INTEGRALS.items():
        if name not in attrs["report"]["drift"] or name not in trajectory:
            continue
        values, handed = trajectory[name].values, rows if name == "jellett" else rows[:0]
        lost = trajectory["jellett_lost"].values if "jellett_lost" in trajectory else np.zeros(1)
        if name == "jellett" and lost.any():
            values, words = values + lost, "λ + lost to torques"
        words += ", since its ball touched first" if len(handed) else ""
        piece, *others = np.split(values, handed)
        begun = None if "ball" in trajectory else first.get(name)
        curves.append((words, np.concatenate([relative(piece, begun), *map(relative, others)])))
    if "energy" in trajectory:
        work = trajectory["work"].values if "work" in trajectory else 0.0
        begun = first["energy"] + first.get("work", 0.0) if first else None
        balance = relative(trajectory["energy"].values + work, begun)
        curves.append(("energy balance E + ∫ friction power", balance))
    if "axis" in trajectory:
        length = np.linalg.norm(trajectory["axis"].values, axis=1)
        curves.append(("length of the axis $|\\hat{3}|$", relative(length, 1.0 if first else None)))
    return curves


def _handed_over(trajectory: Any, attrs: dict[str, Any]) -> np.ndarray:
    """Return the rows from which another ball is in contact."""
    t = trajectory["time"].values
    rows = np.unique(np.searchsorted(t, attrs.get("handed_over", ())))
    return rows[(rows > 0) & (rows < len(t))]


def relative(values: np.ndarray, first: float | None = None) -> np.ndarray:
    """Return the changes relative to the first value, or to `first`."""
    start = values[0] if first is None else first
    return np.abs(values - start) / (abs(start) if start else 1.0)

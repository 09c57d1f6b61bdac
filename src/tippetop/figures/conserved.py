"""How well a run kept what must not change: the relative changes over the time, and how the worst
of them grows.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .labels import number, title
from .style import compact, dashes, ink, label_line, legend, panel
from .thinning import span, worst


INTEGRALS = {
    "jellett": "Jellett's integral λ",
    "routh": "Routh's function D",
    "L3": "angular momentum $L_3$",
    "Lz": "angular momentum $L_z$",
}
UNIT = 2.2e-16  # of rounding


def drift(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """How well the run kept what must not change: the picture of trust.

    Where a change is exactly 0 the curve is open, and the legend says so.
    """
    ax = panel(ax, 10, 5.0)
    t = trajectory["time"].values
    for i, (words, values, color) in enumerate(changes(trajectory, attrs)):
        when, most = worst(t, values)
        _curve(ax, when, most, words, color, dashes(i), alone=".")
    _dress(ax, attrs)
    since = number(0.0 if attrs.get("first_row") else float(t[0]))
    words = (
        "relative change" if compact() else f"relative change since t = {since} s, worst per bin"
    )
    ax.set(ylabel=words, xlim=span(t))
    return ax


def growth(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """How the worst change since the start grows with the length of the run, beside a random walk's
    sqrt(t).
    """
    ax = panel(ax, 9, 5.4)
    t = trajectory["time"].values
    later = t > 0
    most = 0.0
    for i, (words, values, color) in enumerate(changes(trajectory, attrs)):
        grown = np.maximum.accumulate(values)[later]
        most = max(most, float(grown[-1]) if len(grown) else 0.0)
        _curve(ax, t[later], grown, words, color, dashes(i))
    ax.set_xscale("log")
    if most > 0:
        ax.plot(
            t[later],
            most * np.sqrt(t[later] / t[-1]),
            color=ink().quiet,
            lw=1.0,
            ls="--",
            label="∝ √t",
        )
    _dress(ax, attrs)
    at = " (at keyframes)" if attrs.get("run", {}).get("output") == "keyframes" else ""
    ax.set(ylabel=f"worst relative change up to t{at}")
    if later.sum() > 1:
        ax.set_xlim(t[later][0], t[-1])
    return ax


def _curve(
    ax: Axes, t: np.ndarray, values: np.ndarray, words: str, color: str, ls: Any, alone: str = ""
) -> None:
    """A curve on a logarithmic axis, open where it is exactly 0; if it is 0 everywhere, an entry of
    the legend only.
    """
    if not values.any():
        ax.plot([], [], color=color, ls=ls, lw=1.3, label=f"{words}: exactly 0")
        return
    zero = values == 0
    words += ", open where it is 0" if zero[1:].any() and alone else ""
    ax.semilogy(t, np.where(zero, np.nan, values), color=color, ls=ls, lw=1.3, label=words)
    lonely = ~zero & np.r_[True, zero[:-1]] & np.r_[zero[1:], True]
    if alone:
        ax.plot(t[lonely], values[lonely], alone, color=color, ms=2.5)


def _dress(ax: Axes, attrs: dict[str, Any]) -> None:
    """The unit of rounding, limits around the curves, title and legend."""
    colours = ink()
    ax.set_yscale("log")
    heights = [np.asarray(line.get_ydata(), dtype=float) for line in ax.get_lines()]
    known = [y for y in heights if np.isfinite(y).any()]
    if not known:
        ax.annotate(
            "every change is exactly 0",
            (0.5, 0.5),
            xycoords="axes fraction",
            ha="center",
            color=colours.run,
        )
    known = [y for y in known if len(y) > 2]
    ax.axhline(UNIT, color=colours.quiet, lw=0.8, ls=":")
    label_line(ax, "rounding\nunit", UNIT, colours.quiet, -8)
    least, most = UNIT, UNIT
    if known:
        least, most = min(map(np.nanmin, known)), max(map(np.nanmax, known))
    ax.set_ylim(min(0.5 * least, 0.3 * UNIT), max(3 * most, 20 * UNIT))
    ax.set(xlabel="time t (s)", title=title(attrs))
    legend(ax, "upper right", ncols=3)


def changes(trajectory: Any, attrs: dict[str, Any]) -> list[tuple[str, np.ndarray, str]]:
    """Relative changes since the start of what must not change: words, values (time,), colour."""
    first = attrs.get("first_row", {})
    curves: list[tuple[str, np.ndarray]] = []
    for name, words in INTEGRALS.items():
        if name not in attrs["report"]["drift"] or name not in trajectory:
            continue
        values = trajectory[name].values
        handed = _handed_over(trajectory, attrs) if name == "jellett" else np.empty(0, dtype=int)
        if (
            name == "jellett"
            and "jellett_lost" in trajectory
            and trajectory["jellett_lost"].values.any()
        ):
            values, words = values + trajectory["jellett_lost"].values, "λ + what torques took"
        words += ", since its ball touched first" if len(handed) else ""
        piece, *others = np.split(values, handed)
        begun = None if "ball" in trajectory else first.get(name)
        curves.append((words, np.concatenate([relative(piece, begun), *map(relative, others)])))
    if "energy" in trajectory:
        work = trajectory["work"].values if "work" in trajectory else 0.0
        begun = first["energy"] + first.get("work", 0.0) if first else None
        curves.append(
            (
                "energy balance E + ∫ friction power",
                relative(trajectory["energy"].values + work, begun),
            )
        )
    if "axis" in trajectory:
        length = np.linalg.norm(trajectory["axis"].values, axis=1)
        curves.append(("length of the axis $|\\hat{3}|$", relative(length, 1.0 if first else None)))
    return [(*curve, color) for curve, color in zip(curves, ink()[:5], strict=False)]


def _handed_over(trajectory: Any, attrs: dict[str, Any]) -> np.ndarray:
    """The rows from which on another ball is in contact than before."""
    t = trajectory["time"].values
    rows = np.unique(np.searchsorted(t, attrs.get("handed_over", ())))
    return rows[(rows > 0) & (rows < len(t))]


def relative(values: np.ndarray, first: float | None = None) -> np.ndarray:
    """Relative changes since the first of these values, or since the one that is given."""
    start = values[0] if first is None else first
    return np.abs(values - start) / (abs(start) if start else 1.0)

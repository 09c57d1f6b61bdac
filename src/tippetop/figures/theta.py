"""theta(t) of a run with its turning angles, and the nutational band between them.

`trajectory` and `events` are Datasets of a run in SI units, `attrs` the root attributes of its
store.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from ..columns import flagged, significant_turnings
from .labels import Attributes, title
from .style import ink, legend, panels_over_time, ticks_of_inclination
from .thinning import MOST_POINTS, span, thinned


TREMBLING = 0.02  # fraction of the usual swing


def theta(trajectory: Any, events: Any, attrs: Attributes) -> Axes:
    """Draw theta(t) with the logged turning angles and the nutational band; below, its width.

    A run without a band and a panel of the user's have no panel below.
    """
    t = trajectory["time"].values
    turnings = significant_turnings(events)
    times, angles, signs, swings = (
        events[name].values[turnings] for name in ("time", "theta", "theta_dot_sign", "amplitude")
    )
    steady = ~_trembling(swings)
    breaks = attrs.get("handed_over", ())
    pieces = _bands(times[steady], angles[steady], signs[steady], breaks)
    ax, *lower = panels_over_time(1.2 if pieces else 0)
    colours = ink()
    for when, low, high in pieces:
        ax.fill_between(
            when, low, high, color=colours.upper, alpha=0.22, lw=0, label="nutational band"
        )
    ax.plot(*thinned(t, trajectory["theta"].values), color=colours.run, lw=0.7, label="θ(t)")
    for sign, color, name in (
        (-1, colours.upper, "maxima: upper envelope"),
        (+1, colours.lower, "minima: lower envelope"),
    ):
        side = signs == sign
        if side.any():
            size = 5 if side.sum() < 500 else 1.5
            ax.scatter(
                *thinned(times[side], angles[side]), s=size, color=color, lw=0, zorder=3, label=name
            )
    is_inclination = "inclination" in trajectory["theta"].attrs["long_name"]
    label = "inclination θ (rad)" if is_inclination else "angle θ (rad)"
    ax.set(ylabel=label, title=title(attrs), xlim=span(t))
    ticks_of_inclination(ax)
    for when in events["time"].values[flagged(events["kind"], "liftoff")][:1]:
        label = f"first liftoff at {when:.4g} s"
        ax.axvline(when, color=colours.alarm, ls="--", label=label)
    legend(ax, "upper right", ncols=5, markerscale=2.5)
    for below in lower:
        for when, low, high in pieces:
            width = np.where(high > low, high - low, np.nan)
            below.plot(*thinned(when, width), color=colours.upper, lw=0.9, marker=".", ms=2)
        below.set(ylabel="width (rad)", yscale="log")
        below.yaxis.set_minor_formatter(NullFormatter())
    return ax


def _bands(
    times: np.ndarray, angles: np.ndarray, signs: np.ndarray, breaks: Any
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return pieces of the band (times, low, high), broken at `breaks` and where turnings pause.

    Minima have the sign +1, maxima -1. theta is monotone in a pause, as in the rise of an
    inversion. More turnings than can be seen are one piece.
    """
    many = len(times) > MOST_POINTS
    starts = np.array([], int)
    if not many:
        gaps = np.diff(times)
        pauses = np.flatnonzero(gaps > 3 * _usual(gaps)) + 1
        starts = np.union1d(pauses, np.searchsorted(times, breaks))
    pieces = []
    for rows in np.split(np.arange(len(times)), starts):
        sides = [rows[signs[rows] == sign] for sign in (+1, -1)]
        if min(map(len, sides)) >= 2:
            when = np.linspace(times[0], times[-1], 2000) if many else times[rows]
            low, high = (np.interp(when, times[side], angles[side]) for side in sides)
            pieces.append((when, low, high))
    return pieces


def _usual(values: np.ndarray) -> np.ndarray:
    """Return the median of the 21 values around each."""
    return np.array([np.median(values[max(0, i - 10) : i + 11]) for i in range(len(values))])


def _trembling(swings: np.ndarray) -> np.ndarray:
    """Select pairs of turnings whose swing is far smaller than those around it, (n,) of bool.

    `swings` (n,) are those of `EventTable.amplitude`, |theta - theta of the turning before| [rad];
    both turnings of a pair are selected, but none where there are too many to be seen.
    """
    if not 0 < len(swings) <= MOST_POINTS:
        return np.zeros(len(swings), dtype=bool)
    small = swings < TREMBLING * _usual(swings)
    small[1:] &= ~small[:-1]  # every other one in a row, so that maxima and minima alternate
    return small | np.r_[small[1:], False]

"""theta(t) of a run with its turning angles, and the nutational band between them."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from ..columns import flagged
from .labels import title
from .style import ink, legend, panels_over_time, ticks_of_pi
from .thinning import MOST_POINTS, span, thinned


Curve = tuple[np.ndarray, np.ndarray]
TREMBLING = 0.02  # fraction of the usual swing
WIDE = 1.2  # [rad] an axis over more than this has ticks at multiples of pi/4


def theta(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """Draw theta(t) with the logged turning angles and the nutational band; below, its width.

    A run without a band and a panel of the user's have no panel below.
    """
    t, angle = trajectory["time"].values, trajectory["theta"].values
    low, high = _turnings(events, +1), _turnings(events, -1)
    pieces = bands(
        _turnings(events, +1, True),
        _turnings(events, -1, True),
        np.array(attrs.get("handed_over", ())),
    )
    ax, below = panels_over_time(ax, 1.2 if pieces else 0)
    colours = ink()
    inclined = "inclination" in trajectory["theta"].attrs.get("long_name", "inclination")
    for when, bottom, top in pieces:
        ax.fill_between(
            when, bottom, top, color=colours.upper, alpha=0.22, lw=0, label="nutational band"
        )
    ax.plot(*thinned(t, angle), color=colours.run, lw=0.7, label="θ(t)")
    size = 5 if len(low[0]) + len(high[0]) < 1000 else 1.5
    for (when, where), color, name in (
        (high, colours.upper, "maxima: upper envelope"),
        (low, colours.lower, "minima: lower envelope"),
    ):
        if len(when):
            ax.scatter(*thinned(when, where), s=size, color=color, lw=0, zorder=3, label=name)
    ax.set(
        ylabel="inclination θ (rad)" if inclined else "angle θ (rad)",
        title=title(attrs),
        xlim=span(t),
    )
    least, most = float(np.min(angle)), float(np.max(angle))
    if least >= 0 and most <= np.pi + 0.01 and most - least > WIDE:
        ticks_of_pi(ax)
        ax.set_ylim(-0.08, min(np.pi + 0.12, max(most * 1.15, 0.9)))
    lifted = events["time"].values[flagged(events["kind"], "liftoff")]
    for when in lifted[:1]:
        label = f"first liftoff at {when:.4g} s"
        ax.axvline(when, color=colours.alarm, lw=1.0, ls="--", label=label)
    legend(ax, "upper right", ncols=5, markerscale=2.5)
    if below is not None:
        _width(below, pieces)
    (below or ax).set_xlabel("time t (s)")
    return ax


def _width(ax: Axes, pieces: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> None:
    """Draw the width of the band over time, open where the band is."""
    for when, low, high in pieces:
        width = np.where(high > low, high - low, np.nan)
        ax.plot(*thinned(when, width), color=ink().upper, lw=0.9, marker=".", ms=2)
    ax.set(ylabel="width (rad)", yscale="log")
    ax.yaxis.set_minor_formatter(NullFormatter())


def bands(
    low: Curve, high: Curve, breaks: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return pieces of the band (times, low, high), broken at `breaks` and where turnings pause.

    theta is monotone in a pause, as in the rise of an inversion. More turnings than can be seen
    are one piece.
    """
    times = np.union1d(low[0], high[0])
    if len(low[0]) < 2 or len(high[0]) < 2:
        return []
    if len(times) > MOST_POINTS:
        grid = np.linspace(times[0], times[-1], 2000)
        return [(grid, np.interp(grid, *low), np.interp(grid, *high))]
    gaps = np.diff(times)
    pauses = np.flatnonzero(gaps > 3 * _usual(gaps)) + 1
    pieces = []
    for piece in np.split(times, np.union1d(pauses, np.searchsorted(times, breaks))):
        parts = [
            np.compress(np.isin(when, piece), (when, angles), axis=1)
            for when, angles in (low, high)
        ]
        if all(part.shape[1] >= 2 for part in parts):
            pieces.append((piece, *(np.interp(piece, *part) for part in parts)))
    return pieces


def _usual(values: np.ndarray) -> np.ndarray:
    """Return the median of the 21 values around each."""
    return np.array([np.median(values[max(0, i - 10) : i + 11]) for i in range(len(values))])


def _turnings(events: Any, sign: int, of_band: bool = False) -> Curve:
    """Return times and angles of the significant minima (sign +1) or maxima (-1) of theta.

    For the band, turnings of a trembling after an impact are left out.
    """
    keep = flagged(events["kind"], "turning") & events["significant"].values.astype(bool)
    if of_band:
        keep[keep] = ~_trembling(events["amplitude"].values[keep])
    keep &= events["theta_dot_sign"].values == sign
    return events["time"].values[keep], events["theta"].values[keep]


def _trembling(swings: np.ndarray) -> np.ndarray:
    """Select pairs of turnings whose swing is far smaller than those around it."""
    if not 0 < len(swings) <= MOST_POINTS:
        return np.zeros(len(swings), dtype=bool)
    small = swings < TREMBLING * _usual(swings)
    small[1:] &= ~small[:-1]  # every other one in a row, so that maxima and minima alternate
    return small | np.r_[small[1:], False]

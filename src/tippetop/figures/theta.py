"""theta(t) of a run: its turning angles, the nutational band between them, and how wide that is."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from ..columns import flagged
from .labels import title
from .style import ink, legend, panels_over_time, ticks_of_pi
from .thinning import MOST_POINTS, span, thinned


Curve = tuple[np.ndarray, np.ndarray]
TREMBLING = 0.02  # of the usual swing
WIDE = 1.2  # rad: an axis of angles over more than this has ticks at parts of pi


def theta(trajectory: Any, events: Any, attrs: dict[str, Any], ax: Axes | None = None) -> Axes:
    """theta(t) with the logged turning angles and their envelopes, the nutational band; below, how
    wide it is.

    In a panel that is given there is nothing below. A run without a band has no panel below.
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
    words = "nutational band" if inclined else "band between the turnings"
    for i, (when, bottom, top) in enumerate(pieces):
        ax.fill_between(
            when, bottom, top, color=colours.upper, alpha=0.22, lw=0, label="_" * (i > 0) + words
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
    _ticks(ax, float(np.min(angle)), float(np.max(angle)))
    lifted = events["time"].values[flagged(events["kind"], "liftoff")]
    for when in lifted[:1]:
        words = "liftoff" if len(lifted) == 1 else "first liftoff"
        ax.axvline(when, color=colours.alarm, lw=1.0, ls="--", label=f"{words} at {when:.4g} s")
    legend(ax, "upper right", ncols=5, markerscale=2.5)
    if below is not None:
        _width(below, pieces)
    (below or ax).set_xlabel("time t (s)")
    return ax


def _ticks(ax: Axes, low: float, high: float) -> None:
    """Limits around the angles; ticks at parts of pi, where they span much of a half turn."""
    if low >= 0 and high <= np.pi + 0.01 and high - low > WIDE:
        ticks_of_pi(ax)
        ax.set_ylim(-0.08, min(np.pi + 0.12, max(high * 1.15, 0.9)))
    elif high - low < 1e-9 * max(abs(high), 1):
        ax.set_ylim(low - 0.1, high + 0.1)


def _width(ax: Axes, pieces: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> None:
    """The width of the band over the time, open where the band is."""
    gap = np.array([np.nan])
    when = np.concatenate([part for t, *_ in pieces for part in (t, gap)])
    width = np.concatenate([part for _, low, high in pieces for part in (high - low, gap)])
    width[width <= 0] = np.nan
    ax.plot(*thinned(when, width), color=ink().upper, lw=0.9, marker=".", ms=2)
    ax.set_ylabel("width (rad)")
    if not np.isfinite(width).any():
        return
    if np.nanmax(width) > 10 * np.nanmin(width):
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(NullFormatter())
    else:
        ax.set_ylim(0, 1.25 * float(np.nanmax(width)))


def bands(
    low: Curve, high: Curve, breaks: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Pieces of the band between the envelopes (times, low, high), broken where turnings pause,
    since theta is monotone there (the rise of an inversion), and at these times. One piece, if
    turnings are more than can be seen: a pause would be narrower than a line.
    """
    times = np.union1d(low[0], high[0])
    if len(low[0]) < 2 or len(high[0]) < 2:
        return []
    if len(times) > MOST_POINTS:
        grid = np.linspace(times[0], times[-1], 2000)
        return [(grid, np.interp(grid, *low), np.interp(grid, *high))]
    pieces = []
    cuts = np.union1d(_pauses(times) + 1, np.searchsorted(times, breaks))
    for piece in np.split(times, cuts):
        if not len(piece):
            continue
        inside = [(c[0] >= piece[0]) & (c[0] <= piece[-1]) for c in (low, high)]
        if all(keep.sum() >= 2 for keep in inside):
            parts = [(c[0][keep], c[1][keep]) for c, keep in zip((low, high), inside, strict=True)]
            pieces.append((piece, np.interp(piece, *parts[0]), np.interp(piece, *parts[1])))
    return pieces


def _pauses(times: np.ndarray) -> np.ndarray:
    """After which of these times a pause follows, three times as long as is usual there."""
    gaps = np.diff(times)
    return np.flatnonzero(gaps > 3 * _usual(gaps))


def _usual(values: np.ndarray) -> np.ndarray:
    """The median of the 21 values around each."""
    return np.array([np.median(values[max(0, i - 10) : i + 11]) for i in range(len(values))])


def _turnings(events: Any, sign: int, of_band: bool = False) -> Curve:
    """Times and angles of the significant minima (sign +1) or maxima (-1) of theta; of the band
    those alone that are no trembling within a swing, as impacts leave it.
    """
    keep = flagged(events["kind"], "turning") & events["significant"].values.astype(bool)
    if of_band:
        keep[keep] = ~_trembling(events["amplitude"].values[keep])
    keep &= events["theta_dot_sign"].values == sign
    return events["time"].values[keep], events["theta"].values[keep]


def _trembling(swings: np.ndarray) -> np.ndarray:
    """Which turnings begin or end a swing that is far smaller than those around it; they come in
    pairs.
    """
    if not 0 < len(swings) <= MOST_POINTS:
        return np.zeros(len(swings), dtype=bool)
    small = swings < TREMBLING * _usual(swings)
    small[1:] &= ~small[:-1]  # of several in a row every other one: maxima and minima stay in turns
    return small | np.r_[small[1:], False]

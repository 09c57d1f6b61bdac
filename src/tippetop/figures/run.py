"""Figures of a single run. Each takes the groups of its store (Datasets or columns) and its root attributes."""

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import NullFormatter

from ..columns import flagged
from .style import ALARM, LOWER, QUIET, RUN, UPPER, figure


MOST_POINTS = 40_000  # more cannot be seen; beyond it the smallest and largest of each bin are drawn


SYMBOLS = {
    "theta": "θ",
    "theta_dot": "θ'",
    "phi": "φ",
    "phi_dot": "φ'",
    "psi_dot": "ψ'",
    "omega3": "ω₃",
    "nu_x": "$\\nu_x$",
    "nu_y": "$\\nu_y$",
    "nu_z": "$\\nu_z$",
    "lambda": "λ",
}
"""Initial keys as the axes of figures write them."""


def theta(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """theta(t) with the logged turning angles and their envelopes, the nutational band; below, its width."""
    fig = figure(10, 6.2)
    axes, below = fig.subplots(2, sharex=True, height_ratios=(4, 1.2))
    t, angle = trajectory["time"].values, trajectory["theta"].values
    low, high = _turnings(events, +1), _turnings(events, -1)
    for when, bottom, top in _bands(low, high):
        axes.fill_between(when, bottom, top, color=UPPER, alpha=0.16, lw=0)
    axes.plot(*_thinned(t, angle), color=RUN, lw=0.7, label="θ(t)")
    size = 5 if len(low[0]) + len(high[0]) < 1000 else 1.5
    for (when, where), color, words in (
        (high, UPPER, "maxima: upper envelope"),
        (low, LOWER, "minima: lower envelope"),
    ):
        axes.scatter(*_thinned(when, where), s=size, color=color, lw=0, zorder=3, label=words)
    axes.set(ylabel="θ (rad)", title=_title(attrs), xlim=_span(t))
    if np.min(angle) >= 0 and np.max(angle) <= np.pi + 0.01 and np.max(angle) > 0.8:
        axes.set_yticks(np.arange(5) * np.pi / 4, ["0", "π/4", "π/2", "3π/4", "π"])
        axes.set_ylim(-0.08, min(np.pi + 0.12, max(np.max(angle) * 1.15, 0.9)))
    liftoffs = _of(events, "liftoff")
    for when in liftoffs[:1]:
        words = "liftoff" if len(liftoffs) == 1 else "first liftoff"
        axes.axvline(when, color=ALARM, lw=1.0, ls="--", label=f"{words} at {when:.4g} s")
    fig.legend(loc="outside upper right", ncols=4, markerscale=2.5, fontsize=9)
    turning = flagged(events["kind"], "turning") & events["significant"].values.astype(bool)
    swing = events["amplitude"].values[turning]
    if len(swing):
        when = events["time"].values[turning]
        gaps = _pauses(when) + 1
        curve = _thinned(np.insert(when, gaps, when[gaps]), np.insert(swing, gaps, np.nan))
        below.plot(*curve, color=UPPER, lw=0.9, marker=".", ms=2)
        if swing.max() > 10 * swing.min():
            below.set_yscale("log")
            below.yaxis.set_minor_formatter(NullFormatter())
        else:
            below.set_ylim(0, 1.25 * swing.max())
    below.set(xlabel="t (s)", ylabel="swing of θ (rad)")
    return fig


def normal_force(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """g_n(t) in units of the weight m g."""
    fig = figure(10, 4.2)
    axes = fig.subplots()
    t, weight = trajectory["time"].values, attrs["parameters"]["m"] * attrs["parameters"]["g"]
    force = trajectory["normal_force"].values / weight
    axes.plot(*_thinned(t, force), color=RUN, lw=0.8)
    axes.axhline(1.0, color=QUIET, lw=0.8)
    axes.axhline(0.0, color=ALARM, lw=1.0, ls="--")
    axes.annotate(
        "liftoff",
        (1.0, 0.0),
        xycoords=("axes fraction", "data"),
        color=ALARM,
        xytext=(4, -3),
        textcoords="offset points",
    )
    axes.annotate(
        "weight",
        (1.0, 1.0),
        xycoords=("axes fraction", "data"),
        color=QUIET,
        xytext=(4, -3),
        textcoords="offset points",
    )
    report = attrs.get("report", {}).get("normal_force")
    if report:
        for key, color, side in (("min", LOWER, -14), ("max", UPPER, 6)):
            value, when = report[key] / weight, report[f"t_{key}"]
            if "phase" in trajectory and value < 1e-9:
                continue  # the body flies: there is no force
            axes.scatter([when], [value], s=22, color=color, zorder=3)
            axes.annotate(
                f"{key} {value:.4f} at {when:.4f} s",
                (when, value),
                color=color,
                xytext=(8, side),
                textcoords="offset points",
            )
    low, high = min(0.0, float(force.min())), float(force.max())
    axes.set(xlabel="t (s)", ylabel="$g_n\\,/\\,mg$", title=_title(attrs), xlim=_span(t))
    axes.set_ylim(low - 0.12 * (high - low), high + 0.15 * (high - low))
    return fig


INTEGRALS = {
    "jellett": "Jellett's integral λ",
    "routh": "Routh's function D",
    "L3": "L₃",
    "Lz": "L about the vertical",
}


def _changes(trajectory: Any, attrs: dict[str, Any]) -> list[tuple[str, np.ndarray, str]]:
    """Relative changes since the start of what must not change: words, values (time,), colour."""
    curves: list[tuple[str, np.ndarray]] = []
    for name, words in INTEGRALS.items():
        if name in attrs["report"]["drift"] and name in trajectory:
            taken = _taken(trajectory) if name == "jellett" else np.empty(0, dtype=int)
            pieces = np.split(trajectory[name].values, taken)
            words += ", since its ball touched first" if len(taken) else ""
            curves.append((words, np.concatenate([_relative(piece) for piece in pieces])))
    if "energy" in trajectory:
        work = trajectory["work"].values if "work" in trajectory else 0.0
        curves.append(("energy balance E + ∫ friction power", _relative(trajectory["energy"].values + work)))
    if "axis" in trajectory:
        curves.append(("length of the axis |3hat|", _relative(np.linalg.norm(trajectory["axis"].values, axis=1))))
    colors = (RUN, UPPER, LOWER, QUIET, ALARM)
    return [(words, values, color) for (words, values), color in zip(curves, colors, strict=False)]


def _taken(trajectory: Any) -> np.ndarray:
    """The rows at which another ball is in contact than at the row before."""
    return np.flatnonzero(np.diff(trajectory["ball"].values)) + 1 if "ball" in trajectory else np.empty(0, dtype=int)


def drift(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """How well the run kept what must not change: the picture of trust."""
    fig = figure(10, 4.6)
    axes = fig.subplots()
    t, curves = trajectory["time"].values, _changes(trajectory, attrs)
    for words, values, color in curves:
        axes.semilogy(*_worst(t, np.maximum(values, 1e-17)), color=color, lw=1.3, label=words)
    _rounding_unit(axes)
    axes.set(xlabel="t (s)", ylabel="relative change since t = 0 (worst per bin)", title=_title(attrs), xlim=_span(t))
    top = max((float(v.max()) for _, v, _ in curves), default=0.0)
    axes.set_ylim(0.6e-17, max(1e-14, 30 * top))
    axes.legend(loc="upper left", ncols=2)
    return fig


def growth(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """How the worst change since the start grows with the length of the run, beside a random walk's sqrt(t)."""
    fig = figure(9, 5.2)
    axes = fig.subplots()
    t, curves = trajectory["time"].values[1:], _changes(trajectory, attrs)
    for words, values, color in curves:
        axes.loglog(t, np.maximum(np.maximum.accumulate(values[1:]), 1e-17), color=color, lw=1.3, label=words)
    _rounding_unit(axes)
    walk = max(float(values.max()) for _, values, _ in curves)
    axes.loglog(t, walk * np.sqrt(t / t[-1]), color=QUIET, lw=1.0, ls="--", label="∝ √t")
    axes.set(xlabel="t (s)", ylabel="worst relative change up to t", title=_title(attrs), xlim=(t[0], t[-1]))
    axes.set_ylim(0.6e-17, max(1e-14, 100 * max(float(values.max()) for _, values, _ in curves)))
    axes.legend(loc="upper left", ncols=2)
    return fig


def _rounding_unit(axes: Any) -> None:
    axes.axhline(2.2e-16, color=QUIET, lw=0.8, ls=":")
    axes.annotate(
        "rounding\nunit",
        (1.0, 2.2e-16),
        xycoords=("axes fraction", "data"),
        color=QUIET,
        xytext=(4, -8),
        textcoords="offset points",
    )


def sphere(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """The path of 3hat on the unit sphere: from the side, from above, from below; the far side is left out."""
    fig = figure(12, 4.9)
    path, t = trajectory["axis"].values, trajectory["time"].values
    step = max(1, len(path) // MOST_POINTS)
    path, t = path[::step], t[::step]
    views = (
        ("from the side", (1, 2, 0), "y", "z"),
        ("from above", (0, 1, 2), "x", "y"),
        ("from below", (0, 1, 2), "x", "y"),
    )
    lines: Any = None
    for axes, (words, (right, up, towards), xlabel, ylabel) in zip(fig.subplots(1, 3), views, strict=True):
        depth = path[:, towards] * (-1 if words == "from below" else 1)
        near = (depth[1:] >= 0) & (depth[:-1] >= 0)
        plane = path[:, (right, up)] * ((1, -1) if words == "from below" else (1, 1))
        segments = np.stack([plane[:-1], plane[1:]], axis=1)[near]
        lines = LineCollection(list(segments), array=t[1:][near], cmap="viridis", lw=0.5)
        lines.set_clim(*_span(t))
        axes.add_patch(Circle((0, 0), 1, fill=False, color=QUIET, lw=0.8))
        axes.add_collection(lines)
        for angle in (np.pi / 6, np.pi / 3):  # circles of latitude, 30 and 60 degrees
            if towards == 2:
                axes.add_patch(Circle((0, 0), np.cos(angle), fill=False, color="#e3e6ea", lw=0.6, zorder=0))
            else:
                for z in (np.sin(angle), -np.sin(angle)):
                    axes.hlines(z, -np.cos(angle), np.cos(angle), color="#e3e6ea", lw=0.6, zorder=0)
        axes.grid(False)
        axes.set(
            xlim=(-1.08, 1.08), ylim=(-1.08, 1.08), aspect="equal", title=words, xticks=(-1, 0, 1), yticks=(-1, 0, 1)
        )
        axes.set_xlabel(f"3hat · {xlabel}")
        axes.set_ylabel(f"3hat · {'−' if words == 'from below' else ''}{ylabel}")
    fig.colorbar(lines, ax=fig.axes, shrink=0.8, pad=0.01, label="t (s)")
    fig.suptitle(_title(attrs), x=0.01, ha="left", fontsize=11)
    return fig


def energy(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Figure:
    """Energy E, modified energy E~ and what friction has taken."""
    fig = figure(10, 4.6)
    axes = fig.subplots()
    t = trajectory["time"].values
    curves = (
        ("modified_energy", "modified energy Ẽ", UPPER),
        ("energy", "energy E", RUN),
        ("work", "taken by friction and impacts" if "phase" in trajectory else "taken by friction", LOWER),
    )
    for name, words, color in curves:
        if name in trajectory:
            axes.plot(*_thinned(t, 1e3 * trajectory[name].values), color=color, lw=0.9, label=words)
    axes.set(xlabel="t (s)", ylabel="energy (mJ)", title=_title(attrs), xlim=_span(t))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return fig


def _bands(low: Any, high: Any) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Pieces of the band between the envelopes, broken where turnings pause: theta is monotone there. One piece, if
    turnings are more than can be seen: a pause would be narrower than a line."""
    times = np.union1d(low[0], high[0])
    if len(low[0]) < 2 or len(high[0]) < 2:
        return []
    if len(times) > MOST_POINTS:
        grid = np.linspace(times[0], times[-1], 2000)
        return [(grid, np.interp(grid, *low), np.interp(grid, *high))]
    pieces = []
    for piece in np.split(times, _pauses(times) + 1):
        inside = [(c[0] >= piece[0]) & (c[0] <= piece[-1]) for c in (low, high)]
        if all(keep.sum() >= 2 for keep in inside):
            edges = [np.interp(piece, c[0][keep], c[1][keep]) for c, keep in zip((low, high), inside, strict=True)]
            pieces.append((piece, *edges))
    return pieces


def _pauses(times: np.ndarray) -> np.ndarray:
    """After which of these times a pause follows, three times as long as is usual there; none, if times are more than
    can be seen."""
    if len(times) > MOST_POINTS:
        return np.empty(0, dtype=int)
    gaps = np.diff(times)
    usual = np.array([np.median(gaps[max(0, i - 10) : i + 11]) for i in range(len(gaps))])
    return np.flatnonzero(gaps > 3 * usual)


def _worst(t: np.ndarray, values: np.ndarray, bins: int = 250) -> tuple[np.ndarray, np.ndarray]:
    """The largest value of each of `bins` stretches of the run."""
    edges = np.unique(np.linspace(0, len(t), min(bins, len(t)) + 1).astype(int))[:-1]
    return t[edges], np.maximum.reduceat(values, edges)


def _title(attrs: dict[str, Any]) -> str:
    """One line: the system and what makes this run this run."""
    initial = ", ".join(
        "centre of mass at rest" if name == "centre_at_rest" else f"{SYMBOLS.get(name, name)}(0) = {value:g}"
        for name, value in attrs["initial"].items()
        if isinstance(value, (int, float))
    )
    return f"{attrs['title']}: {initial}" if initial else attrs["title"]


def _span(t: np.ndarray) -> tuple[float, float]:
    return (float(t[0]), float(t[-1])) if len(t) > 1 and t[-1] > t[0] else (-1.0, 1.0)


def _of(events: Any, kind: str) -> np.ndarray:
    return events["time"].values[flagged(events["kind"], kind)]


def _turnings(events: Any, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of the significant minima (sign +1) or maxima (-1) of theta."""
    keep = flagged(events["kind"], "turning") & events["significant"].values.astype(bool)
    keep &= events["theta_dot_sign"].values == sign
    return events["time"].values[keep], events["theta"].values[keep]


def _relative(values: np.ndarray) -> np.ndarray:
    first = values[0]
    return np.abs(values - first) / (abs(first) if first else 1.0)


def _thinned(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve with at most MOST_POINTS points: smallest and largest of each bin, so that no peak is lost."""
    if len(t) <= MOST_POINTS:
        return t, values
    size = -(-len(t) // (MOST_POINTS // 2))
    whole = len(t) // size * size
    bins = values[:whole].reshape(-1, size)
    first = np.arange(len(bins)) * size
    pick = np.sort(np.concatenate([first + bins.argmin(axis=1), first + bins.argmax(axis=1), np.arange(whole, len(t))]))
    return t[pick], values[pick]

"""Figures of a sweep: maps over two of its axes, curves over one. No physics."""

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .style import ALARM, LOWER, QUIET, RUN, UPPER, figure


COLOURS = {
    "none": "#4b5563",
    "upright": LOWER,
    "tumbling": "#e0a800",
    "inverted": UPPER,
    "lifted-off": "#6d28d9",
    "under-way": "#b8c4d0",
    "rolling": "#5b8c5a",
    "on-stem": "#7c3aed",
    "bouncing": "#0ea5e9",
}
NOT_INVERTED = {
    "upright": "ended upright",
    "tumbling": "not inverted in time: tumbling",
    "inverted": "inverted later than most of its cell",
    "lifted-off": "lifted off before it inverted",
    "under-way": "not inverted in time: under way",
    "rolling": "rolling",
    "on-stem": "on its stem",
    "bouncing": "in the air",
}
"""The end of tops without a time of inversion, by their class."""
STYLES = ("-", "--", ":", "-.")
TITLES = {
    "class": "Fate of each top",
    "inversion": "Time of inversion, first rise of θ through π − 0.1",
    "normal-force": "Least normal force",
}
ONE_AXIS = {"inversion": "Times of inversion", "normal-force": "Extremes of the normal force"}
TOUCH = 1e-9  # of m g: a top that was stopped at liftoff ends within rounding of zero force


def draw_map(sweep_map: Any) -> Figure:
    """The figure of a map, as `sweeps.maps` makes it."""
    return _over_two(sweep_map) if len(sweep_map.axes) == 2 else _over_one(sweep_map)


def _over_two(sweep_map: Any) -> Figure:
    picture = figure(9.6, 5.6)
    axes = picture.add_subplot()
    axes.grid(False)
    x, y = sweep_map.axes
    field = next(iter(sweep_map.fields.values())).T
    entries: list[Any] = []
    if sweep_map.kind == "class":
        colours = ListedColormap([COLOURS[name] for name in sweep_map.classes])
        axes.pcolormesh(
            x.edges, y.edges, field, cmap=colours, vmin=-0.5, vmax=len(sweep_map.classes) - 0.5, rasterized=True
        )
        present = [name for i, name in enumerate(sweep_map.classes) if (field == i).any()]
        entries += [Patch(color=COLOURS[name], label=_name(name)) for name in present]
    elif np.isfinite(field).any():
        force = sweep_map.kind == "normal-force"
        mesh = axes.pcolormesh(x.edges, y.edges, field, cmap="cividis" if force else "viridis", rasterized=True)
        picture.colorbar(mesh, ax=axes, label="least $g_n$/(m g)" if force else "inverted at t (s)", pad=0.02)
        if force:
            entries += _liftoff(axes, x, y, field)
    if sweep_map.kind == "inversion" and np.isnan(field).any():
        axes.set_facecolor("#e8ebee")
        ends = sweep_map.fields.get("class", np.full_like(field.T, np.nan)).T
        for i, name in enumerate(sweep_map.classes):
            if (here := ends == i).any():
                one = ListedColormap([COLOURS[name]])
                axes.pcolormesh(x.edges, y.edges, np.where(here, 0.0, np.nan), cmap=one, rasterized=True)
                entries.append(Patch(color=COLOURS[name], label=NOT_INVERTED.get(name, _name(name))))
        if (np.isnan(field) & np.isnan(ends)).any():
            entries.append(Patch(color="#e8ebee", label="not inverted in time"))
    entries += _borders(axes, sweep_map)
    _dress(axes, sweep_map, x)
    axes.set_ylabel(y.label)
    if y.log:
        axes.set_yscale("log")
    axes.set_ylim(y.edges[0], y.edges[-1])
    if entries:
        picture.legend(handles=entries, loc="outside lower center", ncols=2 if len(entries) < 7 else 3)
    return picture


def _liftoff(axes: Any, x: Any, y: Any, field: np.ndarray) -> list[Any]:
    """The border at which the normal force reaches zero."""
    touches: Any = np.ma.array(field <= TOUCH, dtype=float, mask=np.isnan(field))
    if min(field.shape) < 2 or not touches.min() < touches.max():
        return []
    axes.contour(x.centres, y.centres, touches, [0.5], colors=ALARM, linewidths=1.4)
    return [Line2D([], [], color=ALARM, lw=1.4, label="liftoff: $g_n$ reaches 0")]


def _borders(axes: Any, sweep_map: Any) -> list[Any]:
    """Thresholds as lines over the map, white below black so that they show on every colour."""
    x, y = (axis.span for axis in sweep_map.axes)
    entries = []
    for (label, values), style in zip(sweep_map.borders.items(), STYLES, strict=False):
        axes.contour(x, y, values.T, [0.0], colors="white", linewidths=3.0, alpha=0.7)
        axes.contour(x, y, values.T, [0.0], colors="black", linewidths=1.3, linestyles=[style])
        entries.append(Line2D([], [], color="black", lw=1.3, ls=style, label=_mathematical(label)))
    return entries


def _over_one(sweep_map: Any) -> Figure:
    picture = figure(9.0, 5.0)
    axes = picture.add_subplot()
    (x,) = sweep_map.axes
    marker = "." if len(x.centres) < 200 else ""
    if sweep_map.kind == "class":
        kinds, theta = sweep_map.fields["class"], sweep_map.fields["theta_end"]
        axes.plot(x.centres, theta, color=QUIET, lw=0.8)
        for i, name in enumerate(sweep_map.classes):
            here = kinds == i
            if (here & np.isfinite(theta)).any():
                axes.plot(x.centres[here], theta[here], ".", color=COLOURS[name], label=_name(name), ms=7)
        axes.set(ylabel="θ at the end (rad)", ylim=(-0.1, np.pi + 0.1))
        axes.set_yticks(np.arange(5) * np.pi / 4, ["0", "π/4", "π/2", "3π/4", "π"])
    elif sweep_map.kind == "inversion":
        for name, colour, words in (("first_equator", LOWER, "θ = π/2"), ("inverted_at", UPPER, "θ = π − 0.1")):
            axes.plot(x.centres, sweep_map.fields[name], color=colour, marker=marker, label=f"first {words}")
        axes.set_ylabel("t (s)")
    else:
        for name, colour, words in (("normal_force_min", RUN, "least"), ("normal_force_max", UPPER, "greatest")):
            axes.plot(x.centres, sweep_map.fields[name], color=colour, marker=marker, label=words)
        axes.axhline(0, color=ALARM, lw=0.9)
        axes.set_ylabel("normal force $g_n$/(m g)")
    for (label, values), style in zip(sweep_map.borders.items(), STYLES, strict=False):
        known, above = np.isfinite(values), values > 0
        passed = known[1:] & known[:-1] & (above[1:] != above[:-1])
        for i, at in enumerate(x.span[:-1][passed]):
            axes.axvline(at, color="black", lw=1.0, ls=style, label=_mathematical(label) if i == 0 else None)
    _dress(axes, sweep_map, x)
    picture.legend(loc="outside lower center", ncols=3)
    return picture


def _dress(axes: Any, sweep_map: Any, x: Any) -> None:
    axes.set_xlabel(x.label)
    if x.log:
        axes.set_xscale("log")
    axes.set_xlim(x.edges[0], x.edges[-1])
    notes = f"\n{'; '.join(sweep_map.notes)}" if sweep_map.notes else ""
    title = TITLES[sweep_map.kind] if len(sweep_map.axes) == 2 else ONE_AXIS.get(sweep_map.kind, TITLES[sweep_map.kind])
    axes.set_title(f"{title} · {sweep_map.title}{notes}")


def _name(name: str) -> str:
    """The name of a class."""
    return "no end: invalid, not finite, stalled" if name == "none" else name.replace("-", " ")


def _mathematical(label: str) -> str:
    """Greek and indices as matplotlib sets them: `λ = λ_u: words`."""
    symbol, _, words = label.partition(": ")
    return f"${symbol.replace('λ', chr(92) + 'lambda').replace('_de', '_{de}')}$: {words}"

"""Figures of a sweep: maps over two of its axes, curves over one.

`sweep_map` is a `sweeps.maps.Map`: fields over cells, axes and borders. Axes come out.
"""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from ..columns import capitalised
from .style import (
    DASHES,
    broken,
    compact,
    draw_curves,
    heading,
    ink,
    legend,
    panel,
    ticks_of_inclination,
)


CLASSES = {
    "none": ("#4b5563", "no end: invalid, not finite, stalled, not followed"),
    "upright": ("lower", "upright"),
    "near-upright": ("#9ad1c8", "still near upright"),
    "tumbling": ("#e0a800", "tumbling"),
    "inverted": ("upper", "inverted"),
    "lifted-off": ("#6d28d9", "lifted off"),
    "under-way": ("#b8c4d0", "under way"),
    "rolling": ("#5b8c5a", "rolling"),
    "on-stem": ("#b06ab3", "on its stem"),
    "bouncing": ("#0ea5e9", "in the air"),
    "nutating": ("#d9c7a3", "nutates for ever: no friction"),
    "at-rest": ("#111111", "at rest"),
}
"""Colour and label of each class of `sweeps.maps.SHOWN`, as in `views/page/map.js`.

A colour may be a field of `Ink`."""


def colours() -> dict[str, str]:
    """Return the colour of each class of tops."""
    return {name: getattr(ink(), colour, colour) for name, (colour, _) in CLASSES.items()}


TITLES = {
    "class": "fate of each top",
    "inversion": "time of inversion, first rise of θ through π − 0.1",
    "normal-force": "normal force",
    "lyapunov": "finite-time Lyapunov exponent to the end of the run",
}
FIELDS = {
    "inversion": ("viridis", "time of inversion t (s)"),
    "normal-force": ("cividis", "least normal force $g_n\\,/\\,mg$"),
    "lyapunov": ("inferno", "growth rate of an error (s⁻¹)"),
}
"""Colour map and label of numbers."""
CURVES = {
    "inversion": (
        "time t (s)",
        {"first_equator": "first θ = π/2", "inverted_at": "first θ = π − 0.1"},
    ),
    "normal-force": (
        "normal force $g_n\\,/\\,mg$",
        {"normal_force_min": "least", "normal_force_max": "greatest"},
    ),
    "lyapunov": (FIELDS["lyapunov"][1], {"lyapunov": ""}),
}
"""Curves over one axis: the label of the axis, and the words of each column of `maps.NEEDED`."""
# Fraction of m g: a top that was stopped at liftoff ends within rounding of zero force
TOUCH = 1e-9


def draw_map(sweep_map: Any) -> Axes:
    """Draw a map, as `sweeps.maps.make_map` returns it; return the Axes."""
    axes = panel(9.6, 5.6)
    x, *further = sweep_map.axes
    entries = (_over_two if further else _over_one)(axes, sweep_map)
    axes.set(xlabel=x.label, xscale="log" if x.log else "linear", xlim=x.edges[[0, -1]])
    words = f"{capitalised(sweep_map.title)}: {TITLES[sweep_map.kind]}"
    notes = "; ".join(sweep_map.notes)
    axes.set_title("\n".join(map(heading, filter(None, (words, notes)))))
    if entries or not further:
        legend(axes, "lower center", handles=entries, ncols=3)
    return axes


def _over_two(axes: Any, sweep_map: Any) -> list[Any]:
    """Draw a map over two axes: the first of its fields; return the entries of its legend."""
    axes.grid(visible=False)
    x, y = sweep_map.axes
    axes.set(
        ylabel=broken(y.label, 30) if compact() else y.label,
        yscale="log" if y.log else "linear",
        ylim=y.edges[[0, -1]],
    )
    kind = sweep_map.kind
    field = next(iter(sweep_map.fields.values())).T
    entries: list[Any] = []
    if kind == "class":
        entries += _cells(axes, sweep_map, field, _of_classes(sweep_map))
    elif np.isfinite(field).any():
        cmap, label = FIELDS[kind]
        mesh = axes.pcolormesh(x.edges, y.edges, field, cmap=cmap, rasterized=True)
        axes.get_figure(root=True).colorbar(mesh, ax=axes, label=label, pad=0.02)
        if kind == "normal-force":
            touches = np.where(field <= TOUCH, 0.0, np.nan)
            liftoff = {"liftoff: $g_n$ reaches 0": ink().alarm}
            entries += _cells(axes, sweep_map, touches, liftoff)
    if kind == "inversion" and np.isnan(field).any():
        axes.set_facecolor(ink().grid)
        ends = sweep_map.fields.get("class", np.full_like(field.T, np.nan)).T
        entries += _cells(axes, sweep_map, ends, _of_classes(sweep_map))
        if (np.isnan(field) & np.isnan(ends)).any():
            entries.append(Patch(color=ink().grid, label="not inverted in time"))
    for words, values, dashes in _borders(sweep_map):
        line: Any = {"colors": "black", "linewidths": 1.3, "linestyles": [dashes]}
        drawn = axes.contour(x.span, y.span, values.T, [0.0], **line)
        # visible on every colour
        drawn.set_path_effects([withStroke(linewidth=3.0, foreground="white", alpha=0.7)])
        entries.append(Line2D([], [], color="black", lw=1.3, ls=dashes, label=words))
    return entries


def _cells(axes: Any, sweep_map: Any, values: np.ndarray, shades: dict[str, str]) -> list[Any]:
    """Draw cells of the values 0, 1, ..., places in `shades`: the colour of each label.

    Return entries of the legend for the values that occur.
    """
    x, y = (axis.edges for axis in sweep_map.axes)
    cmap = ListedColormap([*shades.values()])
    axes.pcolormesh(x, y, values, cmap=cmap, vmin=-0.5, vmax=len(shades) - 0.5, rasterized=True)
    entries = [Patch(color=color, label=label) for label, color in shades.items()]
    return [entry for i, entry in enumerate(entries) if (values == i).any()]


def _of_classes(sweep_map: Any) -> dict[str, str]:
    """Return the colour of each class of a map, by its label, in the order of the field `class`."""
    return {CLASSES[name][1]: colours()[name] for name in sweep_map.classes}


def _over_one(axes: Any, sweep_map: Any) -> None:
    """Draw a map over one axis into `axes`, as curves."""
    (x,), fields = sweep_map.axes, sweep_map.fields
    if sweep_map.kind == "class":
        for i, (label, color) in enumerate(_of_classes(sweep_map).items()):
            theta = np.where(fields["class"] == i, fields["theta_end"], np.nan)
            if np.isfinite(theta).any():
                style: Any = {"marker": ".", "ms": 7, "lw": 0.8, "label": label}
                axes.plot(x.centres, theta, color=color, **style)
        axes.set(ylabel="inclination θ at the end (rad)", ylim=(-0.1, np.pi + 0.1))
        ticks_of_inclination(axes)
    else:
        ylabel, columns = CURVES[sweep_map.kind]
        curves = [(text, x.centres, fields[name]) for name, text in columns.items()]
        draw_curves(axes, curves, marker="." if len(x.centres) < 200 else "")
        axes.set_ylabel(ylabel)
        if sweep_map.kind != "inversion":
            axes.axhline(0, color=ink().alarm, lw=0.9)
    for words, values, dashes in _borders(sweep_map):
        above = np.where(np.isnan(values), np.nan, values > 0)
        # where the sign changes; a difference with NaN is not 1
        for at in x.span[:-1][np.abs(np.diff(above)) == 1]:
            axes.axvline(at, color=ink().mark, ls=dashes, label=words)


def _borders(sweep_map: Any) -> Iterator[tuple[str, np.ndarray, Any]]:
    """Yield label, values and dashes of each border.

    The symbols of a label, such as `λ = λ_u: words`, are formulas; `outlook.tippe_top_borders`
    makes the labels.
    """
    for (label, values), dashes in zip(sweep_map.borders.items(), itertools.cycle(DASHES)):
        symbol, _, words = label.partition(": ")
        symbol = symbol.replace("λ", r"\lambda").replace("_de", "_{de}")
        yield f"${symbol}$" if compact() else f"${symbol}$: {words}", values, dashes

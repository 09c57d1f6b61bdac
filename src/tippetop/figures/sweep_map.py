"""Figures of a sweep: maps over two of its axes, curves over one."""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from ..columns import capitalised
from .style import DASHES, draw_curves, heading, ink, legend, panel, ticks_of_inclination


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
"""Colour and label of each class of tops."""


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
    "lyapunov": ("inferno", "largest growth rate of a small error (s⁻¹)"),
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
"""Curves over one axis: the label of the axis, and the words of each column."""
# Fraction of m g: a top that was stopped at liftoff ends within rounding of zero force
TOUCH = 1e-9


def draw_map(sweep_map: Any) -> Axes:
    """Draw a map, as `sweeps.maps` makes it."""
    axes = panel(9.6, 5.6)
    x, *further = sweep_map.axes
    entries = (_over_two if further else _over_one)(axes, sweep_map)
    axes.set(xlabel=x.label, xscale="log" if x.log else "linear", xlim=x.edges[[0, -1]])
    lines = [
        f"{capitalised(sweep_map.title)}: {TITLES[sweep_map.kind]}",
        "; ".join(sweep_map.notes),
    ]
    axes.set_title("\n".join(heading(line) for line in lines if line))
    if entries or not further:
        legend(axes, "lower center", handles=entries, ncols=3)
    return axes


def _over_two(axes: Any, sweep_map: Any) -> list[Any]:
    """Draw a map over two axes; return the entries of its legend."""
    axes.grid(visible=False)
    x, y = sweep_map.axes
    axes.set(ylabel=y.label, yscale="log" if y.log else "linear", ylim=y.edges[[0, -1]])
    kind, field = sweep_map.kind, next(iter(sweep_map.fields.values())).T
    entries: list[Any] = []
    if kind == "class":
        entries += _classes(axes, sweep_map, field)
    elif np.isfinite(field).any():
        cmap, label = FIELDS[kind]
        mesh = axes.pcolormesh(x.edges, y.edges, field, cmap=cmap, rasterized=True)
        axes.get_figure(root=True).colorbar(mesh, ax=axes, label=label, pad=0.02)
        touches = field <= TOUCH
        if kind == "normal-force" and touches.any():
            shade = {"cmap": ListedColormap([ink().alarm]), "rasterized": True}
            axes.pcolormesh(x.edges, y.edges, np.where(touches, 0.0, np.nan), **shade)
            entries.append(Patch(color=ink().alarm, label="liftoff: $g_n$ reaches 0"))
    if kind == "inversion" and np.isnan(field).any():
        axes.set_facecolor(ink().grid)
        ends = sweep_map.fields.get("class", np.full_like(field.T, np.nan)).T
        entries += _classes(axes, sweep_map, ends)
        if (np.isnan(field) & np.isnan(ends)).any():
            entries.append(Patch(color=ink().grid, label="not inverted in time"))
    for (label, values), dashes in zip(sweep_map.borders.items(), itertools.cycle(DASHES)):
        line: Any = {"colors": "black", "linewidths": 1.3, "linestyles": [dashes]}
        drawn = axes.contour(x.span, y.span, values.T, [0.0], **line)
        # visible on every colour
        drawn.set_path_effects([withStroke(linewidth=3.0, foreground="white", alpha=0.7)])
        words = _mathematical(label)
        entries.append(Line2D([], [], color="black", lw=1.3, ls=dashes, label=words))
    return entries


def _classes(axes: Any, sweep_map: Any, values: np.ndarray) -> list[Any]:
    """Draw cells in the colours of their classes; return entries for those that occur."""
    of_class, names = colours(), sweep_map.classes
    shades, most = ListedColormap([of_class[name] for name in names]), len(names) - 0.5
    x, y = (axis.edges for axis in sweep_map.axes)
    axes.pcolormesh(x, y, values, cmap=shades, vmin=-0.5, vmax=most, rasterized=True)
    present = [name for i, name in enumerate(names) if (values == i).any()]
    return [Patch(color=of_class[name], label=CLASSES[name][1]) for name in present]


def _over_one(axes: Any, sweep_map: Any) -> None:
    """Draw curves over one axis."""
    of_class = colours()
    (x,), fields = sweep_map.axes, sweep_map.fields
    if sweep_map.kind == "class":
        for i, name in enumerate(sweep_map.classes):
            theta = np.where(fields["class"] == i, fields["theta_end"], np.nan)
            if np.isfinite(theta).any():
                style: Any = {"marker": ".", "ms": 7, "lw": 0.8, "label": CLASSES[name][1]}
                axes.plot(x.centres, theta, color=of_class[name], **style)
        axes.set(ylabel="inclination θ at the end (rad)", ylim=(-0.1, np.pi + 0.1))
        ticks_of_inclination(axes)
    else:
        label, words = CURVES[sweep_map.kind]
        curves = [(text, x.centres, fields[name]) for name, text in words.items()]
        draw_curves(axes, curves, marker="." if len(x.centres) < 200 else "")
        axes.set_ylabel(label)
        if sweep_map.kind != "inversion":
            axes.axhline(0, color=ink().alarm, lw=0.9)
    for (label, values), dashes in zip(sweep_map.borders.items(), itertools.cycle(DASHES)):
        above = np.where(np.isnan(values), np.nan, values > 0)
        for at in x.span[:-1][np.abs(np.diff(above)) == 1]:
            axes.axvline(at, color=ink().mark, ls=dashes, label=_mathematical(label))


def _mathematical(label: str) -> str:
    """Return a label such as `λ = λ_u: words` with its symbols as formulas."""
    symbol, _, words = label.partition(": ")
    return f"${symbol.replace('λ', chr(92) + 'lambda').replace('_de', '_{de}')}$: {words}"

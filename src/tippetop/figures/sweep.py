"""Figures of a sweep: maps over two of its axes, curves over one. No physics."""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .style import DASHES, heading, ink, legend, panel, ticks_of_pi


LIFTED, TUMBLING, STEM, FLYING, ROLLING = "#6d28d9", "#e0a800", "#b06ab3", "#0ea5e9", "#5b8c5a"


def colours() -> dict[str, str]:
    """The colour of each class of tops."""
    inks = ink()
    return {
        "none": "#4b5563",
        "upright": inks.lower,
        "near-upright": "#9ad1c8",
        "tumbling": TUMBLING,
        "inverted": inks.upper,
        "lifted-off": LIFTED,
        "under-way": "#b8c4d0",
        "rolling": ROLLING,
        "on-stem": STEM,
        "bouncing": FLYING,
        "nutating": "#d9c7a3",
    }


NOT_INVERTED = {
    "upright": "ended upright, where it stays",
    "near-upright": "still near upright",
    "tumbling": "not inverted in time: tumbling",
    "inverted": "inverted later than most of its cell",
    "lifted-off": "lifted off before it inverted",
    "under-way": "not inverted in time: under way",
    "rolling": "rolling",
    "on-stem": "on its stem",
    "bouncing": "in the air",
    "nutating": "nutates for ever: no friction",
}
"""The end of tops without a time of inversion, by their class."""
TITLES = {
    "class": "fate of each top",
    "inversion": "time of inversion, first rise of θ through π − 0.1",
    "normal-force": "least normal force",
    "lyapunov": "finite-time Lyapunov exponent to the end of the run",
}
FIELDS = {
    "inversion": ("viridis", "time of inversion t (s)"),
    "normal-force": ("cividis", "least normal force $g_n\\,/\\,mg$"),
    "lyapunov": ("inferno", "largest growth rate of a small error (s⁻¹)"),
}
"""Of what is a number: colours and label."""
CURVES: dict[str, tuple[str, dict[str, tuple[str, str, str | None]]]] = {
    "inversion": (
        "time t (s)",
        {
            "first_equator": ("lower", "--", "first θ = π/2"),
            "inverted_at": ("upper", "-", "first θ = π − 0.1"),
        },
    ),
    "normal-force": (
        "normal force $g_n\\,/\\,mg$",
        {
            "normal_force_min": ("run", "--", "least"),
            "normal_force_max": ("upper", "-", "greatest"),
        },
    ),
    "lyapunov": (FIELDS["lyapunov"][1], {"lyapunov": ("run", "-", None)}),
}
"""Over one axis: the label, and colour, style and words of each column."""
ONE_AXIS = {"inversion": "times of inversion", "normal-force": "extremes of the normal force"}
TOUCH = 1e-9  # of m g: a top that was stopped at liftoff ends within rounding of zero force


def draw_map(sweep_map: Any) -> Axes:
    """The figure of a map, as `sweeps.maps` makes it."""
    return (_over_two if len(sweep_map.axes) == 2 else _over_one)(sweep_map)


def _over_two(sweep_map: Any) -> Axes:
    axes = panel(None, 9.6, 5.6)
    picture: Any = axes.get_figure(root=True)
    axes.grid(visible=False)
    x, y = sweep_map.axes
    field = next(iter(sweep_map.fields.values())).T
    entries: list[Any] = []
    if sweep_map.kind == "class":
        entries += _classes(axes, sweep_map, field, {})
    elif np.isfinite(field).any():
        colours_of, label = FIELDS[sweep_map.kind]
        mesh = axes.pcolormesh(x.edges, y.edges, field, cmap=colours_of, rasterized=True)
        picture.colorbar(mesh, ax=axes, label=label, pad=0.02)
        if sweep_map.kind == "normal-force":
            entries += _liftoff(axes, x, y, field)
    if sweep_map.kind == "inversion" and np.isnan(field).any():
        axes.set_facecolor(ink().grid)
        ends = sweep_map.fields.get("class", np.full_like(field.T, np.nan)).T
        entries += _classes(axes, sweep_map, ends, NOT_INVERTED)
        if (np.isnan(field) & np.isnan(ends)).any():
            entries.append(Patch(color=ink().grid, label="not inverted in time"))
    entries += _borders(axes, sweep_map)
    _dress(axes, sweep_map, x)
    axes.set_ylabel(y.label)
    if y.log:
        axes.set_yscale("log")
    axes.set_ylim(y.edges[0], y.edges[-1])
    if entries:
        legend(axes, "lower center", handles=entries, ncols=2 if len(entries) < 7 else 3)
    return axes


def _classes(axes: Any, sweep_map: Any, values: np.ndarray, words: dict[str, str]) -> list[Any]:
    """The cells in the colours of their classes; entries of a legend for those that are there."""
    of_class, names = colours(), sweep_map.classes
    shades, most = ListedColormap([of_class[name] for name in names]), len(names) - 0.5
    x, y = (axis.edges for axis in sweep_map.axes)
    axes.pcolormesh(x, y, values, cmap=shades, vmin=-0.5, vmax=most, rasterized=True)
    present = [name for i, name in enumerate(names) if (values == i).any()]
    return [Patch(color=of_class[name], label=words.get(name, _name(name))) for name in present]


def _liftoff(axes: Any, x: Any, y: Any, field: np.ndarray) -> list[Any]:
    """The border at which the normal force reaches zero: the edges between cells that do and cells
    that do not.
    """
    touches = np.where(np.isnan(field), np.nan, field <= TOUCH)
    edges = [
        [(x.edges[j + side], y.edges[i + 1 - side]), (x.edges[j + 1], y.edges[i + 1])]
        for side in (1, 0)
        for i, j in zip(*np.nonzero(np.abs(np.diff(touches, axis=side)) == 1), strict=True)
    ]
    if not edges:
        return []
    axes.add_collection(
        LineCollection(edges, colors=ink().alarm, linewidths=1.6, capstyle="projecting")
    )
    return [Line2D([], [], color=ink().alarm, lw=1.6, label="liftoff: $g_n$ reaches 0")]


def _borders(axes: Any, sweep_map: Any) -> list[Any]:
    """Thresholds as lines over the map, white below black so that they show on every colour."""
    x, y = (axis.span for axis in sweep_map.axes)
    entries = []
    for (label, values), style in zip(sweep_map.borders.items(), itertools.cycle(DASHES)):
        axes.contour(x, y, values.T, [0.0], colors="white", linewidths=3.0, alpha=0.7)
        axes.contour(x, y, values.T, [0.0], colors="black", linewidths=1.3, linestyles=[style])
        entries.append(Line2D([], [], color="black", lw=1.3, ls=style, label=_mathematical(label)))
    return entries


def _over_one(sweep_map: Any) -> Axes:
    inks, of_class = ink(), colours()
    axes = panel(None, 9.0, 5.0)
    (x,) = sweep_map.axes
    marker = "." if len(x.centres) < 200 else ""
    if sweep_map.kind == "class":
        kinds, theta = sweep_map.fields["class"], sweep_map.fields["theta_end"]
        for piece in np.split(
            np.arange(len(theta)), np.flatnonzero(np.diff(np.nan_to_num(kinds, nan=-1))) + 1
        ):
            axes.plot(
                x.centres[piece], theta[piece], color=inks.quiet, lw=0.8
            )  # open where the fate changes
        for i, name in enumerate(sweep_map.classes):
            here = kinds == i
            if (here & np.isfinite(theta)).any():
                axes.plot(
                    x.centres[here], theta[here], ".", color=of_class[name], label=_name(name), ms=7
                )
        axes.set(ylabel="inclination θ at the end (rad)", ylim=(-0.1, np.pi + 0.1))
        ticks_of_pi(axes)
    else:
        label, curves = CURVES[sweep_map.kind]
        for name, (colour, style, words) in curves.items():
            values = sweep_map.fields[name]
            axes.plot(
                x.centres, values, color=getattr(inks, colour), ls=style, marker=marker, label=words
            )
        axes.set_ylabel(label)
        if sweep_map.kind != "inversion":
            force = sweep_map.kind == "normal-force"
            axes.axhline(0, color=inks.alarm if force else inks.quiet, lw=0.9 if force else 0.8)
    for (label, values), style in zip(sweep_map.borders.items(), itertools.cycle(DASHES)):
        known, above = np.isfinite(values), values > 0
        passed = known[1:] & known[:-1] & (above[1:] != above[:-1])
        for i, at in enumerate(x.span[:-1][passed]):
            axes.axvline(
                at,
                color=inks.mark,
                lw=1.0,
                ls=style,
                label=_mathematical(label) if i == 0 else None,
            )
    _dress(axes, sweep_map, x)
    legend(axes, "lower center", ncols=3)
    return axes


def _dress(axes: Any, sweep_map: Any, x: Any) -> None:
    axes.set_xlabel(x.label)
    if x.log:
        axes.set_xscale("log")
    axes.set_xlim(x.edges[0], x.edges[-1])
    name = sweep_map.title[:1].upper() + sweep_map.title[1:]
    title = (
        TITLES[sweep_map.kind]
        if len(sweep_map.axes) == 2
        else ONE_AXIS.get(sweep_map.kind, TITLES[sweep_map.kind])
    )
    lines = [f"{name}: {title}", *(["; ".join(sweep_map.notes)] if sweep_map.notes else [])]
    axes.set_title("\n".join(heading(line) for line in lines))


def _name(name: str) -> str:
    """The name of a class."""
    words = {
        "none": "no end: invalid, not finite, stalled, not followed",
        "near-upright": "still near upright",
    }
    return words.get(name, name.replace("-", " "))


def _mathematical(label: str) -> str:
    """Greek and indices as matplotlib sets them: `λ = λ_u: words`."""
    symbol, _, words = label.partition(": ")
    return f"${symbol.replace('λ', chr(92) + 'lambda').replace('_de', '_{de}')}$: {words}"

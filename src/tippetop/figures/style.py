"""The common style of the figures: colours, panels, legends, and saving.

Drawings are called inside of `styled`, and get their panels from `panel`.
"""

import itertools
import re
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.ticker import EngFormatter

from .thinning import thinned


Curve = tuple[str, np.ndarray, np.ndarray]
"""Label, times (or other places on the x axis) and values of a curve."""


class Ink(NamedTuple):
    """The colours of a figure.

    `upper` and `lower` are those of maxima and minima, and of the inverted and the upright spin;
    `sweep_map.CLASSES` has names of fields. `quiet` is for additions such as thresholds, `shades`
    for the phases of a contact, by name: on the body and on the stem, in this order.
    """

    run: str
    upper: str
    lower: str
    quiet: str
    alarm: str
    mark: str
    grid: str
    paper: str
    shades: dict[str, tuple[str, str]]
    stem: str


LIGHT = Ink(
    "#1f3b57", "#c2410c", "#0f766e", "#7b8691", "#b91c1c", "#111111", "#e3e6ea", "#ffffff",
    {
        "slip": ("#f4f1e4", "#e2d9b4"),
        "roll": ("#ddf2e5", "#a3d9ba"),
        "rest": ("#fbe2de", "#efb7ae"),
        "flight": ("#d3e2fb", "#d3e2fb"),
        "both": ("#ecdcf7", "#ecdcf7"),
    },
    "#6d28d9",
)  # fmt: skip
DARK = Ink(
    "#9cc4ec", "#fb923c", "#2dd4bf", "#8b96a1", "#f87171", "#f3f4f6", "#333a42", "#14181d",
    {
        "slip": ("#2a281f", "#4a442b"),
        "roll": ("#1c3227", "#2b5a41"),
        "rest": ("#3d2422", "#6b3b36"),
        "flight": ("#1e2d47", "#1e2d47"),
        "both": ("#35264a", "#35264a"),
    },
    "#c4a5ff",
)  # fmt: skip


class Setting(NamedTuple):
    """The colours, the size [inches], and the panel of the user's figure to draw in, if any."""

    ink: Ink = LIGHT
    size: tuple[float, float] | None = None
    panel: Axes | None = None


_setting: ContextVar[Setting] = ContextVar("setting", default=Setting())  # noqa: B039 - a tuple

FONT = 10.0
"""Font size [points] of figures that are at least FONT_WIDTH [inches] wide."""
FONT_WIDTH = 7.0
LEAST_FONT = 6.5
WIDE = 1.2  # [rad] an axis over more than this has ticks at multiples of pi/4
WIDTH = 95  # letters of a line of a title
COMPACT = (5.0, 4.0)
"""Figures, and panels of the user's, below this width or height [inches] are `compact`."""
COLOURS = ("#1f77b4", "#d95f02", "#1b9e77", "#b3258f", "#8c6d1f", "#666666", "#e7298a", "#5254a3")
"""Colours of curves in one panel."""
DASHES: tuple[Any, ...] = (
    "-",
    (0, (6, 2)),
    (0, (2, 1.5)),
    (0, (6, 2, 1, 2)),
    (0, (6, 2, 1, 2, 1, 2)),
)
"""Line styles of curves in one panel, so that they do not differ by colour alone.

Five has no factor in common with the number of colours."""

RC: dict[str, Any] = {
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "legend.frameon": False,
    "legend.columnspacing": 1.5,
    "lines.linewidth": 1.0,
    "agg.path.chunksize": 20000,
    "svg.hashsalt": "tippetop",  # the same picture has the same bytes
}
LINES = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
PAPERS = ("figure.facecolor", "axes.facecolor", "savefig.facecolor")


def ink() -> Ink:
    """Return the colours of the current figure."""
    return _setting.get().ink


def users_panel() -> Axes | None:
    """Return the panel of the user's figure to draw in; None if the figure is ours."""
    return _setting.get().panel


class ShownFigure(Figure):
    """A figure that a notebook shows, whether pyplot was imported or not."""

    def _repr_png_(self) -> bytes:
        """Return the figure as PNG; notebooks call this."""
        memory = BytesIO()
        self.savefig(memory, format="png", dpi=100)
        return memory.getvalue()


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of the requested size, or of these [inches] if none was requested."""
    fig = ShownFigure(figsize=_setting.get().size or (width, height), layout="constrained")
    FigureCanvasAgg(fig)
    return fig


def panel(width: float, height: float) -> Axes:
    """Return the panel to draw in: the user's, or the only one of a new `figure`."""
    return users_panel() or figure(width, height).subplots()


def panels_over_time(below: float) -> list[Axes]:
    """Return the panel to draw in, and a second one below it if there is room; both over time.

    The second panel has `below` quarters of the height of the first; 0: only the first is returned.
    In a panel of the user's and in a compact figure there is no room.
    """
    if users_panel() is None and below and not compact():
        panels = list(figure(10, 6.4).subplots(2, sharex=True, height_ratios=(4, below)))
    else:
        panels = [panel(10, 5.0)]
    panels[-1].set_xlabel("time t (s)")
    return panels


def ticks_of_inclination(ax: Axes) -> None:
    """Set ticks at quarters of pi where the curves extend over much of 0 to pi."""
    low, high = ax.dataLim.intervaly
    if low > -0.2 and high < np.pi + 0.2 and high - low > WIDE:
        ax.set_yticks(np.arange(5) * np.pi / 4, ["0", "π/4", "π/2", "3π/4", "π"])


def ticks_in_joules(axis: Any) -> None:
    """Label an axis (`ax.xaxis` or `ax.yaxis`) of energies [J] with prefixed units, such as mJ."""
    axis.set_major_formatter(EngFormatter("J"))


def mark_ends(axes: Any, *path: np.ndarray) -> None:
    """Draw the first and the last finite point of a path: a full circle, an open diamond.

    `path` is an array for each axis of the panel, (n,); its last numbers are NaN if the body has
    left its sphere, and the label differs then.
    """
    colours = ink()
    known = np.flatnonzero(np.isfinite(sum(path)))
    last = "its end" if known.max(initial=0) == len(path[0]) - 1 else "last on its sphere"
    ends = (known[:1], "o", "its start", colours.mark), (known[-1:], "D", last, colours.paper)
    for at, style, words, face in ends:
        place = (part[at] for part in path)
        axes.plot(*place, style, color=colours.mark, mfc=face, ms=6, zorder=6, label=words)


def legend(
    ax: Axes, place: str, ncols: int = 1, handles: list[Any] | None = None, **options: Any
) -> None:
    """Draw a legend of all panels: outside of them at `place`, or inside a panel of the user's.

    It is no wider than the figure: it has fewer columns than `ncols`, and then broken lines.
    Without `handles`, all labelled curves and marks are its entries, one for each label; matplotlib
    leaves out labels that begin with an underscore. A figure may have one legend at each `place`.
    """
    whole: Any = ax.get_figure(root=True)
    is_ours = users_panel() is None
    shown = whole.axes if is_ours else [ax]
    if not handles:
        handles = [handle for axes in shown for handle in axes.get_legend_handles_labels()[0]]
    entries = {str(handle.get_label()): handle for handle in handles}
    if not entries:
        return
    if not is_ours:
        ax.legend(entries.values(), entries, **options)
        return
    # about 17 letters of a legend are an inch wide; the line before a label takes the room of 6
    room = int(17 * whole.get_figwidth() * FONT / mpl.rcParams["font.size"])
    labels = [broken(label, room * 4 // 5) for label in entries]
    # formulas are shorter than their TeX
    lines = [re.sub(r"\\\w+|[${}]", "", line) for label in labels for line in label.splitlines()]
    longest = max(map(len, lines))
    columns = max(1, min(ncols, room // (longest + 6)))
    whole.legend(entries.values(), labels, loc=f"outside {place}", ncols=columns, **options)


def broken(words: str, letters: int) -> str:
    """Break a label between words into lines, but not within a formula or before a unit."""
    kept = re.sub(
        r"\$[^$]*\$| = [^,]*", lambda part: part[0].replace(" ", "\N{NO-BREAK SPACE}"), words
    )
    lines = textwrap.wrap(kept, letters, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


def _letters() -> int:
    """Return the number of letters in a line of a title, for the requested size: nine an inch."""
    size = _setting.get().size
    if size is None:
        return WIDTH
    return max(20, min(WIDTH, int(9.0 * size[0] * FONT / mpl.rcParams["font.size"])))


def compact() -> bool:
    """Return whether the requested size, or that of the user's panel, is below COMPACT.

    Then titles and labels are short, and notes and further panels are left out; `well` keeps every
    third panel. Legends stay. Without a requested size a figure of ours is not compact.
    """
    size = _setting.get().size
    return size is not None and (size[0] < COMPACT[0] or size[1] < COMPACT[1])


def draw_curves(ax: Axes, curves: Sequence[Curve], **style: Any) -> None:
    """Draw curves, each with its label, times and values, thinned; the first ones are wider."""
    looks = zip(itertools.cycle(COLOURS), itertools.cycle(DASHES))
    for i, ((label, *curve), (color, dashes)) in enumerate(zip(curves, looks, strict=False)):
        width = 1.6 - 0.8 * i / len(curves)  # the first curves can be seen below the last
        ax.plot(*thinned(*curve), color=color, ls=dashes, lw=width, label=label, **style)


def heading(*lines: str) -> str:
    """Return a title whose lines fit the figure.

    A compact figure has only the first line, up to its first colon.
    """
    shown = [lines[0].partition(":")[0]] if compact() else filter(None, lines)
    return "\n".join(broken(line, _letters()) for line in shown)


def _letter_sizes(width: float) -> dict[str, Any]:
    """Return the settings of matplotlib for letters [points] in a figure of a width [inches]."""
    size = max(LEAST_FONT, FONT * min(1.0, 0.4 + 0.6 * width / FONT_WIDTH))
    return {
        "font.size": size,
        "axes.titlesize": 1.1 * size,
        "figure.titlesize": 1.1 * size,
        "legend.fontsize": 0.9 * size,
    }


def literal(text: str) -> str:
    """Return a text in which dollars do not begin formulas."""
    return text.replace("$", r"\$")


def as_given(text: str) -> str:
    """Return a text of the user with its formulas, or a literal text if they are invalid."""
    try:
        for line in text.splitlines():
            MathTextParser("path").parse(line)
    except ValueError:
        return literal(text)
    return text


@contextmanager
def styled(
    *, dark: bool = False, size: tuple[float, float] | None = None, ax: Any = None
) -> Iterator[None]:
    """Draw in our style, whatever the user's settings are, at this size [inches].

    A panel of the user's figure, `ax`, keeps the user's settings; its own size replaces `size`, and
    decides whether it is `compact`.
    """
    colours = DARK if dark else LIGHT
    given = RC | _letter_sizes(size[0] if size else FONT_WIDTH) | {"grid.color": colours.grid}
    if dark:
        given |= dict.fromkeys(LINES, "#d5dae0") | dict.fromkeys(PAPERS, colours.paper)
    if ax is not None:
        size = tuple(ax.get_window_extent().size / ax.get_figure(root=True).dpi)
    token = _setting.set(Setting(colours, size, ax))
    try:
        with mpl.rc_context(dict(mpl.rcParamsDefault) | given if ax is None else {}):  # type: ignore[arg-type]
            yield
    finally:
        _setting.reset(token)

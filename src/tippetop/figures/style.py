"""The common style of the figures: colours on white and on black, empty panels, legends, and how one is saved."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..store.files import replacing, writing


class Ink(NamedTuple):
    """The colours of a figure: of a run, of what lies above and below, of what is beside the point, of an alarm; of
    marks, of grids, of the paper; and of the phases of a contact, for each a body's and a stem's."""

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
        "flight": ("#1e2d47", "#1e2d47"),
        "both": ("#35264a", "#35264a"),
    },
    "#c4a5ff",
)  # fmt: skip
RUN, UPPER, LOWER, QUIET, ALARM = LIGHT[:5]
_ink: ContextVar[Ink] = ContextVar("ink", default=LIGHT)

RC: dict[str, Any] = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "agg.path.chunksize": 20000,
    "svg.hashsalt": "tippetop",  # the same picture has the same bytes
}


def ink() -> Ink:
    """The colours of the figure that is being drawn."""
    return _ink.get()


class ShownFigure(Figure):
    """A figure that a notebook shows, whether pyplot was imported or not."""

    def _repr_png_(self) -> bytes:
        memory = BytesIO()
        self.savefig(memory, format="png", dpi=100)
        return memory.getvalue()


def figure(width: float = 9.0, height: float = 5.0, **options: Any) -> Figure:
    """An empty figure, inches, with room managed by matplotlib."""
    fig = ShownFigure(figsize=(width, height), layout="constrained", **options)
    FigureCanvasAgg(fig)
    return fig


def panel(ax: Axes | None, width: float = 9.0, height: float = 5.0) -> Axes:
    """The panel to draw in: the one that is given, or the only one of a new figure."""
    return figure(width, height).subplots() if ax is None else ax


def legend(ax: Axes, place: str, *, own: bool, **options: Any) -> None:
    """A legend of what is drawn in a panel: outside of it at `place`, if the figure is our own; else in it."""
    if not options.get("handles") and not ax.get_legend_handles_labels()[1]:
        return
    if own:
        whole: Any = ax.get_figure(root=True)
        whole.legend(loc=f"outside {place}", **({"fontsize": 9} | options))
    else:
        ax.legend(**({"fontsize": 8} | {name: value for name, value in options.items() if name != "ncols"}))


@contextmanager
def styled(*, dark: bool = False) -> Iterator[None]:
    """A block in which figures are made in our style, whatever the user's own settings are."""
    colours = DARK if dark else LIGHT
    own = {"grid.color": colours.grid}
    if dark:
        lines = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
        own |= dict.fromkeys(lines, "#d5dae0") | dict.fromkeys(
            ("figure.facecolor", "axes.facecolor", "savefig.facecolor"), colours.paper
        )
    token = _ink.set(colours)
    try:
        with mpl.rc_context(dict(mpl.rcParamsDefault) | RC | own):  # type: ignore[arg-type]
            yield
    finally:
        _ink.reset(token)


def save(fig: Figure, path: Path, *, dpi: float = 150, overwrite: bool = False) -> None:
    """Writes a figure whole or not at all; the ending of `path` names the format.

    Raises StoreError: the disk, or there is a file already, unless it may be overwritten.
    """
    path = Path(path)
    with writing(path), replacing(path, overwrite=overwrite) as scratch:
        ending = path.suffix.removeprefix(".").lower()
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(ending)
        fig.savefig(scratch, dpi=dpi, format=ending, facecolor=fig.get_facecolor(), metadata=undated)

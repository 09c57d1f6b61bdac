"""The common style of the figures, and how one is saved."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..store.files import replacing, writing


RUN, UPPER, LOWER, QUIET, ALARM = "#1f3b57", "#c2410c", "#0f766e", "#8a94a0", "#b91c1c"
RC: dict[str, Any] = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "agg.path.chunksize": 20000,
}


def figure(width: float = 9.0, height: float = 5.0, **options: Any) -> Figure:
    """An empty figure, inches, with room managed by matplotlib."""
    fig = Figure(figsize=(width, height), layout="constrained", **options)
    FigureCanvasAgg(fig)
    return fig


def styled() -> Any:
    """A block in which figures are made in our style, whatever the user's own settings are."""
    return mpl.rc_context(dict(mpl.rcParamsDefault) | RC)  # type: ignore[arg-type]


def save(fig: Figure, path: Path) -> None:
    """Writes a figure whole or not at all; the ending of `path` names the format. Raises StoreError."""
    path = Path(path)
    with writing(path), replacing(path) as scratch:
        fig.savefig(scratch, dpi=150, format=path.suffix.removeprefix(".").lower())

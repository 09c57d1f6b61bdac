"""The figures of a run: run.plot("theta") is a Figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import finite, flag, in_python, instance, path_of, seconds
from ..errors import InputError, refuse_without
from ..figures import catalogue, drawing
from ..figures.catalogue import PLAIN, Look


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .finished_run import Run


def plot(
    run: Run,
    kind: str = "theta",
    path: str | Path | None = None,
    *,
    ax: Axes | None = None,
    others: Sequence[Run] = (),
    start: float | str | None = None,
    until: float | str | None = None,
    title: str | None = None,
    size: tuple[float, float] | None = None,
    dpi: float = 150,
    dark: bool = False,
    overwrite: bool = False,
) -> Figure:
    """Draw the run.

    Parameters
    ----------
    kind : str
        theta, normal-force, drift, growth, sphere, energy, states, band, surface, potential
        or film.
    path : path-like, optional
        A file to write as well; its ending (.png, .svg, .pdf) names the format.
    ax : matplotlib.axes.Axes, optional
        Where to draw; its figure keeps its own settings.
    others : sequence of Run, optional
        Other runs to draw in the same panel: theta, normal-force, drift, growth or energy.
    overwrite : bool
        Whether an existing file is replaced.
    start, until : float, optional
        Draw this part of the run only [s].
    title : str, optional
        Instead of the figure's own title.
    size : (float, float), optional
        Width and height [inches].
    dpi : float
        Dots per inch of a PNG; 150 by default.
    dark : bool
        Whether to draw light on dark.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        If the figure does not exist, or the run lacks its columns.
    StoreError
        If the file cannot be written, or exists already.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import tippetop as tt
    >>> run = tt.run("inverting", until=8.0)
    >>> figure, (above, below) = plt.subplots(2)
    >>> run.plot("theta", ax=above, start=2.0, until=7.0)
    >>> run.plot("energy", ax=below)
    """
    from ..figures.window import in_window

    refuse_without("matplotlib")
    flag("overwrite", overwrite)
    catalogue.check_kind(kind)
    if path is not None:
        catalogue.check_format(path_of("path", path))
    look = Look(title, size, dpi, dark)
    instance("title", title, str | None, "text")
    instance("size", size, list | tuple | None, "two numbers")
    if size is not None and len([finite("size", side) for side in size]) != 2:
        raise InputError(f"`size` must be two numbers, but is {size!r:.60}.")
    finite("dpi", dpi)
    flag("dark", dark)
    catalogue.check_look(look)
    if ax is not None and not hasattr(ax, "get_figure"):
        raise InputError(f"`ax` must be Axes of matplotlib, but is {ax!r:.60}.")
    window = seconds("start", start), seconds("until", until)
    runs = [run, *(others if isinstance(others, list | tuple) else [others])]
    if not all(hasattr(each, "_for_figures") for each in runs):
        raise InputError(f"`others` must be a list of Runs, but is {others!r:.60}.")
    parts = [in_window(each._for_figures(kind, window), each.attributes, *window) for each in runs]
    if len(runs) > 1:
        names = [
            Path(getattr(each, "path", f"run {number}")).stem for number, each in enumerate(runs, 1)
        ]
        tables = [(groups["trajectory"], attrs) for groups, attrs in parts]
        drawn = drawing.several(kind, tables, names, look, ax)
    else:
        drawn = drawing.axes_of(kind, *parts[0], look, ax)
    return saved(drawn.get_figure(root=True), path, overwrite, look)


def saved(figure: Any, path: str | Path | None, overwrite: bool, look: Look = PLAIN) -> Any:
    """Return a figure, which is written where a path is given.

    Every `plot` of a result ends with it; `overwrite` and `look` are for the file. Raises
    InputError, StoreError.
    """
    if path is not None:
        place = catalogue.check_format(path_of("path", path))
        with in_python():
            drawing.write(figure, place, look, overwrite=overwrite)
    return figure

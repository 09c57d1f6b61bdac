"""The figures of a run as an object: run.plot("theta") is a Figure, run.plot.theta(ax=ax) draws
into Axes.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import finite, flag, instance, path_of, seconds
from ..errors import InputError
from ..figures import catalogue, drawing
from ..figures.catalogue import FIGURES, Look


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .run import Run


class Plots:
    """The figures of a run.

    Each kind of figure is a method too, which takes and returns Axes:
    `run.plot.normal_force(ax=ax)`. Without `ax` it makes a figure of its own. Options are those of
    a call.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import tippetop as tt
    >>> run = tt.run("inverting", until=8.0)
    >>> figure, (above, below) = plt.subplots(2)
    >>> run.plot.theta(ax=above, start=2.0, until=7.0)
    >>> run.plot.energy(ax=below)
    """

    def __init__(self, run: "Run"):
        self._run = run

    def __call__(
        self,
        kind: str = "theta",
        path: str | Path | None = None,
        *,
        ax: "Axes | None" = None,
        beside: "Sequence[Run]" = (),
        overwrite: bool = False,
        **options: Any,
    ) -> "Figure":
        """Draws the run.

        Parameters
        ----------
        kind : str
            theta, normal-force, drift, growth, sphere, energy, states, band, surface, potential,
            inversion or film.
        path : path-like, optional
            A file to write as well; its ending (.png, .svg, .pdf) names the format.
        ax : matplotlib.axes.Axes, optional
            Where to draw; its figure keeps its own settings.
        beside : sequence of Run, optional
            Other runs to draw in the same panel: theta, normal-force, drift, growth or energy.
        overwrite : bool
            Whether a file that is there is replaced.
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
            If there is no such figure, or the run has not what it shows.
        StoreError
            If the file cannot be written, or is there already.
        """
        flag("overwrite", overwrite)
        file = None if path is None else path_of("path", path)
        kind = kind.replace("_", "-") if isinstance(kind, str) else kind  # as the methods are named
        catalogue.check_kind(kind)
        if file is not None:
            catalogue.check_format(file)
        look = _look(options)
        figure = self._axes(kind, ax, look, options, beside).get_figure(root=True)
        if file is not None:
            drawing.write(figure, file, look, overwrite=overwrite)
        return figure

    def __getattr__(self, name: str) -> "Callable[..., Axes]":
        kind = name.replace("_", "-")
        if kind not in FIGURES:
            raise AttributeError(f"a run has no figure `{name}`: it has {', '.join(dir(self))}")

        def figure(
            ax: "Axes | None" = None, *, beside: "Sequence[Run]" = (), **options: Any
        ) -> "Axes":
            return self._axes(kind, ax, _look(options), options, beside)

        figure.__name__, figure.__doc__ = (
            name,
            f"{FIGURES[kind].shows}. Takes and returns Axes; options as of a call.",
        )
        return figure

    def __dir__(self) -> list[str]:
        return [kind.replace("-", "_") for kind in FIGURES]

    def _axes(
        self,
        kind: str,
        ax: "Axes | None",
        look: Look,
        options: dict[str, Any],
        beside: "Sequence[Run]",
    ) -> Any:
        """Draws; `options` are what is left of them: the window."""
        if ax is not None and not hasattr(ax, "get_figure"):
            raise InputError(f"`ax` must be Axes of matplotlib, but is {ax!r:.60}.")
        start, until = options.pop("start", None), options.pop("until", None)
        window = seconds("start", start), seconds("until", until)
        if options:
            raise InputError(f"a figure has no option `{next(iter(options))}`.")
        from ..figures.window import in_window
        from .run import Run

        others: Any = [beside] if isinstance(beside, Run) else beside
        if not isinstance(others, list | tuple) or not all(
            isinstance(other, Run) for other in others
        ):
            raise InputError(f"`beside` must be a list of Runs, but is {beside!r:.60}.")
        runs = [self._run, *others]
        parts = [in_window(run._for_figures(kind, window), run.attributes, *window) for run in runs]
        if others:
            names = [f"run {i + 1}" for i in range(len(runs))]
            return drawing.several(
                kind, [(groups["trajectory"], attrs) for groups, attrs in parts], names, look, ax
            )
        return drawing.axes_of(kind, *parts[0], look, ax)


def _look(options: dict[str, Any]) -> Look:
    """How a figure shall look; takes what says so from the options. Raises InputError."""
    title, size = options.pop("title", None), options.pop("size", None)
    instance("title", title, str | None, "text")
    if size is not None:
        try:
            width, height = size
        except (TypeError, ValueError):
            raise InputError(f"`size` must be two numbers, but is {size!r:.60}.") from None
        size = (float(finite("size", width)), float(finite("size", height)))
    dpi, dark = finite("dpi", options.pop("dpi", 150)), options.pop("dark", False)
    flag("dark", dark)
    look = Look(title, size, float(dpi), dark)
    catalogue.check_look(look)
    return look

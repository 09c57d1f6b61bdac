"""The figures of a run: run.plot("theta") is a Figure, run.plot.theta(ax=ax) draws into Axes."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import finite, flag, in_python, instance, path_of, seconds
from ..errors import InputError
from ..figures import catalogue, drawing
from ..figures.catalogue import FIGURES, Look


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .finished_run import Run


class Plots:
    """The figures of a run.

    Each kind of figure is a method too, which takes and returns Axes:
    `run.plot.normal_force(ax=ax)`. Without `ax` it makes a new figure. Options are those of a
    call.

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
        others: "Sequence[Run]" = (),
        overwrite: bool = False,
        **options: Any,
    ) -> "Figure":
        """Draw the run.

        Parameters
        ----------
        kind : str
            theta, normal-force, drift, growth, sphere, energy, states, band, surface, potential,
            inversion or film.
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
        """
        flag("overwrite", overwrite)
        kind = kind.replace("_", "-") if isinstance(kind, str) else kind  # as the methods are named
        catalogue.check_kind(kind)
        file = None if path is None else path_of("path", path)
        if file is not None:
            catalogue.check_format(file)
        look = _look(options)
        figure = self._axes(kind, ax, look, others, **options).get_figure(root=True)
        if file is not None:
            with in_python():
                drawing.write(figure, file, look, overwrite=overwrite)
        return figure

    def __getattr__(self, name: str) -> "Callable[..., Axes]":
        kind = name.replace("_", "-")
        if kind not in FIGURES:
            raise AttributeError(f"a run has no figure `{name}`: it has {', '.join(dir(self))}")

        def figure(
            ax: "Axes | None" = None, *, others: "Sequence[Run]" = (), **options: Any
        ) -> "Axes":
            return self._axes(kind, ax, _look(options), others, **options)

        shows = FIGURES[kind].shows
        figure.__name__, figure.__doc__ = name, f"{shows}. Takes and returns Axes."
        return figure

    def __dir__(self) -> list[str]:
        return [kind.replace("-", "_") for kind in FIGURES]

    def _axes(
        self, kind: str, ax: Any, look: Look, others: Any, start: Any = None, until: Any = None
    ) -> Any:
        """Draw a part of the run."""
        from ..figures.window import in_window

        if ax is not None and not hasattr(ax, "get_figure"):
            raise InputError(f"`ax` must be Axes of matplotlib, but is {ax!r:.60}.")
        window = seconds("start", start), seconds("until", until)
        runs = others if isinstance(others, list | tuple) else [others]
        if not all(hasattr(run, "_for_figures") for run in runs):
            raise InputError(f"`others` must be a list of Runs, but is {others!r:.60}.")
        parts = [
            in_window(run._for_figures(kind, window), run.attributes, *window)
            for run in (self._run, *runs)
        ]
        if not runs:
            return drawing.axes_of(kind, *parts[0], look, ax)
        names = [
            Path(getattr(run, "path", f"run {number}")).stem
            for number, run in enumerate((self._run, *runs), 1)
        ]
        tables = [(groups["trajectory"], attrs) for groups, attrs in parts]
        return drawing.several(kind, tables, names, look, ax)


def _look(options: dict[str, Any]) -> Look:
    """Return the look of a figure; its options are removed from the others. Raises InputError."""
    given = {name: options.pop(name) for name in Look.__annotations__ if name in options}
    if unknown := sorted(options.keys() - {"start", "until"}):
        raise InputError(f"a figure has no option `{unknown[0]}`.")
    look = Look(**given)
    instance("title", look.title, str | None, "text")
    instance("size", look.size, list | tuple | None, "two numbers")
    for side in look.size or ():
        finite("size", side)
    finite("dpi", look.dpi)
    flag("dark", look.dark)
    catalogue.check_look(look)
    return look

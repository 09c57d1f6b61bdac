"""The figures of a run and of a sweep: what each shows, what it is made from and needs, and what draws it.

Here only are figures fed: a drawing imports nothing but the style, and takes what it is given.
Nothing is imported until a figure is drawn, so that `tippetop plot --help` can list the kinds at once.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class RunFigure:
    """A figure of a run: draw(*prepare(trajectory, events, attributes)); both are named module:function, and imported
    when the figure is drawn. Where the x axis is the time, the phases of the run's contact are shaded behind it."""

    shows: str  # one line for people
    draw: str
    prepare: str | None = None  # None: what is drawn is the run as it is
    needs: str = "time"  # the column of the trajectory without which there is nothing to show
    uses: tuple[str, ...] = ("theta",)  # the columns that it is made from, where the system has them; "integrals" and
    # "landscape" stand for those of the system
    drawn_for: str = ""  # the systems that have that column, in words
    over_time: bool = False  # whether the x axis of every panel is the time


OF_LANDSCAPES = ("theta", "phase", "landscape")
OF_DRIFT = ("integrals", "energy", "work", "axis", "ball")


def _of_tippe_tops(draw: str, shows: str) -> RunFigure:
    """A figure over the spinning states of a tippe top."""
    prepare = f"landscape.along_run:{draw.rpartition(':')[2]}"
    return RunFigure(shows, draw, prepare, needs="routh", uses=OF_LANDSCAPES, drawn_for="tippe tops")


FIGURES: dict[str, RunFigure] = {
    "theta": RunFigure("theta(t), turning angles, nutational band (default)", "figures.run:theta", over_time=True),
    "normal-force": RunFigure(
        "normal force g_n(t) in units of the weight",
        "figures.run:normal_force",
        needs="normal_force",
        uses=("normal_force",),
        drawn_for="systems with a normal force",
        over_time=True,
    ),
    "drift": RunFigure("relative change of what must be conserved", "figures.run:drift", uses=OF_DRIFT, over_time=True),
    "growth": RunFigure("growth of the worst drift with t, beside sqrt(t)", "figures.run:growth", uses=OF_DRIFT),
    "sphere": RunFigure(
        "path of the axis on the sphere", "figures.run:sphere", needs="axis", uses=("axis",), drawn_for="tops"
    ),
    "energy": RunFigure(
        "energy, modified energy, energy taken by friction",
        "figures.run:energy",
        uses=("energy", "modified_energy", "work", "phase"),
        over_time=True,
    ),
    "phase": _of_tippe_tops("figures.stability:phase", "asymptotic states over lambda, and the run among them"),
    "band": RunFigure(
        "turning angles that the main equation predicts",
        "figures.landscape:band",
        "landscape.along_run:band",
        uses=OF_LANDSCAPES,
    ),
    "surface": _of_tippe_tops("figures.landscape:surface", "the run on the minimal surface F(D, lambda)"),
    "potential": RunFigure(
        "the effective potential V(z) at six times",
        "figures.landscape:potential",
        "landscape.along_run:potential",
        uses=OF_LANDSCAPES,
    ),
    "inversion": _of_tippe_tops("figures.landscape:inversion", "the run on the section of F at its lambda"),
}
"""The figures of a run, by name."""

SWEEP_KINDS = {
    "class": "fate of each top over two axes (default)",
    "inversion": "time of inversion",
    "normal-force": "least normal force",
}
"""The figures of a sweep, and what each shows."""


def described() -> str:
    """What `plot --help` says of the kinds."""
    runs = "".join(f"\n- {name}: {figure.shows}" for name, figure in FIGURES.items())
    sweeps = "".join(f"\n- {name}: {shows}" for name, shows in SWEEP_KINDS.items())
    return f"Of a run:\n{runs}\n\nOf a sweep:\n{sweeps}\n\nA surface and a potential have one figure each."


def draw(kind: str, groups: dict[str, Any], attrs: dict[str, Any], path: Path) -> None:
    """Draws one kind of figure of a run to a file.

    Parameters
    ----------
    kind
        A name of `FIGURES`.
    groups
        trajectory and events, and phases and impacts where the run has them; Datasets or columns by name.
    attrs
        The root attributes of the run's store.
    path
        The file; its ending names the format.

    Raises
    ------
    InputError
        For another kind, and where the run lacks what the figure shows.
    StoreError
        Where the file cannot be written.
    """
    write(figure_of(kind, groups, attrs), path)


def figure_of(kind: str, groups: dict[str, Any], attrs: dict[str, Any]) -> Any:
    """One kind of figure of a run, a matplotlib Figure. Raises InputError if the run lacks what it shows."""
    from ..errors import InputError, a_system
    from .style import styled

    check_kind(kind)
    chosen = FIGURES[kind]
    _refuse_left_out(kind, groups["trajectory"], attrs)
    if chosen.needs not in groups["trajectory"]:
        raise InputError([f"`{kind}` is drawn for {chosen.drawn_for} only; this is {a_system(attrs['system'])}."])
    if not len(groups["trajectory"]["time"].values):
        raise InputError([f"`{kind}` is drawn of rows, and this run keeps none: replay a part of it."])
    given: Any = (groups["trajectory"], groups["events"], attrs)
    if chosen.prepare is not None:
        from ..landscape import along_run

        given = _function(chosen.prepare)(*(along_run.table(group) for group in given[:2]), attrs)
    with styled():
        drawing = _function(chosen.draw)(*given)
        if chosen.over_time and "phases" in groups:
            _function("figures.phases:mark")(drawing, groups["phases"], groups["impacts"])
        return drawing


def _refuse_left_out(kind: str, trajectory: Any, attrs: dict[str, Any]) -> None:
    """Raises InputError if a figure uses columns that its system has and the run did not keep."""
    from ..columns import require
    from ..mechanics.systems import find
    from ..problem import column_names

    system = find(attrs["system"])
    if "columns" not in attrs["run"] or system is None:
        return
    has = {*column_names(system, system.forms[attrs["form"]], True, "double")}
    has |= {"phase", "ball"} if "contact" in attrs else set()
    uses = {*FIGURES[kind].uses} | {*(system.integrals if "integrals" in FIGURES[kind].uses else ())}
    if "landscape" in uses and system.landscape is not None:
        uses |= {*system.landscape.columns}
    require(sorted(uses & has), trajectory, f"what `{kind}` is drawn from")


def write(figure: Any, path: Path) -> None:
    """Writes a figure; the ending of `path` names the format. Raises StoreError."""
    from .style import save, styled

    with styled():
        save(figure, path)


def comparison(motions: Any, title: str) -> Any:
    """The figure of motions beside their reference, as `exchange.comparison` gives them."""
    from .comparison import comparison
    from .style import styled

    with styled():
        return comparison(motions, title)


def fit(*arguments: Any) -> Any:
    """The figure of a fit, as `figures.fit` takes it."""
    from .fit import fit
    from .style import styled

    with styled():
        return fit(*arguments)


def draw_sweep(kind: str, store: Path, path: Path) -> None:
    """Draws one kind of figure of a sweep to a file. Raises InputError, StoreError."""
    from ..sweeps import maps
    from . import sweep
    from .style import save, styled

    sweep_map = maps.make_map(store, kind)
    with styled():
        save(sweep.draw_map(sweep_map), path)


def check_kind(kind: str, known: Iterable[str] = FIGURES) -> None:
    """Raises InputError if there is no such figure."""
    from ..errors import InputError, suggestion

    if not isinstance(kind, str) or kind not in known:
        kind = str(kind)
        raise InputError(
            [f"the kind of figure must be one of {', '.join(known)}, but is `{kind}`.{suggestion(kind, known)}"]
        )


def check_format(path: Path) -> None:
    """Raises InputError if the ending of a path names no format of figures."""
    from matplotlib.backend_bases import FigureCanvasBase

    from ..errors import InputError

    formats = FigureCanvasBase.get_supported_filetypes()
    if path.suffix.removeprefix(".").lower() not in formats:
        raise InputError([f"`{path}` must end with the format of a figure, such as .png, .svg or .pdf, but does not."])


def _function(name: str) -> Any:
    """The function module:name of the package."""
    module, _, function = name.partition(":")
    return getattr(import_module(f"...{module}", __name__), function)

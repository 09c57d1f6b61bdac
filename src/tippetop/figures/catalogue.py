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
    """A figure of a run: draw(*prepare(trajectory, events, attributes), ax=ax), which gives the Axes; both are named
    module:function, and imported when the figure is drawn. Where the x axis is the time, the phases of the run's
    contact are shaded behind it."""

    shows: str  # one line for people
    draw: str
    prepare: str | None = None  # None: what is drawn is the run as it is
    needs: str = "time"  # the column of the trajectory without which there is nothing to show
    uses: tuple[str, ...] = ("theta",)  # the columns that it is made from, where the system has them; "integrals" and
    # "landscape" stand for those of the system
    drawn_for: str = ""  # the systems that have that column, in words
    over_time: bool = False  # whether the x axis of every panel is the time
    compares: bool = False  # whether several runs can be axes in one panel


@dataclass(frozen=True)
class Look:
    """How a figure looks: its title instead of its own, width and height [inches], dots per inch, light on dark."""

    title: str | None = None
    size: tuple[float, float] | None = None
    dpi: float = 150
    dark: bool = False


PLAIN = Look()


OF_LANDSCAPES = ("theta", "phase", "ball", "landscape")
OF_DRIFT = ("integrals", "energy", "work", "axis", "ball", "jellett_lost")


def _of_tippe_tops(draw: str, shows: str) -> RunFigure:
    """A figure over the spinning states of a tippe top."""
    prepare = f"landscape.along_run:{draw.rpartition(':')[2]}"
    return RunFigure(shows, draw, prepare, needs="routh", uses=OF_LANDSCAPES, drawn_for="tippe tops")


FIGURES: dict[str, RunFigure] = {
    "theta": RunFigure(
        "theta(t), turning angles, nutational band (default)", "figures.theta:theta", over_time=True, compares=True
    ),
    "normal-force": RunFigure(
        "normal force g_n(t) in units of the weight",
        "figures.energetics:normal_force",
        needs="normal_force",
        uses=("normal_force",),
        drawn_for="systems with a normal force",
        over_time=True,
        compares=True,
    ),
    "drift": RunFigure(
        "relative change of what must be conserved",
        "figures.conserved:drift",
        uses=OF_DRIFT,
        over_time=True,
        compares=True,
    ),
    "growth": RunFigure(
        "growth of the worst drift with t, beside sqrt(t)", "figures.conserved:growth", uses=OF_DRIFT, compares=True
    ),
    "sphere": RunFigure(
        "path of the axis on the sphere", "figures.sphere:sphere", needs="axis", uses=("axis",), drawn_for="tops"
    ),
    "energy": RunFigure(
        "energy, modified energy, energy taken by friction",
        "figures.energetics:energy",
        uses=("energy", "modified_energy", "work", "phase"),
        over_time=True,
        compares=True,
    ),
    "film": RunFigure(
        "eight poses of the body on one line, by their times",
        "figures.film:film",
        "runs.shape:with_shape",
        needs="orientation",
        uses=("theta", "axis", "orientation", "z"),
        drawn_for="runs that keep the orientation",
    ),
    "states": _of_tippe_tops(
        "figures.stability:states", "asymptotic states over lambda, and the run among them; also of a scenario"
    ),
    "band": RunFigure(
        "turning angles that the main equation predicts",
        "figures.landscape:band",
        "landscape.along_run:band",
        uses=OF_LANDSCAPES,
    ),
    "surface": _of_tippe_tops("figures.landscape:surface", "the run on the minimal surface F(D, lambda)"),
    "potential": RunFigure(
        "the effective potential V(z) at six times",
        "figures.potential:potential",
        "landscape.along_run:potential",
        uses=OF_LANDSCAPES,
    ),
    "inversion": _of_tippe_tops("figures.landscape:inversion", "the run on the section of F at its lambda"),
}
"""The figures of a run, by name."""
FORMER = {"phase": "states"}
"""Names that figures had."""

SWEEP_KINDS = {
    "class": "fate of each top over two axes (default)",
    "inversion": "time of inversion",
    "normal-force": "least normal force",
}
"""The figures of a sweep, and what each shows."""
ENDINGS = (".png", ".svg", ".pdf")
MOST_PIXELS = 20_000  # along a side


def described() -> str:
    """What `plot --help` says of the kinds."""
    runs = "".join(f"\n- {name}: {figure.shows}" for name, figure in FIGURES.items())
    several = ", ".join(name for name, figure in FIGURES.items() if figure.compares)
    sweeps = "".join(f"\n- {name}: {shows}" for name, shows in SWEEP_KINDS.items())
    return (
        f"Further runs, to be axes beside the first ({several}); and, last, the kind of figure.\n\nOf a run:\n{runs}"
        f"\n\nOf a sweep:\n{sweeps}\n\nA surface and a potential have one figure each."
    )


def kind_of(word: str) -> str:
    """The name of a kind of figure, by that name or by one that it had. Raises InputError."""
    check_kind(word, [*FIGURES, *FORMER])
    return FORMER.get(word, word)


def draw(
    kind: str,
    groups: dict[str, Any],
    attrs: dict[str, Any],
    path: Path,
    look: Look = PLAIN,
    *,
    overwrite: bool = False,
) -> None:
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
    look
        How it looks.
    overwrite
        Whether a file that is there is replaced.

    Raises
    ------
    InputError
        For another kind, and where the run lacks what the figure shows.
    StoreError
        Where the file cannot be written.
    """
    write(figure_of(kind, groups, attrs, look), path, look, overwrite=overwrite)


def figure_of(kind: str, groups: dict[str, Any], attrs: dict[str, Any], look: Look = PLAIN, ax: Any = None) -> Any:
    """One kind of figure of a run, a matplotlib Figure. Raises InputError if the run lacks what it shows.

    With `ax` it is drawn there, without the panels and legends that stand beside it.
    """
    return axes_of(kind, groups, attrs, look, ax).get_figure(root=True)


def axes_of(kind: str, groups: dict[str, Any], attrs: dict[str, Any], look: Look = PLAIN, ax: Any = None) -> Any:
    """As `figure_of`; gives the Axes, of several panels the first."""
    from ..errors import InputError, a_system
    from .style import styled
    from .window import handed_over

    kind = kind_of(kind)
    chosen = FIGURES[kind]
    _refuse_left_out(kind, groups["trajectory"], attrs)
    if chosen.needs not in groups["trajectory"]:
        raise InputError([f"`{kind}` is drawn for {chosen.drawn_for} only; this is {a_system(attrs['system'])}."])
    if not len(groups["trajectory"]["time"].values):
        raise InputError([f"`{kind}` is drawn of rows, and this run keeps none: replay a part of it."])
    if ax is not None and (kind == "surface") != (getattr(ax, "name", "") == "3d"):
        raise InputError([f"`ax` of `{kind}` must be {'in 3-D' if kind == 'surface' else 'flat'}, but is not."])
    attrs = with_units(attrs) | {"handed_over": handed_over(groups)}
    given: Any = (groups["trajectory"], groups["events"], attrs)
    if chosen.prepare is not None:
        from ..landscape import along_run

        given = _function(chosen.prepare)(*(along_run.table(group) for group in given[:2]), attrs)
    with styled(dark=look.dark):
        axes = _function(chosen.draw)(*given, ax=ax)
        if chosen.over_time and "phases" in groups:
            panels = [axes] if ax is not None else list(axes.get_figure(root=True).axes)
            _function("figures.phases:mark")(panels, groups["phases"], groups["impacts"], own=ax is None)
        _finish(axes, look, own=ax is None)
        return axes


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
    require(sorted(uses & has), trajectory, f"the figure `{kind}`")


def several(
    kind: str, runs: list[tuple[Any, dict[str, Any]]], names: list[str], look: Look = PLAIN, ax: Any = None
) -> Any:
    """The same curve of several runs in one panel, the Axes; `runs` are trajectories and root attributes, `names` what
    they are called where nothing else tells them apart. Raises InputError."""
    from ..errors import InputError, a_system
    from .overlay import overlay
    from .style import styled

    kind = kind_of(kind)
    if not FIGURES[kind].compares:
        known = ", ".join(name for name, figure in FIGURES.items() if figure.compares)
        raise InputError([f"several runs are drawn together as {known}; `{kind}` is drawn of one."])
    for trajectory, attrs in runs:
        _refuse_left_out(kind, trajectory, attrs)
        if FIGURES[kind].needs not in trajectory:
            words = FIGURES[kind].drawn_for
            raise InputError([f"`{kind}` is drawn for {words} only; one of these is {a_system(attrs['system'])}."])
        if not len(trajectory["time"].values):
            raise InputError([f"`{kind}` is drawn of rows, and one of these runs keeps none: replay a part of it."])
    with styled(dark=look.dark):
        axes = overlay(kind, [(trajectory, with_units(attrs)) for trajectory, attrs in runs], names, ax)
        _finish(axes, look, own=ax is None)
        return axes


def states_of(system: str, parameters: dict[str, float], lam: float, look: Look = PLAIN, title: str = "") -> Any:
    """The diagram of the asymptotic states of a body with the |lambda| of its start [kg m^3/s]. Raises
    InputError for a system that has none."""
    from ..landscape import along_run

    branches, marks = along_run.diagram(system, parameters, lam)
    return composed("figures.stability:states", (branches, marks | {"|λ| of the start": abs(lam)}, title), look)


def with_units(attrs: dict[str, Any]) -> dict[str, Any]:
    """The attributes of a run, with the units of the numbers of its friction law among its units."""
    from ..mechanics.friction import CONTENSOU
    from ..mechanics.systems import find

    system, name = find(attrs["system"]), attrs.get("friction", {}).get("law", "")
    law = (system.laws if system is not None else {}).get(name, {"contensou": CONTENSOU}.get(name))
    units = {name: parameter.unit.symbol for name, parameter in law.parameters.items()} if law is not None else {}
    return attrs | {"units": attrs.get("units", {}) | units}


def _finish(axes: Any, look: Look, *, own: bool) -> None:
    """Gives a figure its title and size; a panel of somebody else's figure its title."""
    figure = axes.get_figure(root=True)
    if look.title is not None:
        if own and figure.get_suptitle():
            figure.suptitle(look.title, x=0.01, ha="left", fontsize=11)
        else:
            axes.set_title(look.title)
    if own and look.size is not None:
        figure.set_size_inches(*look.size)


def write(figure: Any, path: Path, look: Look = PLAIN, *, overwrite: bool = False) -> None:
    """Writes a figure; the ending of `path` names the format. Raises StoreError."""
    from .style import save, styled

    with styled(dark=look.dark):
        save(figure, path, dpi=look.dpi, overwrite=overwrite)


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


def figure_of_sweep(kind: str, store: Path, look: Look = PLAIN) -> Any:
    """One kind of figure of a sweep. Raises InputError, StoreError."""
    from ..sweeps import maps

    return composed("figures.sweep:draw_map", (maps.make_map(store, kind),), look)


def composed(draw: str, given: tuple[Any, ...], look: Look = PLAIN) -> Any:
    """The figure that module:function draws of what it is given."""
    from .style import styled

    with styled(dark=look.dark):
        axes = _function(draw)(*given)
        _finish(axes, look, own=True)
    return axes.get_figure(root=True)


def check_kind(kind: str, known: Iterable[str] = FIGURES) -> None:
    """Raises InputError if there is no such figure."""
    from ..errors import InputError, suggestion

    known = list(known)
    if not isinstance(kind, str) or kind not in known:
        kind = str(kind)
        listed = ", ".join(name for name in known if name not in FORMER)
        raise InputError([f"the kind of figure must be one of {listed}, but is `{kind}`.{suggestion(kind, known)}"])


def check_format(path: Path) -> None:
    """Raises InputError if the ending of a path names no format of figures."""
    from ..errors import InputError

    if path.suffix.lower() not in ENDINGS:
        raise InputError([f"`{path}` must end with the format of a figure: .png, .svg or .pdf, but does not."])


def check_look(look: Look) -> None:
    """Raises InputError if a figure could not look so."""
    from ..errors import InputError

    if not 10 <= look.dpi <= 2400:
        raise InputError([f"`dpi` must be between 10 and 2400, but is {look.dpi:g}."])
    if look.size is not None and not all(1 <= side <= MOST_PIXELS / look.dpi for side in look.size):
        given = " x ".join(f"{side:g}" for side in look.size)
        most = MOST_PIXELS / look.dpi
        raise InputError([f"`size` must be between 1 and {most:g} inches at {look.dpi:g} dpi, but is {given}."])


def _function(name: str) -> Any:
    """The function module:name of the package."""
    module, _, function = name.partition(":")
    return getattr(import_module(f"...{module}", __name__), function)

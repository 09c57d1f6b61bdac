"""Draws the figures of the catalogue, of a run, of several and of a sweep.

Here only are figures fed: a drawing imports nothing but the style, and takes what it is given.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from .catalogue import FIGURES, PLAIN, Look, kind_of


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
        raise InputError([f"`{kind}` is drawn of rows, and this run has none: replay a part of it, or resume it."])
    if ax is not None and (kind == "surface") != (getattr(ax, "name", "") == "3d"):
        raise InputError([f"`ax` of `{kind}` must be {'in 3-D' if kind == 'surface' else 'flat'}, but is not."])
    attrs = with_units(attrs) | {"handed_over": handed_over(groups)}
    given: Any = (groups["trajectory"], groups["events"], attrs)
    if chosen.prepare is not None:
        from ..landscape import along_run

        given = _function(chosen.prepare)(*(along_run.table(group) for group in given[:2]), attrs)
    with styled(dark=look.dark, size=look.size, ax=ax):
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
    from .style import literal, styled

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
            raise InputError([f"`{kind}` is drawn of rows, and one of these runs has none: replay or resume it."])
    with styled(dark=look.dark, size=look.size, ax=ax):
        axes = overlay(kind, [(run, with_units(attrs)) for run, attrs in runs], [*map(literal, names)], ax)
        _finish(axes, look, own=ax is None)
        return axes


def states_of(system: str, parameters: dict[str, float], lam: float, look: Look = PLAIN, title: str = "") -> Any:
    """The diagram of the asymptotic states of a body with the |lambda| of its start [kg m^3/s]. Raises
    InputError for a system that has none."""
    from ..landscape import along_run
    from .style import literal

    branches, marks = along_run.diagram(system, parameters, lam)
    return composed(
        "figures.stability:states", (branches, marks | {"|λ| of the start": abs(lam)}, literal(title)), look
    )


def with_units(attrs: dict[str, Any]) -> dict[str, Any]:
    """The attributes of a run, with the units of the numbers of its friction law among its units."""
    from ..mechanics.systems import find

    system, friction = find(attrs["system"]), attrs.get("friction", {})
    law = system.laws.get(friction.get("law", "")) if system is not None else None
    rules = law.given(friction).parameters if law is not None else {}
    units = {name: parameter.unit.symbol for name, parameter in rules.items()}
    return attrs | {"units": attrs.get("units", {}) | units}


def _finish(axes: Any, look: Look, *, own: bool) -> None:
    """Gives a figure its title; a panel of somebody else's figure too."""
    from ..errors import InputError
    from .style import as_given

    figure = axes.get_figure(root=True)
    if look.title is not None:
        if any("\ud800" <= letter <= "\udfff" for letter in look.title):  # bytes of a command line that are no text
            raise InputError([f"the title must be text in UTF-8, but is {look.title!r}."])
        if own and figure.get_suptitle():
            figure.suptitle(as_given(look.title), x=0.01, ha="left")
        else:
            axes.set_title(as_given(look.title))


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

    with styled(dark=look.dark, size=look.size):
        axes = _function(draw)(*given)
        _finish(axes, look, own=True)
    return axes.get_figure(root=True)


def _function(name: str) -> Any:
    """The function module:name of the package."""
    module, _, function = name.partition(":")
    return getattr(import_module(f"...{module}", __name__), function)

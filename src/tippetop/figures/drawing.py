"""Draw the figures of the catalogue: of a run, of several runs and of a sweep.

Only this module passes data to figures: a drawing imports nothing but the style.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..columns import symbol
from ..errors import InputError, a_system
from .catalogue import FIGURES, PLAIN, Look, check_kind


def _drawings() -> dict[str, Callable]:
    """Return the function for each kind of figure of a run; this imports matplotlib."""
    from . import conservation, energetics, film, landscape_figures, sphere, stability, theta, well

    return {
        "theta": theta.theta,
        "normal-force": energetics.normal_force,
        "drift": conservation.drift,
        "growth": conservation.growth,
        "sphere": sphere.sphere,
        "energy": energetics.energy,
        "film": film.film,
        "states": stability.states,
        "band": landscape_figures.band,
        "surface": landscape_figures.surface,
        "potential": well.potential,
    }


def figure_of(kind: str, groups: dict[str, Any], attrs: dict[str, Any], look: Look = PLAIN) -> Any:
    """Draw one kind of figure of a run; return the matplotlib Figure. See `axes_of`."""
    return axes_of(kind, groups, attrs, look).get_figure(root=True)


def axes_of(
    kind: str, groups: dict[str, Any], attrs: dict[str, Any], look: Look = PLAIN, ax: Any = None
) -> Any:
    """Draw one kind of figure of a run; return the Axes, of several panels the first.

    Parameters
    ----------
    kind
        A name of `FIGURES`.
    groups
        trajectory and events, and phases and impacts where the run has them; Datasets or columns by
        name.
    attrs
        The root attributes of the run's store.
    look
        How it looks.
    ax
        Axes to draw in, without further panels and without legends outside.

    Raises
    ------
    InputError
        For another kind, and where the run lacks what the figure shows.
    """
    from .style import styled
    from .window import datasets, handed_over

    check_kind(kind)
    groups = datasets(groups)
    chosen = FIGURES[kind]
    _refuse(kind, groups["trajectory"], attrs)
    if ax is not None and (kind == "surface") != (getattr(ax, "name", "") == "3d"):
        shape = "in 3-D" if kind == "surface" else "flat"
        raise InputError(f"`ax` of `{kind}` must be {shape}, but is not.")
    attrs = with_records(attrs) | {"handed_over": handed_over(groups)}
    given: Any = (groups["trajectory"], groups["events"], attrs)
    if kind == "film":
        from ..runs import shape as bodies

        body = bodies.shape(attrs) | {"axes": bodies.rotation}
        given = groups["trajectory"], attrs, body
    elif chosen.in_landscape:
        from ..landscape import run_landscape

        given = getattr(run_landscape, kind)(*given)
    with styled(dark=look.dark, size=look.size, ax=ax):
        axes = _drawings()[kind](*given, ax=ax)
        if chosen.over_time and "impacts" in groups:
            from .shading import mark

            panels = [axes] if ax is not None else axes.get_figure(root=True).axes
            mark(panels, groups["phases"], groups["impacts"])
        return _finished(axes, look)


def _refuse(kind: str, trajectory: Any, attrs: dict[str, Any]) -> None:
    """Raise InputError if a run lacks rows or columns that a figure uses."""
    from ..columns import require
    from ..mechanics.systems import find
    from ..runs.shape import columns_of

    chosen, system = FIGURES[kind], find(attrs["system"])
    if "columns" in attrs["run"] and system is not None:
        uses = {*chosen.uses, *(system.integrals if "integrals" in chosen.uses else ())}
        if "landscape" in uses and system.landscape is not None:
            uses |= {*system.landscape.columns}
        require(sorted(uses & columns_of(attrs)), trajectory, f"the figure `{kind}`")
    if chosen.needs not in trajectory:
        raise InputError(
            f"`{kind}` is drawn for {chosen.drawn_for} only; this is {a_system(attrs['system'])}."
        )
    if not trajectory["time"].size:
        raise InputError(
            f"`{kind}` is drawn of rows, but a run has none: replay a part of it, or resume it."
        )


def several(
    kind: str,
    runs: list[tuple[Any, dict[str, Any]]],
    names: list[str],
    look: Look = PLAIN,
    ax: Any = None,
) -> Any:
    """Draw the same curve of several runs in one panel; return the Axes.

    `runs` are trajectories and root attributes, `names` the labels of equal runs. Raises
    InputError.
    """
    from .overlay import overlay
    from .style import literal, styled

    check_kind(kind)
    if not FIGURES[kind].compares:
        known = ", ".join(name for name, figure in FIGURES.items() if figure.compares)
        raise InputError(f"several runs are drawn together as {known}; `{kind}` is drawn of one.")
    for trajectory, attrs in runs:
        _refuse(kind, trajectory, attrs)
    with styled(dark=look.dark, size=look.size, ax=ax):
        axes = overlay(
            kind, [(run, with_records(attrs)) for run, attrs in runs], [*map(literal, names)], ax
        )
        return _finished(axes, look)


def states_of(
    system: str, parameters: dict[str, float], lam: float, look: Look = PLAIN, title: str = ""
) -> Any:
    """Draw the asymptotic states of a body with the |lambda| of its start [kg m^3/s].

    Raises InputError for a system that has none.
    """
    from ..landscape import run_landscape
    from .style import literal

    branches, marks = run_landscape.diagram(system, parameters, lam)
    return composed(
        "states", (branches, marks | {"|λ| of the start": abs(lam)}, literal(title)), look
    )


def with_records(attrs: dict[str, Any]) -> dict[str, Any]:
    """Return the attributes with units, `symbols` and the name of the `law` from the records."""
    from ..mechanics.contact.opening import ABOVE
    from ..mechanics.contact.restitution import CONTACT
    from ..mechanics.systems import find

    system, friction = find(attrs["system"]), attrs.get("friction", {})
    if system is None:
        return attrs
    rules = {**ABOVE, **CONTACT, **system.initial, **system.parameters}
    if law := system.laws.get(friction.get("law", "")):
        law = law.given(friction)
        attrs = attrs | {"law": law.words}
        attrs["units"] = attrs.get("units", {}) | {
            name: rule.unit.symbol for name, rule in law.parameters.items()
        }
        rules |= law.parameters
    return attrs | {
        "symbols": {name: symbol(rule.symbol) for name, rule in rules.items() if rule.symbol}
    }


def _finished(axes: Any, look: Look) -> Any:
    """Return the Axes with the requested title."""
    from .style import as_given, is_ours

    figure = axes.get_figure(root=True)
    if look.title is not None:
        try:
            look.title.encode()
        except UnicodeEncodeError:  # bytes of a command line
            raise InputError(f"the title must be text in UTF-8, but is {look.title!r}.") from None
        if is_ours() and figure.get_suptitle():
            figure.suptitle(as_given(look.title), x=0.01, ha="left")
        else:
            axes.set_title(as_given(look.title))
    return axes


def write(figure: Any, path: Path, look: Look = PLAIN, *, overwrite: bool = False) -> None:
    """Write a figure in the format of the ending of `path`. Raises StoreError."""
    from .style import save, styled

    with styled(dark=look.dark):
        save(figure, path, dpi=look.dpi, overwrite=overwrite)


def figure_of_sweep(kind: str, store: Path, look: Look = PLAIN) -> Any:
    """Draw one kind of figure of a sweep. Raises InputError, StoreError."""
    from ..sweeps import maps
    from .sweep_map import draw_map

    return _composed(draw_map, (maps.make_map(store, kind),), look)


def composed(kind: str, given: tuple[Any, ...], look: Look = PLAIN) -> Any:
    """Draw one kind of figure from the arguments of its function; return the Figure."""
    return _composed(_drawings()[kind], given, look)


def _composed(draw: Callable, given: tuple[Any, ...], look: Look) -> Any:
    from .style import styled

    with styled(dark=look.dark, size=look.size):
        return _finished(draw(*given), look).get_figure(root=True)

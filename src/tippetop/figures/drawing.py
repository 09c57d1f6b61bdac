"""Draw the figures of the catalogue: of a run, of several runs and of a sweep.

Only this module passes data to figures: a drawing imports nothing but the style.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..columns import symbol
from ..errors import InputError
from ..store.files import replacing
from .catalogue import COMPARED, DRAWN_FOR, FIGURES, PLAIN, Look, check_kind


def _drawings() -> dict[str, Callable]:
    """Return the function for each kind of figure of a run; this imports matplotlib.

    The names are those of `FIGURES`; each function takes (trajectory, events, attrs) and returns
    the Axes of its first panel.
    """
    from ..landscape import run_landscape
    from ..runs import shape as bodies
    from . import conservation, energetics, film, landscape_figures, sphere, stability, theta, well

    def in_landscape(draw: Callable, data_of: Callable) -> Callable:
        """Return a drawing of (trajectory, events, attrs): draw(*data_of(...)), by the data of the
        run's landscape.
        """
        return lambda *run: draw(*data_of(*run))

    def of_changes(draw: Callable) -> Callable:
        """Return a drawing of (trajectory, events, attrs): draw(changes, attrs), by the changes of
        the invariants.
        """
        return lambda run, events, attrs: draw(conservation.changes(run, attrs), attrs)

    def filmed(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Any:
        """Draw the film strip of a run."""
        return film.film(trajectory, attrs, bodies.shape(attrs), bodies.rotation)

    return {
        "theta": theta.theta,
        "normal-force": energetics.normal_force,
        "drift": of_changes(conservation.drift),
        "growth": of_changes(conservation.growth),
        "sphere": sphere.sphere,
        "energy": energetics.energy,
        "film": filmed,
        "states": in_landscape(stability.states, run_landscape.states),
        "band": in_landscape(landscape_figures.band, run_landscape.band),
        "surface": in_landscape(landscape_figures.surface, run_landscape.surface),
        "potential": in_landscape(well.potential, run_landscape.potential),
    }


def axes_of(
    kind: str, groups: dict[str, Any], attrs: dict[str, Any], look: Look = PLAIN, ax: Any = None
) -> Any:
    """Draw one kind of figure of a run; return the Axes, of several panels the first.

    Parameters
    ----------
    kind
        A name of `FIGURES`.
    groups
        trajectory and events, and phases and impacts where the run has them, as Datasets.
    attrs
        The root attributes of the run's store, with `first_row` of a part that `in_window` cut.
    look
        Size, colours and title.
    ax
        Axes to draw in, without further panels and without legends outside.

    Raises
    ------
    InputError
        For another kind, and where the run lacks what the figure shows.
    """
    from .shading import handed_over, mark

    check_kind(kind)
    _refuse(kind, groups["trajectory"], attrs)
    if ax is not None and (kind == "surface") != (getattr(ax, "name", "") == "3d"):
        shape = "in 3-D" if kind == "surface" else "flat"
        raise InputError(f"`ax` of `{kind}` must be {shape}, but is not.")
    phases = groups.get("phases")
    attrs = with_records(attrs) | {"handed_over": handed_over(phases)}

    def draw() -> Any:
        """Draw the figure, and mark the phases of the contact; return the first Axes."""
        axes = _drawings()[kind](groups["trajectory"], groups["events"], attrs)
        if FIGURES[kind].over_time and phases is not None:
            panels = [axes] if ax is not None else axes.get_figure(root=True).axes
            mark(panels, phases, groups.get("impacts"))
        return axes

    return drawn(draw, look, ax)


def _refuse(kind: str, trajectory: Any, attrs: dict[str, Any]) -> None:
    """Raise InputError if a run lacks rows or columns that a figure of this kind uses.

    `trajectory` is a Dataset, `attrs` are its root attributes; `attrs["run"]` has `columns` if the
    run kept some of its columns only.
    """
    from ..columns import require
    from ..mechanics.systems import find
    from ..runs.shape import columns_of

    chosen = FIGURES[kind]
    system = find(attrs["system"])
    if "columns" in attrs["run"] and system is not None:
        uses = {chosen.needs, *chosen.uses}
        if "integrals" in uses:
            uses |= {*system.integrals}
        if "landscape" in uses and system.landscape is not None:
            uses |= {*system.landscape.columns}
        require(sorted(uses & columns_of(attrs)), trajectory, f"the figure `{kind}`")
    if chosen.needs not in trajectory:
        raise InputError(
            f"`{kind}` is drawn for {DRAWN_FOR[chosen.needs]} only; this is `{attrs['system']}`."
        )
    if not trajectory["time"].size:
        raise InputError(
            f"`{kind}` requires rows, but a run has none: replay a part of it, or resume it."
        )


def several(
    kind: str,
    runs: list[tuple[Any, dict[str, Any]]],
    names: list[str],
    look: Look = PLAIN,
    ax: Any = None,
) -> Any:
    """Draw the same curve of several runs in one panel; return the Axes.

    `runs` are trajectories and root attributes, `names` the labels of runs without a difference.
    Raises InputError.
    """
    from .overlay import overlay
    from .style import literal

    check_kind(kind)
    if not FIGURES[kind].compares:
        raise InputError(
            f"several runs are drawn together as {COMPARED}; `{kind}` is drawn of one."
        )
    for trajectory, attrs in runs:
        _refuse(kind, trajectory, attrs)
    known_runs = [(trajectory, with_records(attrs)) for trajectory, attrs in runs]
    return drawn(lambda: overlay(kind, known_runs, [*map(literal, names)]), look, ax)


def with_records(attrs: dict[str, Any]) -> dict[str, Any]:
    """Return the attributes with `symbols`, the name of the `law` and its `parts` from records."""
    from ..mechanics.contact.opening import ABOVE
    from ..mechanics.contact.restitution import CONTACT
    from ..mechanics.friction import PARTS
    from ..mechanics.systems import find

    system = find(attrs["system"])
    friction = attrs.get("friction", {})
    if system is None:
        return attrs
    rules = {**ABOVE, **CONTACT, **system.initial, **system.parameters}
    if law := system.laws.get(friction.get("law", "")):
        law = law.given(friction)
        attrs = attrs | {"law": law.words, "parts": tuple(PARTS)}
        rules |= law.parameters
    return attrs | {
        "symbols": {name: symbol(rule.symbol) for name, rule in rules.items() if rule.symbol}
    }


def drawn(draw: Callable[[], Any], look: Look = PLAIN, ax: Any = None) -> Any:
    """Return the Axes that a function draws in our style, with the title of `look`.

    `ax` is the panel in which it draws, if that is the user's. Raises InputError.
    """
    from .style import as_given, styled

    with styled(dark=look.dark, size=look.size, ax=ax):
        axes = draw()
        figure = axes.get_figure(root=True)
        if look.title is not None:
            title = as_given(look.title)
            if ax is None and figure.get_suptitle():
                figure.suptitle(title, x=0.01, ha="left")
            else:
                axes.set_title(title)
    return axes


def write(picture: Any, path: Path, look: Look = PLAIN, *, overwrite: bool = False) -> None:
    """Write Axes, or a Figure, atomically in the format of the ending of `path`.

    Raises StoreError, also if the file exists and must not be overwritten.
    """
    from .style import styled

    figure = picture.get_figure(root=True)
    ending = path.suffix.removeprefix(".").lower()
    # so that the same picture has the same bytes
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(ending)
    # `styled`, because matplotlib reads `svg.hashsalt` when it saves
    with styled(dark=look.dark), replacing(path, overwrite=overwrite) as scratch:
        figure.savefig(
            scratch,
            dpi=look.dpi,
            format=ending,
            facecolor=figure.get_facecolor(),
            metadata=undated,
        )

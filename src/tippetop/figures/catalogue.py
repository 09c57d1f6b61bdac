"""The figures of a run and of a sweep: what each is made from, what it needs, and what draws it.

Here only are figures fed: a drawing imports nothing but the style, and takes what it is given.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import landscape, run, stability
from .style import save, styled


def _as_they_are(trajectory: Any, events: Any, attrs: dict[str, Any]) -> tuple[Any, ...]:
    return trajectory, events, attrs


@dataclass(frozen=True)
class RunFigure:
    """A figure of a run: draw(*prepare(trajectory, events, attrs))."""

    draw: Callable
    prepare: Callable = _as_they_are
    needs: tuple[str, ...] = ("time",)  # columns without which there is nothing to show


def _in_landscape(name: str) -> Callable:
    """What `landscape.along_run` makes of a run; numba wakes only when it is asked for."""

    def prepare(trajectory: Any, events: Any, attrs: dict[str, Any]) -> tuple[Any, ...]:
        from ..landscape import along_run

        tables = (along_run.table(group) for group in (trajectory, events))
        return getattr(along_run, name)(*tables, attrs)

    return prepare


FIGURES: dict[str, RunFigure] = {
    "theta": RunFigure(run.theta),
    "normal-force": RunFigure(run.normal_force, needs=("normal_force",)),
    "drift": RunFigure(run.drift),
    "growth": RunFigure(run.growth),
    "sphere": RunFigure(run.sphere, needs=("axis",)),
    "energy": RunFigure(run.energy),
    "phase": RunFigure(stability.phase, _in_landscape("phase"), ("routh",)),
    "band": RunFigure(landscape.band, _in_landscape("band")),
    "surface": RunFigure(landscape.surface, _in_landscape("surface"), ("routh",)),
    "potential": RunFigure(landscape.potential, _in_landscape("potential")),
    "inversion": RunFigure(landscape.inversion, _in_landscape("inversion"), ("routh",)),
}


def draw(kind: str, groups: dict[str, Any], attrs: dict[str, Any], path: Path) -> None:
    """Draws one kind of figure of a run to a file.

    Parameters
    ----------
    kind
        A name of `FIGURES`.
    groups
        trajectory and events, Datasets or columns by name.
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
    from ..errors import InputError

    check_kind(kind)
    figure = FIGURES[kind]
    missing = [name for name in figure.needs if name not in groups["trajectory"]]
    if missing:
        raise InputError([f"the figure `{kind}` must have `{missing[0]}` to draw, but this system has none."])
    with styled():
        save(figure.draw(*figure.prepare(groups["trajectory"], groups["events"], attrs)), path)


def draw_sweep(kind: str, store: Path, path: Path) -> None:
    """Draws one kind of figure of a sweep to a file. Raises InputError, StoreError."""
    from ..sweeps import maps
    from . import sweep

    made = maps.mapped(store, kind)
    with styled():
        save(sweep.draw_map(made), path)


def check_kind(kind: str) -> None:
    """Raises InputError if there is no such figure."""
    from ..errors import InputError

    if kind not in FIGURES:
        raise InputError([f"the kind of figure must be one of {', '.join(FIGURES)}, but is `{kind}`."])

"""The kinds of figures: what each draws, and what a run must have for it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from . import landscape, run, stability
from .style import save, styled


def _in_landscape(name: str) -> Callable:
    """A figure of a run in its landscape; numba wakes only when it is drawn."""

    def drawn(trajectory: Any, events: Any, attrs: dict[str, Any]) -> Any:
        from ..landscape import along_run

        tables = (along_run.table(group) for group in (trajectory, events))
        return getattr(landscape, name)(*getattr(along_run, name)(*tables, attrs))

    return drawn


KINDS: dict[str, Callable] = {
    "theta": run.theta,
    "normal-force": run.normal_force,
    "drift": run.drift,
    "growth": run.growth,
    "sphere": run.sphere,
    "energy": run.energy,
    "phase": stability.phase_of_run,
    **{name: _in_landscape(name) for name in ("band", "surface", "potential", "inversion")},
}


NEEDED = {"sphere": "axis", **dict.fromkeys(("phase", "band", "surface", "potential", "inversion"), "routh")}
"""The column without which a figure has nothing to show."""


def draw(kind: str, groups: dict[str, Any], attrs: dict[str, Any], path: Path) -> None:
    """Draws one kind of figure of a run to a file. groups: trajectory and events, Datasets or columns."""
    written(drawn(kind, groups, attrs), path)


def drawn(kind: str, groups: dict[str, Any], attrs: dict[str, Any]) -> Figure:
    """One kind of figure of a run. Raises InputError if the run has not what it shows."""
    from ..errors import InputError

    if NEEDED.get(kind, "time") not in groups["trajectory"]:
        raise InputError([f"the figure `{kind}` must have `{NEEDED[kind]}` to draw, but this system has none."])
    with styled():
        return KINDS[kind](groups["trajectory"], groups["events"], attrs)


def written(figure: Figure, path: Path) -> None:
    """Writes a figure; the ending of `path` names the format. Raises StoreError."""
    with styled():
        save(figure, path)


def draw_sweep(kind: str, store: Path, path: Path) -> None:
    """Draws one kind of figure of a sweep to a file. Raises ScenarioError, StoreError."""
    from ..sweeps import maps
    from . import sweep

    made = maps.make_map(store, kind)
    with styled():
        save(sweep.draw_map(made), path)


def check_kind(kind: str) -> None:
    """Raises ScenarioError if there is no such figure."""
    from ..errors import InputError

    if kind not in KINDS:
        raise InputError([f"the kind of figure must be one of {', '.join(KINDS)}, but is `{kind}`."])

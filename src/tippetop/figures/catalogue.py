"""The kinds of figures: what each shows, which function draws it, and what a store must have for it.

Nothing is imported until a figure is drawn, so that `tippetop plot --help` can list the kinds at once.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Kind:
    """A kind of figure. `draw` and `prepare` are module:function inside the package, imported when needed."""

    name: str
    shows: str  # one line for people
    draw: str  # draws what `prepare` gives, or (trajectory, events, attributes) of a run
    prepare: str | None = None  # what is computed of (trajectory, events, attributes) before it is drawn
    needs: str = "time"  # the column of the trajectory without which there is nothing to draw
    drawn_for: str = ""  # the systems that have that column, in words


def _in_landscape(name: str, shows: str) -> Kind:
    """A figure of a run in its landscape."""
    function = f"figures.landscape:{name}", f"landscape.along_run:{name}"
    return Kind(name, shows, *function, needs="routh", drawn_for="tippe tops")


KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        Kind("theta", "theta(t), turning angles, nutational band (default)", "figures.run:theta"),
        Kind("normal-force", "normal force g_n(t) in units of the weight", "figures.run:normal_force"),
        Kind("drift", "relative change of what must be conserved", "figures.run:drift"),
        Kind("growth", "growth of the worst drift with t, beside sqrt(t)", "figures.run:growth"),
        Kind("sphere", "path of the axis on the sphere", "figures.run:sphere", needs="axis", drawn_for="tops"),
        Kind("energy", "energy, modified energy, energy taken by friction", "figures.run:energy"),
        Kind(
            "phase",
            "asymptotic states over lambda, and where the run is among them",
            "figures.stability:phase_of_run",
            needs="routh",
            drawn_for="tippe tops",
        ),
        _in_landscape("band", "turning angles that the main equation predicts"),
        _in_landscape("surface", "the run on the minimal surface F(D, lambda)"),
        _in_landscape("potential", "the effective potential V(z) at six times"),
        _in_landscape("inversion", "the run on the section of F at its lambda"),
    )
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

    def listed(found: Iterable[tuple[str, str]]) -> str:
        return "".join(f"\n- {name}: {shows}" for name, shows in found)

    runs = listed((name, kind.shows) for name, kind in KINDS.items())
    sweeps = listed(SWEEP_KINDS.items())
    return f"Of a run:\n{runs}\n\nOf a sweep:\n{sweeps}\n\nA surface and a potential have one figure each."


def draw(kind: str, groups: dict[str, Any], attrs: dict[str, Any], path: Path) -> None:
    """Draws one kind of figure of a run to a file. groups: trajectory and events, Datasets or columns.

    Raises InputError if the run has nothing of this kind to draw, StoreError if the file cannot be written.
    """
    from ..errors import InputError, a_system
    from .style import save, styled

    chosen = KINDS[kind]
    if chosen.needs not in groups["trajectory"]:
        raise InputError([f"`{kind}` is drawn for {chosen.drawn_for} only; this is {a_system(attrs['system'])}."])
    given: Any = (groups["trajectory"], groups["events"], attrs)
    if chosen.prepare is not None:
        from ..landscape import along_run

        given = _function(chosen.prepare)(*(along_run.table(group) for group in given[:2]), attrs)
    with styled():
        save(_function(chosen.draw)(*given), path)


def draw_sweep(kind: str, store: Path, path: Path) -> None:
    """Draws one kind of figure of a sweep to a file. Raises InputError, StoreError."""
    from ..sweeps import maps
    from . import sweep
    from .style import save, styled

    made = maps.make_map(store, kind)
    with styled():
        save(sweep.draw_map(made), path)


def check_kind(kind: str, known: Iterable[str] = KINDS) -> None:
    """Raises InputError if there is no such figure."""
    from ..errors import InputError, suggestion

    if kind not in known:
        raise InputError(
            [f"the kind of figure must be one of {', '.join(known)}, but is `{kind}`.{suggestion(kind, known)}"]
        )


def _function(name: str) -> Any:
    """The function module:name of the package."""
    module, _, function = name.partition(":")
    return getattr(import_module(f"...{module}", __name__), function)

"""The figures of runs and of sweeps with the columns that they need.

This module does not import matplotlib, so that `tippetop plot --help` is fast.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError, suggestion


DRAWN_FOR = {
    "theta": "systems with an inclination theta",
    "normal_force": "systems with a normal force",
    "energy": "systems with an energy",
    "axis": "tops",
    "orientation": "runs that keep the orientation",
    "routh": "tippe tops",
}
"""The systems that have a column, in words."""


@dataclass(frozen=True)
class RunFigure:
    """A figure of a run.

    Parameters
    ----------
    shows
        One line for the help.
    needs
        The column without which it cannot be drawn: time, or a key of `DRAWN_FOR`.
    uses
        Further columns that it is made from, where the system has them; "integrals" and "landscape"
        are those of the system. A run that did not keep one of them is refused by name.
    over_time
        Whether the x axis of every panel is the time; the phases of the contact are shaded then.
    compares
        Whether several runs can be drawn in one panel; `overlay` draws these kinds.
    """

    shows: str
    needs: str = "time"
    uses: tuple[str, ...] = ()
    over_time: bool = False
    compares: bool = False


@dataclass(frozen=True)
class Look:
    """The look of a figure: another title, width and height [inches], dots per inch, colours.

    The fields are keywords of `StoredRun.plot`, to which `cli.plot` passes them.
    """

    title: str | None = None
    size: tuple[float, float] | None = None
    dpi: float = 150
    dark: bool = False


PLAIN = Look()


OF_LANDSCAPES = ("theta", "phase", "ball", "landscape")
OF_DRIFT = ("integrals", "work", "axis", "ball", "jellett_lost")


def _over_time(shows: str, needs: str, *uses: str) -> RunFigure:
    """Return a figure of curves over time, of one or of several runs."""
    return RunFigure(shows, needs, uses, over_time=True, compares=True)


FIGURES: dict[str, RunFigure] = {
    "theta": _over_time("theta(t), turning angles, nutational band (default)", "theta"),
    "normal-force": _over_time("normal force g_n(t) in units of the weight", "normal_force"),
    "drift": _over_time("relative change of the conserved quantities", "energy", *OF_DRIFT),
    "growth": RunFigure(
        "growth of the worst drift with t, and sqrt(t)", "energy", OF_DRIFT, compares=True
    ),
    "sphere": RunFigure("path of the axis on the sphere", "axis"),
    "energy": _over_time(
        "energy, modified energy, energy taken by friction",
        "energy",
        *("modified_energy", "work", "phase", "ball"),
    ),
    "film": RunFigure(
        "eight poses of the body on one line, by their times",
        "orientation",
        ("theta", "axis", "z"),
    ),
    "states": RunFigure(
        "asymptotic states over lambda, and the run among them; also of a scenario",
        "routh",
        OF_LANDSCAPES,
    ),
    "band": RunFigure("turning angles that the main equation predicts", uses=OF_LANDSCAPES),
    "surface": RunFigure("the run on the minimal surface F(D, lambda)", "routh", OF_LANDSCAPES),
    "potential": RunFigure("the effective potential V(z) at six times", uses=OF_LANDSCAPES),
}
"""The figures of a run, by name; `drawing._drawings` has the same names."""

COMPARED = ", ".join(name for name, figure in FIGURES.items() if figure.compares)
"""The figures that several runs share, in words."""

SWEEP_KINDS = {
    "class": "fate of each top over two axes (default)",
    "inversion": "time of inversion",
    "normal-force": "least normal force",
    "lyapunov": "finite-time Lyapunov exponent, of a plan that keeps it",
}
"""The figures of a sweep; `sweeps.maps.NEEDED` has their columns, `sweep_map` their labels."""
ENDINGS = (".png", ".svg", ".pdf")
MOST_PIXELS = 20_000  # along a side


def described() -> str:
    """Return the kinds of figures for the help of `plot`."""
    runs = "".join(f"\n- {name}: {figure.shows}" for name, figure in FIGURES.items())
    sweeps = "".join(f"\n- {name}: {shows}" for name, shows in SWEEP_KINDS.items())
    return (
        f"Further runs, to be drawn in the same panel ({COMPARED}); and, last, the kind of "
        f"figure.\n\nOf a run:\n{runs}"
        f"\n\nOf a sweep:\n{sweeps}\n\nA surface and a potential have one figure each."
    )


def check_kind(kind: str, known: Iterable[str] = FIGURES) -> None:
    """Raise InputError if there is no such figure."""
    known = list(known)
    if not isinstance(kind, str) or kind not in known:
        raise InputError(
            f"the kind of figure must be one of {', '.join(known)}, but is "
            f"`{kind}`.{suggestion(str(kind), known)}"
        )


def check_format(path: Path) -> Path:
    """Return a path. Raises InputError if its ending is not a format of figures."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            f"`{path}` must end with the format of a figure: .png, .svg or .pdf, but does not."
        )
    return path


def check_look(look: Look) -> None:
    """Raise InputError if a figure cannot have this look."""
    if not 10 <= look.dpi <= 2400:
        raise InputError(f"`dpi` must be between 10 and 2400, but is {look.dpi:g}.")
    most = MOST_PIXELS / look.dpi
    if look.size is not None and not all(1 <= side <= most for side in look.size):
        given = " x ".join(f"{side:g}" for side in look.size)
        raise InputError(
            f"`size` must be between 1 and {most:g} inches at {look.dpi:g} dpi, but is {given}."
        )

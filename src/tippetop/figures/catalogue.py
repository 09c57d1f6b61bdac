"""The figures of a run and of a sweep: what each shows, and the columns that it is made from.

`drawing` draws them: without matplotlib, `tippetop plot --help` lists the kinds quickly.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError, suggestion


@dataclass(frozen=True)
class RunFigure:
    """A figure of a run.

    Where the x axis is the time, the phases of the run's contact are shaded behind it.
    """

    shows: str  # one line for people
    needs: str = "time"  # the column of the trajectory without which there is nothing to show
    uses: tuple[str, ...] = (
        "theta",
    )  # the columns that it is made from, where the system has them; "integrals" and
    # "landscape" stand for those of the system
    drawn_for: str = ""  # the systems that have that column, in words
    over_time: bool = False  # whether the x axis of every panel is the time
    compares: bool = False  # whether several runs can be axes in one panel
    in_landscape: bool = (
        False  # whether it is drawn from the function of `landscape.along_run` of its name
    )


@dataclass(frozen=True)
class Look:
    """How a figure looks: its title instead of its own, width and height [inches], dots per inch,
    light on dark.
    """

    title: str | None = None
    size: tuple[float, float] | None = None
    dpi: float = 150
    dark: bool = False


PLAIN = Look()


OF_LANDSCAPES = ("theta", "phase", "ball", "landscape")
OF_DRIFT = ("integrals", "energy", "work", "axis", "ball", "jellett_lost")


WITH_ENERGY = "systems with an energy"


def _of_tippe_tops(shows: str) -> RunFigure:
    """A figure over the spinning states of a tippe top."""
    return RunFigure(
        shows, needs="routh", uses=OF_LANDSCAPES, drawn_for="tippe tops", in_landscape=True
    )


FIGURES: dict[str, RunFigure] = {
    "theta": RunFigure(
        "theta(t), turning angles, nutational band (default)",
        needs="theta",
        drawn_for="systems with an inclination theta",
        over_time=True,
        compares=True,
    ),
    "normal-force": RunFigure(
        "normal force g_n(t) in units of the weight",
        needs="normal_force",
        uses=("normal_force",),
        drawn_for="systems with a normal force",
        over_time=True,
        compares=True,
    ),
    "drift": RunFigure(
        "relative change of what must be conserved",
        needs="energy",
        uses=OF_DRIFT,
        drawn_for=WITH_ENERGY,
        over_time=True,
        compares=True,
    ),
    "growth": RunFigure(
        "growth of the worst drift with t, beside sqrt(t)",
        needs="energy",
        uses=OF_DRIFT,
        drawn_for=WITH_ENERGY,
        compares=True,
    ),
    "sphere": RunFigure(
        "path of the axis on the sphere", needs="axis", uses=("axis",), drawn_for="tops"
    ),
    "energy": RunFigure(
        "energy, modified energy, energy taken by friction",
        needs="energy",
        uses=("energy", "modified_energy", "work", "phase", "ball"),
        drawn_for=WITH_ENERGY,
        over_time=True,
        compares=True,
    ),
    "film": RunFigure(
        "eight poses of the body on one line, by their times",
        needs="orientation",
        uses=("theta", "axis", "orientation", "z"),
        drawn_for="runs that keep the orientation",
    ),
    "states": _of_tippe_tops(
        "asymptotic states over lambda, and the run among them; also of a scenario"
    ),
    "band": RunFigure(
        "turning angles that the main equation predicts", uses=OF_LANDSCAPES, in_landscape=True
    ),
    "surface": _of_tippe_tops("the run on the minimal surface F(D, lambda)"),
    "potential": RunFigure(
        "the effective potential V(z) at six times", uses=OF_LANDSCAPES, in_landscape=True
    ),
    "inversion": _of_tippe_tops("the run on the section of F at its lambda"),
}
"""The figures of a run, by name."""
FORMER = {"phase": "states"}
"""Names that figures had."""

SWEEP_KINDS = {
    "class": "fate of each top over two axes (default)",
    "inversion": "time of inversion",
    "normal-force": "least normal force",
    "lyapunov": "finite-time Lyapunov exponent, of a plan that keeps it",
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
        f"Further runs, to be axes beside the first ({several}); and, last, the kind of "
        f"figure.\n\nOf a run:\n{runs}"
        f"\n\nOf a sweep:\n{sweeps}\n\nA surface and a potential have one figure each."
    )


def kind_of(word: str) -> str:
    """The name of a kind of figure, by that name or by one that it had. Raises InputError."""
    check_kind(word, [*FIGURES, *FORMER])
    return FORMER.get(word, word)


def check_kind(kind: str, known: Iterable[str]) -> None:
    """Raises InputError if there is no such figure."""
    known = list(known)
    if not isinstance(kind, str) or kind not in known:
        kind = str(kind)
        listed = ", ".join(name for name in known if name not in FORMER)
        raise InputError(
            [
                f"the kind of figure must be one of {listed}, but is "
                f"`{kind}`.{suggestion(kind, known)}"
            ]
        )


def check_format(path: Path) -> None:
    """Raises InputError if the ending of a path names no format of figures."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            [f"`{path}` must end with the format of a figure: .png, .svg or .pdf, but does not."]
        )


def check_look(look: Look) -> None:
    """Raises InputError if a figure could not look so."""
    if not 10 <= look.dpi <= 2400:
        raise InputError([f"`dpi` must be between 10 and 2400, but is {look.dpi:g}."])
    if look.size is not None and not all(1 <= side <= MOST_PIXELS / look.dpi for side in look.size):
        given = " x ".join(f"{side:g}" for side in look.size)
        most = MOST_PIXELS / look.dpi
        raise InputError(
            [f"`size` must be between 1 and {most:g} inches at {look.dpi:g} dpi, but is {given}."]
        )

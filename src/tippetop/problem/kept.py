"""What the rows of a run say, by name, and which of it a scenario asks for."""

from collections.abc import Collection

from ..errors import suggestion
from ..mechanics.system import Form, System
from ..mechanics.variables import Variables


TIME = "time"  # a column of every run, whatever is asked for
TURN = ("psi", "orientation")  # what needs the turn of the body about its axis
PSI = (
    "turn psi of the body about its axis, from 1hat, in (-pi, pi]; undefined (NaN) exactly at "
    "a pole"
)
ORIENTATION = "unit quaternion that turns body axes into space axes, w >= 0"


def column_names(system: System, form: Form, orientation: bool, precision: str) -> tuple[str, ...]:
    """The columns that a run can have beside the time; in wider precisions each may have a second
    one, `name_lo`.

    Parameters
    ----------
    system, form
        What moves, and how it is written.
    orientation
        Whether the turn of the body about its axis is integrated.
    precision
        In quadruple the integrated variables are columns too.

    Returns
    -------
    tuple of str
        In the order of the table.
    """
    turn: tuple[str, ...] = ()
    if orientation and form.orientation:
        turn = TURN if form.orientation.psi else ("orientation",)
    quantities = [q.name for q in system.quantities if q.meanings or q.is_column]
    states = (
        [f"state_{name}" for name in Variables(form, orientation).names]
        if precision == "quad"
        else []
    )
    return (*system.angles._fields, *system.vectors, *turn, *quantities, *states)


def column_faults(
    asked: Collection[str], known: Collection[str], orientation: bool | None
) -> list[str]:
    """Sentences on columns that are asked for and that the run cannot have; `orientation` as the
    scenario gives it.
    """
    faults = []
    for name in asked:
        if name in TURN and orientation is False:
            faults.append(
                f"`run.orientation` must be true where `run.columns` has {name!r}, but is false."
            )
        elif name not in (TIME, *known):
            faults.append(
                f"`run.columns` must be of {', '.join(known)}, but has "
                f"{name!r}.{suggestion(name, known)}"
            )
    return faults

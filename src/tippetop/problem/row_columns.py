"""The names of the columns of a run.

A system and a form go in, names of columns come out.
"""

from collections.abc import Collection

from ..errors import suggestion
from ..mechanics.system import Form, System
from ..mechanics.variables import Variables


TIME = "time"  # a column of every run
TURN = ("psi", "orientation")  # columns that need the turn of the body about its axis
PSI = "turn psi of the body about its axis, from 1hat, in (-pi, pi]; undefined (NaN) at a pole"
ORIENTATION = "unit quaternion that turns body axes into space axes, w >= 0"


def column_names(system: System, form: Form, orientation: bool, precision: str) -> tuple[str, ...]:
    """Return the columns that a run can have in addition to the time.

    In wider precisions each may have a second one, `name_lo`.

    Parameters
    ----------
    system, form
        The equations, and how they are written.
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
    variables = Variables(form, orientation).names if precision == "quad" else ()
    states = [f"state_{name}" for name in variables]
    return (*system.angles._fields, *system.vectors, *turn, *quantities, *states)


def column_faults(
    asked: Collection[str], known: Collection[str], orientation: bool | None
) -> list[str]:
    """Return sentences on columns that the run cannot have.

    `orientation` is that of the scenario, None if it is left out.
    """
    faults = []
    for name in dict.fromkeys(asked):
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

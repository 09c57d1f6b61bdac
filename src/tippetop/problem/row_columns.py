"""The columns of a run: their names and sources.

A system and a form go in, names of columns come out.
"""

from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import NamedTuple

from ..errors import suggestion
from ..mechanics.contact.body_axes import PSI
from ..mechanics.system import Form, System
from ..mechanics.units import ONE, RADIAN, Unit
from ..mechanics.variables import Variables


TIME = "time"  # a column of every run
TURN = ("psi", "orientation")  # columns that need the turn of the body about its axis
ORIENTATION = "unit quaternion that turns body axes into space axes, w >= 0"


class Source(NamedTuple):
    """The source of a column of a run.

    Parameters
    ----------
    parts
        Names of the values that it consists of.
    unit, long_name
        Unit and description of the column.
    dims
        Its dimensions beyond the time.
    attributes
        Further attributes: the symbol in TeX of a quantity.
    flags
        Meanings of its numbers, where these are flags.
    """

    parts: tuple[str, ...]
    unit: Unit
    long_name: str
    dims: tuple[str, ...] = ()
    attributes: Mapping[str, str] = {}
    flags: tuple[str, ...] = ()


def component(variable: str) -> str:
    """Return the name of a component of a vector among the values of a row.

    It differs from that of the variable, because a quantity may have the same name: L_z of a heavy
    top is about the tip, that of the column L about the centre of mass. `engine.expressions`
    computes values of these names.
    """
    return f"vector_{variable}"


QUATERNION = tuple(f"orientation_{part}" for part in "wxyz")
"""Names of the parts of the orientation among the values of a row."""


@lru_cache(maxsize=64)
def every_source(system: System, form: str, orientation: bool = True) -> dict[str, Source]:
    """Return the sources of the columns that runs of a system can have, in the order of the table.

    `form` is the name of the form; `orientation` as for `column_names`. In wider precisions each
    column may have a second one, `name_lo`. The dict is cached: not to be changed.
    """
    names = system.long_names
    found = {
        name: Source((name,), unit, names.get(name, ""))
        for name, unit in system.angles._asdict().items()
    }
    for name, variables in system.vectors.items():
        unit = getattr(system.forms["vector"].units, variables[0])
        parts = tuple(map(component, variables))
        found[name] = Source(parts, unit, names.get(name, ""), ("xyz",))
    turn = system.forms[form].orientation
    if orientation and turn:
        if turn.psi:
            found["psi"] = Source(("psi",), RADIAN, PSI)
        found["orientation"] = Source(QUATERNION, ONE, ORIENTATION, ("wxyz",))
    return found | {
        q.name: Source((q.name,), q.unit, q.long_name, (), {"symbol": q.symbol}, tuple(q.meanings))
        for q in system.quantities
        if q.is_column
    }


def column_names(system: System, form: Form, orientation: bool, precision: str) -> tuple[str, ...]:
    """Return the columns that a run can have in addition to the time.

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
    known = every_source(system, form.name, orientation)
    variables = Variables(form, orientation).names if precision == "quad" else ()
    return (*known, *(f"state_{name}" for name in variables))


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

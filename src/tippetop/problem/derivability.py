"""The numbers of a problem by which its motion can be differentiated."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..errors import InputError
from .faults import key_faults


if TYPE_CHECKING:
    from .problem import Problem


EXCLUDED = ("run.",)  # tables: a motion has no derivatives by their numbers


def derivative_faults(problem: "Problem", wrt: Sequence[str]) -> list[str]:
    """Return why a run has no derivatives by these numbers; empty if it has."""
    if problem.precision != "double":
        return [f'`run.precision` must be "double" for derivatives, but is "{problem.precision}".']
    if problem.origin is not None:
        return [
            "`initial.from` must not be given for derivatives: the end of another run has none "
            "here."
        ]
    added = {name.partition(".")[2]: 0.0 for name in wrt if name.startswith("initial.")}
    faults = key_faults(problem, wrt, without=EXCLUDED)
    return faults or problem.system.clashes({**problem.initial, **added})


def refuse(problem: "Problem", wrt: Sequence[str]) -> None:
    """Raise InputError for a run that has no derivatives, and for wrong names."""
    if faults := derivative_faults(problem, wrt):
        raise InputError(faults)

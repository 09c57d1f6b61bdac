"""The numbers of a problem by which its motion can be differentiated."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..errors import InputError
from .faults import key_faults


if TYPE_CHECKING:
    from .problem import Problem


def refuse(problem: "Problem", wrt: Sequence[str]) -> None:
    """Raise InputError for a run that has no derivatives, and for wrong names."""
    if problem.precision != "double":
        raise InputError(
            f'`run.precision` must be "double" for derivatives, but is "{problem.precision}".'
        )
    if problem.origin is not None:
        raise InputError(
            "`initial.from` must not be given for derivatives: the end of another run has none "
            "here."
        )
    added = {name.partition(".")[2]: 0.0 for name in wrt if name.startswith("initial.")}
    known = [key for key in problem.rules if not key.startswith("run.")]
    faults = key_faults(problem, wrt, known)
    if faults := faults or problem.system.clashes({**problem.initial, **added}):
        raise InputError(faults)

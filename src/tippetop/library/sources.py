"""The body behind an argument: a body, a run, a problem, or the name of a scenario.

Calls of `theory`, `landscapes` and `exchanging` take bodies and problems from it.
"""

from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from ..mechanics.contact.body import Top
from ..mechanics.contact.surroundings import require_still
from ..mechanics.systems import SYSTEMS
from ..mechanics.systems.cylinder import Cylinder
from ..mechanics.systems.ellipsoid import Ellipsoid
from ..mechanics.systems.heavy_top import HeavyTop
from ..mechanics.systems.revolution import Disc, Spheroid
from ..mechanics.systems.tippe_top import TippeTop
from ..problem import Problem
from .finished_run import Run
from .scenarios import problem_of


KINDS = (TippeTop, HeavyTop, Cylinder, Spheroid, Disc, Ellipsoid)


def problem_behind(source: Any, kinds: tuple[type[Top], ...] = KINDS) -> Problem | None:
    """Return the problem of a run, a problem or a scenario; None of a body, which has no start.

    `source` is an argument of the user; a scenario is a preset, a path, or tables, and is checked
    as by `run`. Raises InputError for other sources; `kinds` are only the bodies that its message
    lists: a caller checks that the body is one of them.
    """
    if isinstance(source, Top):
        return None
    if isinstance(source, Run):
        return source.problem
    if isinstance(source, str | Mapping | Problem) or hasattr(source, "__fspath__"):
        return problem_of(source)
    raise InputError(
        f"the body must be {_words(kinds)}, a Run, a Problem or the name of a preset, but is "
        f"{source!r:.60}."
    )


def top_of(source: Any, *kinds: type[Top]) -> Any:
    """Return the body of a source, a record of one of these kinds. Raises InputError otherwise.

    A system of the user with the same `body` counts as that kind; a problem with [air] or [plane]
    is refused.
    """
    problem = problem_behind(source, kinds)
    found = f"{source!r:.60}"
    if problem is None and isinstance(source, kinds):
        return source
    if problem is not None:
        require_still(problem.tables, "a top of this theory")
        system = problem.system
        found = f"that of the system {problem.system.name}"
        for kind in kinds:
            names = (kind.gliding, kind.resting)
            if system.name in names or system.body in [SYSTEMS[name].body for name in names]:
                return kind(**problem.parameters)
    raise InputError(f"the body must be {_words(kinds)}, but is {found}.")


def _words(kinds: tuple[type, ...]) -> str:
    """Return types as words: "a Run or a Problem"."""
    return " or ".join(f"a {kind.__name__}" for kind in kinds)

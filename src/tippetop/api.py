"""The calls that a script or a notebook makes."""

from .problem import Problem
from .scenario import load as load
from .solve import Run
from .solve import solve as integrate


def run(source: str, assignments: list[str] | None = None, *, until: float | None = None) -> Run:
    """Integrates a TOML file or preset in memory; assignments are `table.key=value`, `until` is in seconds.

    Raises ScenarioError, which says all that is wrong.
    """
    problem: Problem = load(source, assignments, until)
    return integrate(problem)

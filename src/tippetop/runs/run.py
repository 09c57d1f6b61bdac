"""A problem integrated in memory: the solution as it comes from the integrator, and the call that makes it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..engine.observables import Observables
from ..engine.status import Status
from ..problem import Problem
from .events import EventTable
from .integration import Integration
from .sinks import Memory, Nowhere


@dataclass
class Solution:
    """A problem integrated to its end, in memory: rows and events, and what was measured on the way.

    `library.run.Run` shows it to the user, with labels and in SI units.
    """

    problem: Problem
    status: Status
    reason: str
    times: np.ndarray  # [s]
    rows: np.ndarray  # (n, variables), internal
    events: EventTable
    final: np.ndarray  # last good internal state
    report: dict[str, Any]
    seconds: dict[str, float]  # where the time went: compile, integrate

    def columns(self) -> dict[str, Any]:
        """The rows as named SI columns."""
        return Observables(self.problem).columns(self.times, self.rows)


def solve(problem: Problem, progress: Callable[[Integration], None] | None = None, *, keep: bool = True) -> Solution:
    """Integrates a problem to its end, gathering rows and events in memory.

    Parameters
    ----------
    problem
        What is integrated.
    progress
        Called after every slice.
    keep
        Whether rows and events are kept. If not, nobody can read the orientation of the body, and its integrals are
        left out: they have no effect on the motion, but cost 1.0 to 1.24 times its equations.

    Returns
    -------
    Solution
        Its `problem` is what was integrated: without orientation if nothing was kept.
    """
    if not keep:
        problem = replace(problem, orientation=False)
    integration, memory = Integration(problem), Memory() if keep else Nowhere()
    integration.run(memory, progress)
    assert integration.status is not None
    return Solution(
        problem,
        integration.status,
        integration.reason(),
        np.concatenate([np.zeros(0), *memory.times]),
        np.concatenate([integration.first[:0], *memory.states]),
        memory.table(),
        integration.last[0],
        integration.report(),
        integration.seconds,
    )

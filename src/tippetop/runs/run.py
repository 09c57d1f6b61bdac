"""A problem integrated in memory: the solution as it comes from the integrator, and the call that makes it."""

from collections.abc import Callable
from dataclasses import dataclass
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
    """Integrates a problem to its end, with rows and events kept in memory unless switched off.

    `progress` is called after every slice.
    """
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

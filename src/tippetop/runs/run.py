"""A finished run in memory, and the call that makes one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.observables import View
from ..engine.status import Status
from ..problem import Problem
from ..scenario.build import load
from .events import EventTable
from .integration import Integration
from .sinks import Memory, Nowhere
from .summary import lines


@dataclass
class Run:
    """A finished run in memory: rows and events, and what was measured on the way."""

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
        return View(self.problem).columns(self.times, self.rows)

    def __str__(self) -> str:
        """The run in a few lines."""
        said = lines({"system": self.problem.system.name, "reason": self.reason, **self.report}, self.seconds)
        return "\n".join([self.problem.system.title, *(f"{name:16}{text}" for name, text in said)])


def solve(problem: Problem, progress: Callable[[Integration], None] | None = None, *, keep: bool = True) -> Run:
    """Integrates a problem to its end, gathering rows and events in memory, unless not told to keep them.

    `progress` is called after every slice.
    """
    integration, memory = Integration(problem), Memory() if keep else Nowhere()
    integration.run(memory, progress)
    assert integration.status is not None
    return Run(
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


def run(source: str, assignments: list[str] | None = None, *, until: float | None = None) -> Run:
    """Integrates a TOML file or preset in memory; assignments are `table.key=value`, `until` is in seconds.

    Raises InputError, which says all that is wrong.
    """
    return solve(load(source, assignments, until))

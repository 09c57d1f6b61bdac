"""Events of a run whose contact has phases: those that steps pass, and those that end phases, in one order."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...problem import Problem
from ..slices import Passages


def zero_of(function: Callable[[Any], float], sign: float, end: Any) -> Any:
    """Where a function that begins with a sign has its zero, in [0, end]."""
    low, high = 0 * end, end
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if function(middle) * sign > 0 else (low, middle)
    return high


class RunPassages:
    """Passages of a slice, of all its phases, in the order of the run's events."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.names = [event.name for event in problem.system.events]
        self.parts: list[Passages] = []

    def add(self, passages: Passages, system: Any, rows: np.ndarray) -> None:
        """Takes passages of a phase, whose states are these rows."""
        numbers = np.array(
            [self.names.index(event.name) if event.name in self.names else -1 for event in system.events]
        )
        events = numbers[passages.events] if len(passages.events) else passages.events
        self.parts.append(passages._replace(events=events, states=rows))

    def note(self, name: str, time: Any, row: np.ndarray, way: float = 1.0) -> None:
        """Takes an event that no step has log, such as the end of a phase."""
        sign = np.array([int(way)])
        self.parts.append(
            Passages(
                np.array([time], dtype=self.problem.number),
                np.array([self.names.index(name)]),
                sign,
                np.array([False]),
                row.copy(),
            )
        )

    def passages(self) -> Passages:
        """All of them."""
        return Passages(*(np.concatenate(columns) for columns in zip(*self.parts, strict=True)))

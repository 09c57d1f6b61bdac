"""What a slice makes, gathered in the states of its phases: those of one kind become rows all at once.

A phase may last three steps; to make rows of a state at a time takes longer than these.
"""

from typing import Any

import numpy as np

from ...problem import Problem
from ..driver import Passages, Request
from .balls import Balls
from .legs import Followed
from .rows import rows_of


MOST = 1 << 15  # states that wait


class Part:
    """States of a phase, (n, variables), and what else their rows say."""

    __slots__ = ("carried", "phase", "rows", "states", "taken")

    def __init__(self, phase: Followed, carried: np.ndarray, taken: Any, states: np.ndarray):
        self.phase, self.carried, self.taken, self.states = phase, carried, taken, states
        self.rows: np.ndarray | None = None


class Gathered:
    """The rows, samples and passages of a slice; to the driver of a phase, a request.

    Parameters
    ----------
    problem
        The run.
    balls
        What can touch the plane.
    request
        Who asks for rows.
    """

    def __init__(self, problem: Problem, balls: Balls, request: Request):
        self.problem, self.balls, self.request, self.steps = problem, balls, request, request.steps
        self.names = [event.name for event in problem.system.events]
        self.waiting: list[Part] = []
        self.asked: list[tuple[np.ndarray, Part]] = []
        self.samples: list[Part] = []
        self.log: list[tuple[Passages, Part]] = []
        self.count = 0

    def of(self, phase: Followed, carried: np.ndarray, taken: Any) -> None:
        """What comes next is of this phase."""
        self.present = phase, carried, taken

    # --- what comes -----------------------------------------------------------------------------------------------

    def wanted(self) -> np.ndarray:
        """Internal times of the next rows, or room for so many."""
        return self.request.wanted()

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Takes states that were asked for."""
        self.asked.append((times, self._part(states)))
        if self.count > MOST:
            self.give()

    def take_rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Takes rows that were asked for."""
        self.asked.append((times, self._ready(rows)))

    def sample(self, states: np.ndarray) -> None:
        """Takes states at which the invariants are compared."""
        if len(states):
            self.samples.append(self._part(states))

    def passed(self, passages: Passages, count: int) -> None:
        """Takes the first passages of the phase."""
        if count:
            times, events, signs, at_pole, states = passages
            numbers = self.present[0].numbers[events[:count]]
            about = Passages(times[:count], numbers, signs[:count], at_pole[:count], _NONE)
            self.log.append((about, self._part(states[:count])))

    def note(self, name: str, time: Any, state: np.ndarray, way: float = 1.0) -> None:
        """Takes an event that no step has logged, such as the end of a phase, in a state (variables,) of it."""
        self.log.append((self._event(name, time, way), self._part(state[None])))

    def note_row(self, name: str, time: Any, row: np.ndarray, way: float = 1.0) -> None:
        """The same at a row, (1, variables)."""
        self.log.append((self._event(name, time, way), self._ready(row)))

    def _event(self, name: str, time: Any, way: float) -> Passages:
        times, number = np.array([time], dtype=self.problem.number), self.names.index(name)
        return Passages(times, np.array([number]), np.array([int(way)]), _NO, _NONE)

    def _part(self, states: np.ndarray) -> Part:
        part = Part(*self.present, states)
        self.waiting.append(part)
        self.count += len(states)
        return part

    def _ready(self, rows: np.ndarray) -> Part:
        part = Part(*self.present, rows)
        part.rows = rows
        return part

    # --- what it becomes ------------------------------------------------------------------------------------------

    def give(self) -> None:
        """Makes rows of all that waits, and gives those that were asked for."""
        alike: dict[Followed, list[Part]] = {}
        for part in self.waiting:
            alike.setdefault(part.phase, []).append(part)
        for phase, parts in alike.items():
            lengths, first = [len(part.states) for part in parts], 0
            states = np.concatenate([part.states for part in parts])
            carried = phase.carried.into_rows(states, np.repeat([part.carried for part in parts], lengths, axis=0))
            taken = np.repeat(np.array([part.taken for part in parts], dtype=self.problem.number), lengths)
            rows = rows_of(phase.kind, phase.ball, self.balls, states, carried, taken, self.problem.number)
            for part, length in zip(parts, lengths, strict=True):
                part.rows, first = rows[first : first + length], first + length
        asked, self.waiting, self.asked, self.count = self.asked, [], [], 0
        if asked:
            times = np.concatenate([times for times, _ in asked])
            self.request.take(times, self._joined([part for _, part in asked]))

    def sampled(self) -> np.ndarray:
        """The samples, as rows."""
        return self._joined(self.samples)

    def passages(self) -> Passages:
        """All passages, their states being rows."""
        none = np.zeros(0, int)
        no_passage = np.zeros(0, self.problem.number), none, none, none > 0
        columns = [no_passage, *(passages[:-1] for passages, _ in self.log)]
        rows = self._joined([part for _, part in self.log])
        return Passages._make((*map(np.concatenate, zip(*columns, strict=True)), rows))

    def _joined(self, parts: list[Part]) -> np.ndarray:
        """The rows of parts, one after another."""
        if not parts:
            return np.zeros((0, len(self.problem.variables.names)), self.problem.number)
        return np.concatenate([part.rows for part in parts])


class _Nobody:
    """Asks for no rows."""

    steps = False

    def wanted(self) -> np.ndarray:
        """Times of none."""
        return np.zeros(0)

    def take(self, times: np.ndarray, states: np.ndarray) -> None:
        """Takes none."""


NOBODY, _NONE, _NO = _Nobody(), np.zeros(0), np.zeros(1, bool)

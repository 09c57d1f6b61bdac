"""Where a run goes as it is made: memory, or a store."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ..columns import Column
from .events import EventTable
from .reporting import RunProgress


class Sink(Protocol):
    """Where a run goes as it is made: memory, or a store."""

    keeps_rows: bool  # whether rows are to be made at all

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows: times [s], and what gives their internal states; it may be called later, in
        another thread.
        """

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes new rows of the event log, and indices of rows that are significant after all."""

    def keyframe(self, row: dict[str, Column]) -> None:
        """Take a keyframe, as a row of its table."""

    def tables(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Take new rows of the tables of a contact that changes its phase, SI."""

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Finish a slice.

        The moment to commit a snapshot, and to raise Interrupted if the run has to stop.
        """


@dataclass
class Memory:
    """Gathers a run in memory; with `keeps_rows=False` only what it reports, however long it is."""

    keeps_rows: bool = True
    times: list[np.ndarray] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    logs: list[EventTable] = field(default_factory=list)
    marks: list[int] = field(default_factory=list)
    others: dict[str, list[dict[str, np.ndarray]]] = field(default_factory=dict)

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Take rows."""
        if self.keeps_rows:
            self.times.append(times)
            self.states.append(states())

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Take rows of the event log."""
        if self.keeps_rows:
            self.logs.append(table)
            self.marks += marks

    def keyframe(self, row: dict[str, Column]) -> None:
        """Drop a keyframe: only stores keep them."""

    def tables(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Take new rows of further tables."""
        for name, columns in new.items():
            self.others.setdefault(name, []).append(columns)

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Commit nothing."""

    def table(self) -> EventTable:
        """Return the event log."""
        log = EventTable.joined(self.logs)
        log.significant[self.marks] = True
        return log

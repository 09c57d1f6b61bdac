"""Destinations of the rows and events of a run; `recording.Recorder` is the one with a store.

`Integration` calls the methods of a sink: rows in internal units with times in seconds, tables in
SI.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from .events import EventTable
from .phases import Rows
from .reporting import RunProgress


class Sink:
    """The base of all sinks, which drops the rows and events of a run."""

    keeps_rows = False
    """True if rows are wanted."""

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Receive rows: times [s] (k,) and internal states (k, variables), in order of time."""

    def add_events(self, table: EventTable, marks: list[int]) -> None:
        """Receive rows of the event log, and indices of rows now known to be significant."""

    def add_tables(self, new: dict[str, Rows]) -> None:
        """Receive rows of the tables of phases, impacts and keyframes, SI."""

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Handle the end of a slice: commit a snapshot, or raise Interrupted to stop.

        snapshot() returns the state that belongs to exactly the rows so far.
        """


class Memory(Sink):
    """A sink that keeps the rows and events of a run in memory."""

    keeps_rows = True

    def __init__(self) -> None:
        self.times: list[np.ndarray] = []
        self.states: list[np.ndarray] = []
        self.logs: list[EventTable] = []
        self.marks: list[int] = []
        self.others: dict[str, list[Rows]] = {}

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Keep rows: times [s] (k,) and internal states (k, variables); they are not copied."""
        self.times.append(times)
        self.states.append(states)

    def add_events(self, table: EventTable, marks: list[int]) -> None:
        """Keep rows of the event log, and marks."""
        self.logs.append(table)
        self.marks += marks

    def add_tables(self, new: dict[str, Rows]) -> None:
        """Keep rows of these tables."""
        for name, columns in new.items():
            self.others.setdefault(name, []).append(columns)

    def table(self) -> EventTable:
        """Return the whole event log, in which marked rows are significant."""
        log = EventTable.joined(self.logs)
        if self.marks:
            log.significant[self.marks] = True
        return log

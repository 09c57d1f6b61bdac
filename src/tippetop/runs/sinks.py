"""Destinations of a run: nowhere, or memory; `recording.Recorder` is a store."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..columns import Column
from .events import EventTable
from .phases import Rows
from .reporting import RunProgress


class Sink:
    """Take a run as it is made, and keep nothing of it: the base of all sinks."""

    keeps_rows = False
    """True if rows are wanted."""

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Take rows: times [s], and a function that returns their internal states.

        It may be called later, in another thread.
        """

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Take new rows of the event log, and indices of rows that are significant after all."""

    def keyframe(self, row: dict[str, Column]) -> None:
        """Take a keyframe, as a row of its table."""

    def tables(self, new: dict[str, Rows]) -> None:
        """Take new rows of the tables of a contact that changes its phase, SI."""

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Finish a slice: the moment to commit a snapshot, or to raise Interrupted."""


class Memory(Sink):
    """Gather a run in memory."""

    keeps_rows = True

    def __init__(self) -> None:
        self.times: list[np.ndarray] = []
        self.states: list[np.ndarray] = []
        self.logs: list[EventTable] = []
        self.marks: list[int] = []
        self.others: dict[str, list[Rows]] = {}

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Take rows."""
        self.times.append(times)
        self.states.append(states())

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Take rows of the event log."""
        self.logs.append(table)
        self.marks += marks

    def tables(self, new: dict[str, Rows]) -> None:
        """Take new rows of further tables."""
        for name, columns in new.items():
            self.others.setdefault(name, []).append(columns)

    def table(self) -> EventTable:
        """Return the event log."""
        log = EventTable.joined(self.logs)
        log.significant[self.marks] = True
        return log

"""Where a run goes as it is made: memory, or a store."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from ..columns import Column
from .events import EventTable


if TYPE_CHECKING:
    from .integration import Integration


class Sink(Protocol):
    """Where a run goes as it is made: memory, or a store."""

    keeps_rows: ClassVar[bool]  # whether rows are to be made at all

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows: times [s], and what gives their internal states; it may be called later, in another thread."""

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes new rows of the event log, and indices of rows that are significant after all."""

    def keyframe(self, columns: dict[str, Column]) -> None:
        """Takes a keyframe, as a row of its table."""

    def more(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Takes new rows of the tables of a contact that changes its phase, SI."""

    def slice_done(self, integration: "Integration") -> None:
        """Called after every slice: the moment to commit, and to raise if the run has to stop."""


@dataclass
class Memory:
    """Gathers a run in memory."""

    times: list[np.ndarray] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    logs: list[EventTable] = field(default_factory=list)
    marks: list[int] = field(default_factory=list)
    others: dict[str, list[dict[str, np.ndarray]]] = field(default_factory=dict)
    keeps_rows: ClassVar[bool] = True

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows."""
        self.times.append(times)
        self.states.append(states())

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes rows of the event log."""
        self.logs.append(table)
        self.marks += marks

    def keyframe(self, columns: dict[str, Column]) -> None:
        """Drops it: they are for stores."""

    def more(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Takes new rows of further tables."""
        for name, columns in new.items():
            self.others.setdefault(name, []).append(columns)

    def slice_done(self, integration: "Integration") -> None:
        """Nothing to commit."""

    def table(self) -> EventTable:
        """The event log."""
        log = EventTable.joined(self.logs)
        log.significant[self.marks] = True
        return log


class Nowhere(Memory):
    """Keeps nothing: for those who want what a run reports, however long it is."""

    keeps_rows: ClassVar[bool] = False

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Drops rows, which then are not even made."""

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Drops rows of the event log."""

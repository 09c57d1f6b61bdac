"""A solution in memory becomes a store: the same files as if the run had been recorded as it went."""

from pathlib import Path
from typing import Any

from ..engine.observables import Observables
from ..store import checkpoint, skeleton, tables
from ..store.checkpoint import END
from ..store.chunks import Appender
from ..store.root import finish, new_store
from .events import EventTable, event_columns
from .integration import Integration
from .recording import EVENTS_PER_CHUNK, rows_per_chunk
from .run import Solution


ROWS_AT_ONCE = 1 << 16  # of which columns are made at a time


def save(solution: Solution, attributes: dict[str, Any], target: str | Path, *, overwrite: bool = False) -> None:
    """Writes a store whole or not at all; `attributes` are its root attributes. Raises StoreError."""
    view, integration = Observables(solution.problem), Integration(solution.problem)
    integration.last_slice, integration.last = solution.last_slice, solution.final[None, :]
    integration.t_end = solution.report["t_end"]
    with new_store(target, overwrite=overwrite) as scratch:
        root = tables.create_root(scratch, attributes)
        empty = view.columns(solution.times[:0], solution.rows[:0])
        Appender.created(root, "trajectory", empty, rows_per_chunk(solution.problem))
        Appender.created(
            root, "events", event_columns(EventTable.empty(solution.problem.system.kinds)), EVENTS_PER_CHUNK
        )
        _, members = tables.open_root(scratch, "trajectory", "events")
        trajectory, events = map(Appender, members)
        for first in range(0, len(solution.times), ROWS_AT_ONCE):
            some = slice(first, first + ROWS_AT_ONCE)
            trajectory.append(view.columns(solution.times[some], solution.rows[some]))
        if len(solution.events.time):
            events.append(event_columns(solution.events))
        for appender in (trajectory, events):
            appender.flush()
            appender.sync()
        of = checkpoint.digest_of_finished(skeleton.root_of(scratch))
        finish(scratch, {END: checkpoint.bound(integration.ending(), of)})

"""A solution in memory becomes a store: the same files as if the run had been recorded as it went."""

from pathlib import Path
from typing import Any

import zarr

from ..engine.observables import View
from ..store.chunks import Appender
from ..store.root import new_store
from .events import event_columns
from .recording import EVENTS_PER_CHUNK, rows_per_chunk
from .run import Solution


ROWS_AT_ONCE = 1 << 16  # of which columns are made at a time


def save(solution: Solution, attributes: dict[str, Any], target: str | Path, *, overwrite: bool = False) -> None:
    """Writes a store whole or not at all; `attributes` are its root attributes. Raises StoreError."""
    view = View(solution.problem)
    with new_store(target, overwrite=overwrite) as scratch, zarr.config.set({"array.write_empty_chunks": True}):
        root = zarr.open_group(store=str(scratch), mode="w", zarr_format=3, attributes=attributes)
        empty = view.columns(solution.times[:0], solution.rows[:0])
        trajectory = Appender.created(root, "trajectory", empty, rows_per_chunk(solution.problem))
        log = event_columns(solution.events)
        events = Appender.created(
            root, "events", {name: c._replace(values=c.values[:0]) for name, c in log.items()}, EVENTS_PER_CHUNK
        )
        for first in range(0, len(solution.times), ROWS_AT_ONCE):
            some = slice(first, first + ROWS_AT_ONCE)
            trajectory.append(view.columns(solution.times[some], solution.rows[some]))
        if len(solution.events.time):
            events.append(log)
        for appender in (trajectory, events):
            appender.flush()
            appender.sync()

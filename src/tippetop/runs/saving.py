"""A solution in memory becomes a store: the same files as if the run had been recorded as it went."""

from pathlib import Path
from typing import Any

from ..engine.observables import Observables
from ..store import checkpoint, skeleton, tables
from ..store.checkpoint import END
from ..store.chunks import Appender
from ..store.root import finish, new_store
from . import phases
from .events import event_columns
from .integration import Integration
from .recording import tables_of_run
from .run import Solution


ROWS_AT_ONCE = 1 << 16  # of which columns are made at a time


def save(solution: Solution, attributes: dict[str, Any], target: str | Path, *, overwrite: bool = False) -> None:
    """Writes a store whole or not at all; `attributes` are its root attributes. Raises StoreError."""
    view, integration = Observables(solution.problem), Integration(solution.problem)
    integration.last_slice, integration.last = solution.last_slice, solution.final[None, :]
    integration.t_end = solution.report["t_end"]
    with new_store(target, overwrite=overwrite) as scratch:
        root = tables.create_root(scratch, attributes)
        with tables.every_chunk():
            appenders = {table[0]: Appender.created(root, *table) for table in tables_of_run(integration)}
        for first in range(0, len(solution.times), ROWS_AT_ONCE):
            some = slice(first, first + ROWS_AT_ONCE)
            appenders["trajectory"].append(view.columns(solution.times[some], solution.rows[some]))
        if len(solution.events.time):
            appenders["events"].append(event_columns(solution.events))
        for name, columns in phases.joined(solution.problem.system, solution.others).items() if solution.others else ():
            appenders[name].append(columns)
        for name, columns in solution.sensitivities.items():
            appenders[name].append(columns)
        for appender in appenders.values():
            appender.flush()
            appender.sync()
        of = checkpoint.digest_of_finished(skeleton.root_of(scratch))
        finish(scratch, {END: checkpoint.bound(integration.ending(), of)})

"""A solution in memory becomes a store: the same files as if the run had been recorded
as it went.
"""

from pathlib import Path
from typing import Any

from ..engine.observables import Observables
from ..store.ledger import Ledger
from ..store.root import new_store
from . import phases, recording
from .events import event_columns
from .integration import Integration
from .run import Solution


ROWS_AT_ONCE = 1 << 16  # of which columns are made at a time


def save(
    solution: Solution, attributes: dict[str, Any], target: str | Path, *, overwrite: bool = False
) -> None:
    """Writes a store whole or not at all; `attributes` are its root attributes.

    Raises StoreError.
    """
    view, integration = Observables(solution.problem), Integration(solution.problem)
    header = recording.header(integration)
    others = phases.joined(solution.problem.system, solution.others) if solution.others else {}
    integration.last_slice, integration.last = solution.last_slice, solution.final[None, :]
    integration.t_end = solution.report["t_end"]
    with (
        new_store(target, overwrite=overwrite) as scratch,
        Ledger.created(scratch, header) as store,
        recording.Recorder(solution.problem, store) as recorder,
    ):
        for first in range(0, len(solution.times), ROWS_AT_ONCE):
            some = slice(first, first + ROWS_AT_ONCE)
            recorder.append("trajectory", view.columns(solution.times[some], solution.rows[some]))
        recorder.append("events", event_columns(solution.events))
        for name, columns in others.items():
            recorder.append(name, columns)
        for name, columns in solution.sensitivities.items():
            recorder.append(name, columns)
        recorder.finish(attributes, integration.ending())

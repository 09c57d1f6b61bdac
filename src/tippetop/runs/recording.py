"""A run becomes a store as it goes: full chunks, a tail of what waits, and records that acknowledge
both.
"""

import json
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..awaiting import awaited
from ..columns import Column
from ..engine.observables import Observables
from ..errors import Interrupted
from ..problem import Problem
from ..store import files, ledger, provenance, zarr3
from ..store.ledger import Ledger
from ..store.root import finite
from ..store.table import LATE, Table
from ..store.writer import Writer, begin
from . import attributes, keyframes, phases, reporting, sensitivities
from .events import EventTable, event_columns
from .integration import Integration
from .reporting import RunProgress


ROWS_PER_CHUNK = 1 << 16  # of the trajectory: 512 KiB a column
EVENTS_PER_CHUNK = 1 << 14
SIGNIFICANT = "significant"  # a column of events that may change in any row until the end of a run
# [s] of the clock: what an interruption can cost; when commits happen does not show in the store
COMMIT_EVERY = 5.0
PATIENCE = (
    2.0  # [s] after which a stop does not wait for the end of a slice: its rows are made again
)

FINISHED = "The run is finished and whole; only temporary files are left in it."

Progress = Callable[[RunProgress], None]


class Recorder(Writer):
    """The sink of a run that writes its store."""

    keeps_rows = True

    def __init__(self, problem: Problem, store: Ledger, stop: threading.Event | None = None):
        super().__init__(store)
        self.problem, self.view, self.stop = problem, Observables(problem), stop
        self.growing = {name: Table(store, name) for name in store.state.header["tables"]}
        self.begun_with: list[
            dict[str, Any]
        ] = []  # versions and processors of those that wrote it before
        self.committed_at, self.asked = time.monotonic(), 0.0

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows.

        Raises Interrupted where a slice has so many that its end cannot be waited for.
        """
        if self.stop is not None and self.stop.is_set():
            self.asked = self.asked or time.monotonic()
            if time.monotonic() - self.asked > PATIENCE:
                raise Interrupted
        self.later(lambda: self.append("trajectory", self.view.columns(times, states())))

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes rows of the event log."""
        if len(table.time):
            self.later(lambda: self.append("events", event_columns(table)))
        if marks:
            self.later(lambda: self.mark(marks))

    def keyframe(self, row: dict[str, Column]) -> None:
        """Take a keyframe."""
        self.later(lambda: self.append("keyframes", row))

    def tables(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Takes rows of further tables."""
        for name, table in new.items():
            if len(next(iter(table.values()))):
                self.later(
                    partial(self.append, name, phases.columns(self.problem.system, name, table))
                )

    def append(self, name: str, columns: dict[str, Column]) -> None:
        """Append rows to a table."""
        values = {key: column.values for key, column in columns.items()}
        for part in self.growing.keys() & {name, name + LATE}:
            self.growing[part].append(values)

    def mark(self, rows: list[int], value: bool = True) -> None:
        """Set the flags of some events."""
        self.growing["events" + LATE].mark(SIGNIFICANT, rows, value)

    def derivatives(self) -> None:
        """Makes the tables of derivatives, where the run has come to its end, from its rows and its
        log there.
        """
        problem = self.problem
        if not problem.sensitivities:
            return
        self.now(lambda: None)
        log = EventTable.empty(problem.system.kinds)
        parts = [self.growing["events"], self.growing["events" + LATE]]
        stored = {name: part.values(name) for part in parts for name in part.documents}
        table = EventTable(log.kinds, *(stored[name] for name in log.columns()))
        times = problem.times[: self.growing["trajectory"].rows]
        make = partial(sensitivities.tables, problem, times, table)
        derived = awaited(make, "the derivatives of the run are being computed", self.stop)
        for name, columns in derived.items():
            self.later(partial(self.append, name, columns))

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Commit now and then; stop at a commit if asked to."""
        asked = self.stop is not None and self.stop.is_set()
        if asked or time.monotonic() - self.committed_at > COMMIT_EVERY:
            self.commit(progress, snapshot())
        if asked:
            raise Interrupted

    def commit(self, progress: RunProgress, snapshot: dict[str, Any]) -> None:
        """Acknowledge all rows, and the state from which the run can be continued."""
        changed = {
            "report": finite(reporting.report(progress)),
            "reason": reporting.reason(progress),
        }

        def work() -> None:
            self.store.commit(self.tail(snapshot), rows=self.counts(), changed=changed)
            self.derive()

        self.now(work)
        self.committed_at = time.monotonic()

    def tail(self, snapshot: dict[str, Any]) -> bytes:
        """Return the rows that no chunk holds, and the state of the run."""
        state = {
            **here(),
            "begun_with": self.begun_with,
            "integration": snapshot,
            "tables": {name: [table.written, table.rows] for name, table in self.growing.items()},
        }
        head = json.dumps(state, allow_nan=False).encode() + b"\n"
        return head + b"".join(table.tail() for table in self.growing.values())

    def restore(self, tail: bytes) -> None:
        """Take back the rows of a tail."""
        head, _, data = tail.partition(b"\n")
        state = json.loads(head)
        for name, (written, rows) in state["tables"].items():
            data = self.growing[name].restore(written, rows, data)

    def derive(self) -> None:
        """Write what readers of an unfinished store need, and nobody else."""
        self.store.derive(
            {file: data for table in self.growing.values() for file, data in table.derived()}
        )

    def counts(self) -> dict[str, int]:
        """Return the rows of all tables, by the names that the ledger has."""
        return {name: table.rows for name, table in self.growing.items()}

    def finish(self, attrs: dict[str, Any], ending: dict[str, Any]) -> dict[str, Any]:
        """Write waiting rows, and close the store with its last root attributes; return them."""
        attrs = finite(attrs) | ({"begun_with": self.begun_with} if self.begun_with else {})

        def work() -> None:
            for table in self.growing.values():
                table.finish()
            begun = self.store.state.header["attributes"]
            changed = {
                key: value
                for key, value in attrs.items()
                if key not in begun or begun[key] != value
            }
            try:
                self.store.finish(changed, rows=self.counts(), end=ending)
            except OSError:
                with files.writing(self.store.path, FINISHED if self.store.state.closing else ""):
                    raise

        self.now(work)
        return self.store.state.attributes


def record(
    problem: Problem,
    target: Path,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    in_sweep: bool = False,
) -> tuple[Integration, dict[str, Any]]:
    """Integrates a problem into a new store, in any thread.

    Parameters
    ----------
    problem
        What to integrate.
    target
        The store to make.
    overwrite
        Whether a store that is there may be replaced; not while another process writes it.
    in_sweep
        Whether the target lies in the store of a sweep, which writes it.
    progress
        Called after every slice.
    stop
        Set it, from a signal handler or another thread, and the run stops at a commit within a
        slice; before its first step, if it is set already. An exception such as KeyboardInterrupt
        leaves the store as it was at the last commit. Either way it can be resumed.

    Returns
    -------
    Integration, dict
        The run at its end, and the root attributes of the store.

    Raises
    ------
    StoreError
        The store exists, or cannot be written.
    Interrupted
        `stop` was set.
    """
    begun: list[Integration] = []

    def head() -> dict[str, Any]:
        begun.append(Integration(problem, stop))
        return header(begun[0])

    store = begin(target, head, overwrite=overwrite, in_sweep=in_sweep)
    return run_into(begun[0], store, progress, stop)


def header(integration: Integration) -> dict[str, Any]:
    """Return the header of the ledger of a run, from an integration at its start."""
    return header_of(
        finite(attributes.attributes(integration.progress())), tables_of_run(integration)
    )


def header_of(
    attrs: dict[str, Any],
    tables: Iterable[tuple[str, dict[str, Column], int]],
    late: str = SIGNIFICANT,
) -> dict[str, Any]:
    """Return the header of a ledger with these tables: name, columns without rows, rows
    of a chunk.
    """
    parts: dict[str, dict[str, Any]] = {}
    for name, columns, chunk in tables:
        for key, column in columns.items():
            array = zarr3.array(column, {column.dims[0]: (0, chunk)})
            parts.setdefault(name + LATE if key == late else name, {})[f"{name}/{key}"] = array
    return ledger.header(attrs, parts)


def tables_of_run(integration: Integration) -> Iterator[tuple[str, dict[str, Column], int]]:
    """The groups of a run: name, columns without rows, rows of a chunk."""
    empty = integration.view.columns(np.zeros(0), integration.first[:0])
    yield "trajectory", empty, ROWS_PER_CHUNK
    yield "events", event_columns(integration.log.empty), EVENTS_PER_CHUNK
    for name, columns in phases.empty(integration.problem.system).items():
        yield name, columns, phases.PER_CHUNK
    for name, columns in sensitivities.no_rows(
        integration.problem, integration.log.empty.kinds
    ).items():
        yield name, columns, sensitivities.PER_CHUNK
    if integration.problem.output == "keyframes":
        yield (
            "keyframes",
            keyframes.empty(integration.problem, integration.driver),
            keyframes.PER_CHUNK,
        )


def here() -> dict[str, Any]:
    """What the bits of a run depend on beside its scenario."""
    return {"versions": provenance.versions(), "cpu": provenance.cpu()}


def run_into(
    integration: Integration,
    store: Ledger,
    progress: Progress | None,
    stop: threading.Event | None,
    take_up: Callable[[Recorder], None] | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Integrates into an open store: from its start, or from where `take_up` puts it."""
    remedy = f"Nothing acknowledged is lost: tippetop resume {store.path}"
    with files.writing(store.path, remedy), Recorder(integration.problem, store, stop) as recorder:
        if take_up is not None:
            take_up(recorder)
        if stop is not None and stop.is_set():
            raise Interrupted
        integration.run(recorder, progress)
        recorder.derivatives()
        attrs = attributes.attributes(integration.progress())
        return integration, recorder.finish(attrs, integration.ending())

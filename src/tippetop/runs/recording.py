"""Write a run to a store while it is integrated.

Rows are gathered in tables. Full chunks go to files immediately; every few seconds a commit
acknowledges them, together with a tail: the rows that fill no chunk yet, and the state of the run.
"""

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from ..arguments import PlainData
from ..columns import Column, without_rows
from ..engine.observables import Observables
from ..errors import Interrupted
from ..problem import Problem
from ..store import files, ledger, provenance, zarr3
from ..store.ledger import Ledger
from ..store.root import finite, new_store
from ..store.table import LATE, Table
from ..store.writer import Writer, begin
from . import attributes, keyframes, phases, reporting
from .events import EventTable
from .integration import Integration
from .phases import Rows
from .reporting import Progress, RunProgress
from .run import Solution
from .sinks import Sink


# Rows per chunk of the trajectory: 512 KiB a column.
ROWS_PER_CHUNK = 1 << 16
EVENTS_PER_CHUNK = 1 << 14
# A column of events that may change in any row until the end of a run.
SIGNIFICANT = "significant"
# A slice that ends later than this [s] after a commit is followed by the next one; the times of
# commits do not show in the store.
COMMIT_EVERY = 5.0
# After this time [s] a stop does not wait for the end of a slice: its rows are made again.
PATIENCE = 2.0


class Recorder(Writer, Sink):
    """A sink that writes the store of a run, on a thread.

    `run_into` makes it for a run, `replay` a subclass. Work is queued by `later` for the thread of
    the store's `Writer`.
    """

    keeps_rows = True

    def __init__(self, problem: Problem, store: Ledger, stop: threading.Event | None = None):
        """Make an empty table for each of the ledger's header, in its order: that of a tail."""
        super().__init__(store)
        self.problem = problem
        self.view = Observables(problem)
        self.stop = stop or threading.Event()
        self.growing = {name: Table(store, name) for name in store.state.header["tables"]}
        # Versions and processors that wrote the store before.
        self.begun_with: list[PlainData] = []
        self.committed_at = time.monotonic()
        self.asked = 0.0  # [s], monotonic: when `add_rows` first found `stop` set; 0: not yet

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Write rows: times [s] and internal states.

        Raises Interrupted if a stop has waited longer than PATIENCE for the end of a slice. The
        work is queued, so the arrays must not change afterwards.
        """
        if self.stop.is_set():
            self.asked = self.asked or time.monotonic()
            if time.monotonic() - self.asked > PATIENCE:
                raise Interrupted
        self.later(lambda: self._append("trajectory", self.view.columns(times, states)))

    def add_events(self, table: EventTable, marks: list[int]) -> None:
        """Write rows of the event log, and mark rows, by their numbers in it, as significant."""
        if len(table.time):
            self.later(lambda: self._append("events", table))
        if marks:
            self.later(lambda: self.mark(marks))

    def add_tables(self, new: dict[str, Rows]) -> None:
        """Write rows of phases, impacts and keyframes: columns in SI by table and name."""
        for name, table in new.items():
            if len(next(iter(table.values()))):
                self.later(partial(self.growing[name].append, table))

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], PlainData]) -> None:
        """Commit every few seconds; if `stop` is set, commit and raise Interrupted.

        `snapshot` is as for `Sink.slice_done`; it is called only for a commit.
        """
        asked = self.stop.is_set()
        if asked or time.monotonic() - self.committed_at > COMMIT_EVERY:
            self.commit(progress, snapshot())
        if asked:
            raise Interrupted

    def _append(self, name: str, columns: Mapping[str, Column]) -> None:
        """Append rows to the table of this name, and to that of its late columns.

        Late columns, such as `significant`, change after their rows are written, so their chunks
        are written at the end.
        """
        values = {key: column.values for key, column in columns.items()}
        for part in self.growing.keys() & {name, name + LATE}:
            self.growing[part].append(values)

    def mark(self, rows: list[int], value: bool = True) -> None:
        """Set the flag `significant` of the events in these rows of the log."""
        self.growing["events" + LATE].mark(SIGNIFICANT, rows, value)

    def commit(self, progress: RunProgress, snapshot: PlainData) -> None:
        """Acknowledge all rows so far, and the state from which the run can be continued.

        Returns once they are on the disk. `snapshot` must belong to exactly these rows, as after a
        slice. Report and reason are for readers of an unfinished store, whose `status` is running.
        """
        changed = {
            "report": finite(reporting.report(progress)),
            "reason": reporting.reason(progress),
        }

        def work() -> None:
            """Commit, then write what readers need; on the writer's thread."""
            self.store.commit(self.tail(snapshot), rows=self.counts(), changed=changed)
            self.derive()

        self.now(work)
        self.committed_at = time.monotonic()

    def tail(self, snapshot: PlainData) -> bytes:
        """Return the tail of a commit: a line of JSON with the state of the run, then rows.

        The rows are those that no chunk contains, and `restore` reads them. The keys are a stored
        format: `resume` reads all but `tables`.
        """
        state = {
            **here(),
            "begun_with": self.begun_with,
            "integration": snapshot,
            "tables": {name: [table.written, table.rows] for name, table in self.growing.items()},
        }
        head = json.dumps(state, allow_nan=False).encode() + b"\n"
        return head + b"".join(table.tail() for table in self.growing.values())

    def restore(self, tail: bytes) -> None:
        """Load the rows of a tail, as `tail` returned it, into the tables, which must be empty.

        Tables follow one another in the order in which the line of JSON lists them.
        """
        head, _, data = tail.partition(b"\n")
        for name, (written, rows) in json.loads(head)["tables"].items():
            data = self.growing[name].restore(written, rows, data)

    def derive(self) -> None:
        """Write the files that only readers of an unfinished store need."""
        self.store.derive(
            {file: data for table in self.growing.values() for file, data in table.derived()}
        )

    def counts(self) -> dict[str, int]:
        """Return the rows of all tables, by their names in the ledger."""
        return {name: table.rows for name, table in self.growing.items()}

    def finish(self, attrs: PlainData, ending: PlainData | None) -> PlainData:
        """Write waiting rows, and close the store with its last root attributes; return them.

        `ending` is what `Integration.encoded` returns, from which `resume` extends the run; None of
        a replay, which cannot be extended. `attrs` are all attributes that differ from the header,
        because the seal drops the changes of earlier commits (`Acknowledged.add`). A replay passes
        no `attrs`: its header has them already.
        """
        attrs = attrs | ({"begun_with": self.begun_with} if self.begun_with else {})

        def work() -> None:
            """Write the last rows and the seal of the store; on the writer's thread."""
            for table in self.growing.values():
                table.finish()
            begun = self.store.state.header["attributes"]
            changed = {k: v for k, v in attrs.items() if k not in begun or begun[k] != v}
            self.store.finish(changed, rows=self.counts(), end=ending)

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
) -> tuple[Integration, PlainData]:
    """Integrate a problem into a new store, in any thread.

    Parameters
    ----------
    problem
        The run.
    target
        The store to make.
    overwrite
        Whether an existing store may be replaced; not while another process writes it.
    progress
        Called after every slice.
    stop
        Set it, from a signal handler or another thread, to stop the run with a commit within a
        slice; if it is set already, before the first step. An exception such as KeyboardInterrupt
        leaves the store as it was at the last commit. In both cases the run can be resumed.
    in_sweep
        Whether the target lies in the store of a sweep, which writes it.

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

    def head() -> PlainData:
        """Return the header of the store.

        `begin` calls it after it has refused a bad target, as compiling takes seconds.
        """
        begun.append(Integration(problem, stop))
        return header(begun[0])

    store = begin(target, head, overwrite=overwrite, in_sweep=in_sweep)
    return run_into(begun[0], store, progress, stop)


def run_into(
    integration: Integration,
    store: Ledger,
    progress: Progress | None,
    stop: threading.Event | None,
    take_up: Callable[[Recorder], None] = lambda _: None,
) -> tuple[Integration, PlainData]:
    """Integrate into an open store; return the integration and the last root attributes.

    `take_up` is called with the Recorder first, before a stop is obeyed: in `resume` it sets the
    state from which the run continues. `stop` and `progress` are as for `record`.
    """
    remedy = f"Nothing acknowledged is lost: tippetop resume {store.path}"
    with files.writing(store.path, remedy), Recorder(integration.problem, store, stop) as recorder:
        take_up(recorder)
        if recorder.stop.is_set():
            raise Interrupted
        integration.run(recorder, progress)
        attrs = attributes.attributes(integration.progress())
        return integration, recorder.finish(attrs, integration.encoded(integration.ending()))


def save(
    solution: Solution, attrs: PlainData, target: str | Path, *, overwrite: bool = False
) -> None:
    """Write a run in memory as the store that `record` makes, whole or not at all.

    `attrs` are its root attributes, of `attributes.attributes` and perhaps a certificate. Nothing
    is integrated again: the `Integration` makes the header. Raises StoreError.
    """
    integration = Integration(solution.problem)
    head = header(integration)
    with (
        new_store(target, overwrite=overwrite) as scratch,
        Recorder(solution.problem, Ledger.created(scratch, head)) as recorder,
    ):
        for first in range(0, len(solution.times), ROWS_PER_CHUNK):
            some = slice(first, first + ROWS_PER_CHUNK)
            recorder.add_rows(solution.times[some], solution.rows[some])
        recorder.add_events(solution.events, [])
        for name, parts in solution.others.items():
            for part in parts:
                recorder.add_tables({name: part})
        recorder.finish(attrs, integration.encoded(solution.ending))


def header(integration: Integration, attrs: PlainData | None = None) -> PlainData:
    """Return the header of the ledger of a run, from an integration at its start.

    `attrs` are root attributes other than its own, in a replay those of its run. `resume` makes the
    header again and requires equal documents, so old stores need the same.
    """
    tables: dict[str, PlainData] = {}
    for name, columns, chunk in _tables_of(integration):
        for key, column in columns.items():
            table = name + LATE if key == SIGNIFICANT else name
            array = zarr3.array(column, {column.dims[0]: (0, chunk)})
            tables.setdefault(table, {})[f"{name}/{key}"] = array
    attrs = attrs or attributes.attributes(integration.progress())
    return ledger.header(attrs, tables)


def _tables_of(integration: Integration) -> Iterator[tuple[str, dict[str, Column], int]]:
    """Yield the tables of a run's store: name, columns without rows, rows per chunk.

    `header` moves columns whose values change later to a second table of the group, name + LATE.
    """
    problem = integration.problem
    empty = integration.view.columns(np.zeros(0), integration.first[:0])
    yield "trajectory", empty, ROWS_PER_CHUNK
    yield "events", integration.log.empty, EVENTS_PER_CHUNK
    for name, columns in phases.joined(problem.system, {}).items():
        yield name, columns, phases.PER_CHUNK
    if problem.output == "keyframes":
        row = keyframes.columns(problem, integration.driver, 0.0, 0)
        yield "keyframes", without_rows(row), keyframes.PER_CHUNK


def here() -> PlainData:
    """Return the versions and the processor, which determine the bits of a run with its scenario.

    `resuming.same_here` compares these keys with those of root attributes and of tails.
    """
    return {"versions": provenance.versions(), "cpu": provenance.cpu()}

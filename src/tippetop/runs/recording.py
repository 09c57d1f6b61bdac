"""A run becomes a store as it goes: rows and events in whole chunks, a checkpoint that acknowledges them, a lock."""

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..awaiting import awaited
from ..columns import Column
from ..engine.observables import Observables
from ..errors import Interrupted
from ..problem import Problem
from ..store import checkpoint, files, provenance, skeleton, tables
from ..store.checkpoint import CHECKPOINT, END, ROWS
from ..store.chunks import Appender
from ..store.lock import LOCK, Lock
from ..store.root import finish, finite, new_store
from . import attributes, keyframes, phases, reporting, sensitivities
from .events import EventTable, event_columns
from .integration import Integration
from .reporting import RunProgress


MOST_ROWS, FEWEST_ROWS = 1 << 18, 1 << 10  # of a chunk: 2 MiB a column take a third less than twice 1 MiB
EVENTS_PER_CHUNK = 16_384
COMMIT_EVERY = 5.0  # [s] of the clock: what an interruption can cost; when commits happen does not show in the store
PATIENCE = 2.0  # [s] after which a stop does not wait for the end of a slice: its rows are made again
FINISHED = "The run is finished and whole; only temporary files are left in it."

Progress = Callable[[RunProgress], None]


class Recorder:
    """The sink of a run that writes its store. A context; when it ends nothing is being written any more.

    All writing is done in one thread of its own: it follows the integration, and no KeyboardInterrupt enters it.
    """

    keeps_rows = True

    def __init__(
        self,
        problem: Problem,
        appenders: dict[str, Appender],
        lock: Lock,
        stop: threading.Event | None = None,
    ):
        self.problem, self.view = problem, Observables(problem)
        self.appenders, self.lock, self.stop = appenders, lock, stop
        self.of = checkpoint.digest(skeleton.root_of(lock.folder))
        self.begun_with: list[dict[str, Any]] = []  # versions and processors of those that wrote it before
        self.behind: deque[Future] = deque()
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")
        self.committed_at, self.asked = time.monotonic(), 0.0

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows. Raises Interrupted where a slice has so many that its end cannot be waited for."""
        if self.stop is not None and self.stop.is_set():
            self.asked = self.asked or time.monotonic()
            if time.monotonic() - self.asked > PATIENCE:
                raise Interrupted
        self._later(lambda: self.appenders["trajectory"].append(self.view.columns(times, states())))

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes rows of the event log."""
        if len(table.time):
            self._later(lambda: self.appenders["events"].append(event_columns(table)))
        if marks:
            self._later(lambda: self.appenders["events"].mark("significant", marks))

    def keyframe(self, row: dict[str, Column]) -> None:
        """Take a keyframe."""
        self._later(lambda: self.appenders["keyframes"].append(row))

    def tables(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Takes rows of further tables."""
        for name, table in new.items():
            if len(next(iter(table.values()))):
                self._later(partial(self.appenders[name].append, phases.columns(self.problem.system, name, table)))

    def derivatives(self) -> None:
        """Makes the tables of derivatives, where the run has come to its end, from its rows and its log there."""
        problem = self.problem
        if not problem.sensitivities:
            return
        self._now(lambda: None)
        arrays, log = self.appenders["events"].arrays, EventTable.empty(problem.system.kinds)
        events = EventTable(log.kinds, *(arrays[name][:] for name in log.columns()))
        times = problem.times[: self.appenders["trajectory"].rows]
        make = partial(sensitivities.tables, problem, times, events)
        derived = awaited(make, "the derivatives of the run are being computed", self.stop)
        for name, columns in derived.items():
            self._later(partial(self.appenders[name].append, columns))

    def _later(self, work: Callable[[], None]) -> None:
        """Queues work for the writing thread, not more than a few slices ahead; raises what went wrong there."""
        while len(self.behind) > 8 or (self.behind and self.behind[0].done()):
            self.behind.popleft().result()
        self.behind.append(self.thread.submit(work))

    def _now(self, work: Callable[[], None]) -> None:
        """Does work in the writing thread once all that was queued is on the disk; returns when it is done. Where
        anything went wrong before, that is raised, and the work is not begun."""
        while self.behind:
            self.behind.popleft().result()

        def flushed() -> None:
            self.lock.check()
            for appender in self.appenders.values():
                appender.flush()
                appender.sync()
            work()

        self.thread.submit(flushed).result()

    def slice_done(self, progress: RunProgress, snapshot: Callable[[], dict[str, Any]]) -> None:
        """Commit now and then; stop at a commit if asked to."""
        asked = self.stop is not None and self.stop.is_set()
        if asked or time.monotonic() - self.committed_at > COMMIT_EVERY:
            self.commit(progress, snapshot())
        if asked:
            raise Interrupted

    def commit(self, progress: RunProgress, snapshot: dict[str, Any]) -> None:
        """Write data first, then the record that acknowledges it."""
        state = {
            "integration": snapshot,
            "report": finite(reporting.report(progress)),
            "reason": reporting.reason(progress),
        }
        self._now(lambda: self._acknowledge(state))
        self.committed_at = time.monotonic()

    def _acknowledge(self, state: dict[str, Any]) -> None:
        record = {
            "format_version": provenance.FORMAT_VERSION,
            **here(),
            "begun_with": self.begun_with,
            **{count: self.appenders[name].rows if name in self.appenders else 0 for name, count in ROWS.items()},
            "digests": {name: appender.digest() for name, appender in self.appenders.items()},
            **state,
        }
        checkpoint.write(self.lock.folder, record, self.of)

    def finish(self, progress: RunProgress, ending: dict[str, Any]) -> dict[str, Any]:
        """Write waiting rows and the root attributes, remove the checkpoint; return the attributes."""
        attrs = finite(attributes.attributes(progress))
        if self.begun_with:
            attrs["begun_with"] = self.begun_with
        self._now(lambda: self._close(attrs, ending))
        return attrs

    def _close(self, attrs: dict[str, Any], ending: dict[str, Any]) -> None:
        of = checkpoint.digest_of_finished({**skeleton.root_of(self.lock.folder), **attrs})
        finish(self.lock.folder, {**attrs, END: checkpoint.bound(ending, of)})
        with files.writing(self.lock.folder, FINISHED):
            _tidy(self.lock)

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.shutdown(cancel_futures=True)


def tidy(folder: Path) -> None:
    """Remove the temporary files that a killed writer left in a finished run. Raises StoreError."""
    if any((folder / left).exists() for left in (CHECKPOINT, LOCK)):
        with files.writing(folder), Lock(folder) as lock:
            _tidy(lock)


def _tidy(lock: Lock) -> None:
    """Remove the temporary files of a finished run, the lock last. Raises OSError."""
    files.remove_scratch(lock.folder)
    (lock.folder / CHECKPOINT).unlink(missing_ok=True)
    lock.remove()


def rows_per_chunk(problem: Problem) -> int:
    """The rows of a chunk of the trajectory: all that are asked for, up to `MOST_ROWS`."""
    asked = len(problem.times) if problem.output == "times" else MOST_ROWS // 4
    return min(MOST_ROWS, max(FEWEST_ROWS, 1 << (asked - 1).bit_length()))


def record(
    problem: Problem,
    target: Path,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
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
    progress
        Called after every slice.
    stop
        Set it, from a signal handler or another thread, and the run stops at a commit within a slice; before its first
        step, if it is set already. An exception such as KeyboardInterrupt leaves the store as it was at the last
        commit. Either way it can be resumed.

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
    with contextlib.ExitStack() as held:
        with new_store(target, overwrite=overwrite) as scratch:
            integration = Integration(problem, stop)
            root = tables.create_root(scratch, finite(attributes.attributes(integration.progress())))
            lock = held.enter_context(Lock(scratch))
            with tables.every_chunk():
                appenders = {table[0]: Appender.created(root, *table) for table in tables_of_run(integration)}
            with Recorder(problem, appenders, lock) as recorder:
                recorder.commit(integration.progress(), integration.snapshot())
        lock.folder = Path(target)
        tables.moved(root, lock.folder)
        return run_into(integration, lock, progress, stop, appenders=appenders)


def tables_of_run(integration: Integration) -> Iterator[tuple[str, dict[str, Column], int]]:
    """The groups of a run: name, columns without rows, rows of a chunk."""
    empty = integration.view.columns(np.zeros(0), integration.first[:0])
    yield "trajectory", empty, rows_per_chunk(integration.problem)
    yield "events", event_columns(integration.log.empty), EVENTS_PER_CHUNK
    for name, columns in phases.empty(integration.problem.system).items():
        yield name, columns, phases.PER_CHUNK
    for name, columns in sensitivities.no_rows(integration.problem, integration.log.empty.kinds).items():
        yield name, columns, sensitivities.PER_CHUNK
    if integration.problem.output == "keyframes":
        yield "keyframes", keyframes.empty(integration.problem, integration.driver), keyframes.PER_CHUNK


def here() -> dict[str, Any]:
    """What the bits of a run depend on beside its scenario."""
    return {"versions": provenance.versions(), "cpu": provenance.cpu()}


def run_into(
    integration: Integration,
    lock: Lock,
    progress: Progress | None,
    stop: threading.Event | None,
    begin: Callable[[Recorder], None] | None = None,
    appenders: dict[str, Appender] | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Integrates into a store that is there, whose lock is held: from its start, where it has just been made with these
    tables, or from where `begin` puts it."""
    folder = lock.folder
    with files.writing(folder, f"Nothing acknowledged is lost: tippetop resume {folder}"), lock.guarded():
        if appenders is None:
            names = [name for name, *_ in tables_of_run(integration)]
            appenders = dict(zip(names, map(Appender, tables.open_root(folder, *names)[1]), strict=True))
        with Recorder(integration.problem, appenders, lock, stop) as recorder:
            if begin is not None:
                begin(recorder)
            if stop is not None and stop.is_set():
                raise Interrupted
            integration.run(recorder, progress)
            recorder.derivatives()
            return integration, recorder.finish(integration.progress(), integration.ending())

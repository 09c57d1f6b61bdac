"""A run becomes a store as it goes: rows and events in whole chunks, a checkpoint that acknowledges them, a lock."""

import contextlib
import json
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..engine.status import Status
from ..errors import Interrupted, StoreError
from ..problem import Problem
from ..scenario import build
from ..store import chunks, files, provenance, tables
from ..store.chunks import Appender
from ..store.files import LOCK, Lock
from ..store.root import CHECKPOINT, finite, new_store
from ..store.root import attributes as read_attributes
from . import attributes
from .events import EventTable, event_columns
from .integration import Integration


MOST_ROWS, FEWEST_ROWS = 1 << 18, 1 << 10  # of a chunk: 2 MiB a column take a third less than twice 1 MiB
EVENTS_PER_CHUNK = 16_384
COMMIT_EVERY = 5.0  # [s] of the clock: what an interruption can cost; when commits happen does not show in the store
PATIENCE = 2.0  # [s] after which a stop does not wait for the end of a slice: its rows are made again

Progress = Callable[[Integration], None]


class Recorder:
    """The sink of a run that writes its store. A context; when it ends nothing is being written any more.

    All writing is done in one thread of its own: it follows the integration, and no KeyboardInterrupt enters it.
    """

    keeps_rows: ClassVar[bool] = True

    def __init__(
        self,
        integration: Integration,
        trajectory: Appender,
        events: Appender,
        lock: Lock,
        stop: threading.Event | None = None,
    ):
        self.integration, self.lock, self.stop = integration, lock, stop
        self.trajectory, self.log = trajectory, events
        self.behind: deque[Future] = deque()
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")
        self.committed_at, self.asked = time.monotonic(), 0.0

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows. Raises Interrupted where a slice has so many that its end cannot be waited for."""
        if self.stop is not None and self.stop.is_set():
            self.asked = self.asked or time.monotonic()
            if time.monotonic() - self.asked > PATIENCE:
                raise Interrupted
        self._later(lambda: self.trajectory.append(self.integration.view.columns(times, states())))

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Takes rows of the event log."""
        if len(table.time):
            self._later(lambda: self.log.append(event_columns(table)))
        if marks:
            self._later(lambda: self.log.mark("significant", marks))

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
            for appender in (self.trajectory, self.log):
                appender.flush()
                appender.sync()
            work()

        self.thread.submit(flushed).result()

    def slice_done(self, integration: Integration) -> None:
        """Commits now and then; stops at a commit if asked to."""
        asked = self.stop is not None and self.stop.is_set()
        if asked or time.monotonic() - self.committed_at > COMMIT_EVERY:
            self.commit()
        if asked:
            raise Interrupted

    def commit(self) -> None:
        """Data first, then the record that acknowledges it."""
        state = {
            "integration": self.integration.snapshot(),
            "report": finite(self.integration.report()),
            "reason": self.integration.reason(),
        }
        self._now(lambda: self._acknowledge(state))
        self.committed_at = time.monotonic()

    def _acknowledge(self, state: dict[str, Any]) -> None:
        record = {
            "format_version": provenance.FORMAT_VERSION,
            "versions": provenance.versions(),
            "cpu": provenance.cpu(),
            "rows": self.trajectory.rows,
            "events": self.log.rows,
            **state,
        }
        files.replace_text(self.lock.folder / CHECKPOINT, json.dumps(record, allow_nan=False))

    def finish(self, root: Any) -> dict[str, Any]:
        """Writes what waits and the root attributes, takes the checkpoint away; gives the attributes back."""
        attrs = _attributes(self.integration)
        self._now(lambda: self._close(root, attrs))
        return attrs

    def _close(self, root: Any, attrs: dict[str, Any]) -> None:
        root.update_attributes(attrs)
        files.remove_scratch(self.lock.folder)
        (self.lock.folder / CHECKPOINT).unlink(missing_ok=True)
        self.lock.remove()

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.shutdown(cancel_futures=True)


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
        Set it, from a signal handler or another thread, and the run stops at a commit within a slice. An exception
        such as KeyboardInterrupt leaves the store as it was at the last commit. Either way it can be resumed.

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
            root = tables.create_root(scratch, _attributes(integration))
            lock = held.enter_context(Lock(scratch))
            empty = integration.view.columns(np.zeros(0), integration.first[:0])
            trajectory = Appender.created(root, "trajectory", empty, rows_per_chunk(problem))
            events = Appender.created(root, "events", event_columns(integration.log.empty), EVENTS_PER_CHUNK)
            with Recorder(integration, trajectory, events, lock) as recorder:
                recorder.commit()
        lock.folder = Path(target)
        return _run(integration, lock, progress, stop)


def resume(
    target: Path, progress: Progress | None = None, *, stop: threading.Event | None = None
) -> tuple[Integration, dict[str, Any]]:
    """Continues an interrupted run, in any thread: arguments and results as those of `record`.

    Raises
    ------
    StoreError
        The store is finished, damaged, being written, or cannot be written.
    Interrupted
        `stop` was set.
    InputError
        The scenario in the store is not one of this release.
    """
    target, attrs = Path(target), read_attributes(target)
    if attrs["status"] != Status.RUNNING.value:
        for left in (CHECKPOINT, LOCK):  # killed after its last word, before it could tidy up
            (target / left).unlink(missing_ok=True)
        raise StoreError(f"`{target}` must be unfinished to be resumed, but: {attrs['reason']}.")
    integration = Integration(build.problem(build.tables_of(attrs)), stop)
    with contextlib.ExitStack() as held:
        with files.writing(target):
            lock = held.enter_context(Lock(target))
        return _run(integration, lock, progress, stop, resumed=True)


def _run(
    integration: Integration,
    lock: Lock,
    progress: Progress | None,
    stop: threading.Event | None,
    *,
    resumed: bool = False,
) -> tuple[Integration, dict[str, Any]]:
    folder = lock.folder
    with files.writing(folder, f"Nothing acknowledged is lost: tippetop resume {folder}"):
        root, tables_of_run = tables.open_root(folder, "trajectory", "events")
        trajectory, events = map(Appender, tables_of_run)
        with Recorder(integration, trajectory, events, lock, stop) as recorder:
            if resumed:
                _go_back(recorder)
            integration.run(recorder, progress)
            return integration, recorder.finish(root)


def _go_back(recorder: Recorder) -> None:
    """Brings a store back to its checkpoint: rows that were not acknowledged go, the rest is read once and checked."""
    target = recorder.lock.folder
    try:
        kept = json.loads((target / CHECKPOINT).read_text(encoding="utf-8"))
        recorder.integration.restore(kept["integration"])
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(
            f"`{target}` must have a whole checkpoint of this release to be resumed, but: {error}."
        ) from None
    files.remove_scratch(target)
    for appender, rows in ((recorder.trajectory, kept["rows"]), (recorder.log, kept["events"])):
        appender.cut(rows)
        chunks.verify(appender.arrays)
        appender.reload(rows)


def _attributes(integration: Integration) -> dict[str, Any]:
    status = integration.status or Status.RUNNING
    report, last = integration.report(), integration.last[0]
    return finite(attributes.attributes(integration.problem, status, integration.reason(), last, report))

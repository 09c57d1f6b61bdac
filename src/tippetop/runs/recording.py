"""A run becomes a store as it goes: rows and events in whole chunks, a checkpoint that acknowledges them, a lock."""

import json
import os
import signal
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from ..engine.status import Status
from ..errors import Interrupted, StoreError
from ..problem import Problem
from ..scenario import build
from ..store import chunks, files, provenance
from ..store.chunks import Appender
from ..store.files import LOCK
from ..store.root import CHECKPOINT, finite, new_store
from ..store.root import attributes as read_attributes
from . import attributes
from .events import EventTable, event_columns
from .integration import Course


MOST_ROWS, FEWEST_ROWS = 1 << 18, 1 << 10  # of a chunk: 2 MiB a column take a third less than twice 1 MiB
EVENTS_PER_CHUNK = 16_384
COMMIT_EVERY = 5.0  # [s] of the clock: what an interruption can cost; when commits happen does not show in the store


class Recorder:
    """The sink of a run that writes its store. A context: inside it, the store is locked and SIGINT, SIGTERM wait."""

    def __init__(self, folder: Path, course: Course, trajectory: Appender, events: Appender, lock: int):
        self.folder, self.course, self.lock = folder, course, lock
        self.trajectory, self.log = trajectory, events
        self.behind: deque[Future] = deque()  # writing follows integration in a second thread
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")
        self.asked: int | None = None
        self.committed_at = time.monotonic()

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Takes rows."""
        self._later(lambda: self.trajectory.append(self.course.view.columns(times, states())))

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

    def _written(self) -> None:
        """Waits until all that was queued is written, and on the disk."""
        while self.behind:
            self.behind.popleft().result()
        for appender in (self.trajectory, self.log):
            appender.flush()
            appender.sync()

    def slice_done(self, course: Course) -> None:
        """Commits now and then; stops at a commit if asked to."""
        if self.asked is not None or time.monotonic() - self.committed_at > COMMIT_EVERY:
            self.commit()
        if self.asked is not None:
            raise Interrupted(self.asked)

    def commit(self) -> None:
        """Data first, then the record that acknowledges it."""
        self._written()
        record = {
            "format_version": provenance.FORMAT_VERSION,
            "versions": provenance.versions(),
            "cpu": provenance.cpu(),
            "rows": self.trajectory.rows,
            "events": self.log.rows,
            "course": self.course.snapshot(),
            "report": finite(self.course.report()),
            "reason": self.course.reason(),
        }
        files.replace_text(self.folder / CHECKPOINT, json.dumps(record, allow_nan=False))
        self.committed_at = time.monotonic()

    def finish(self) -> dict[str, Any]:
        """Writes what waits and the root attributes, takes the checkpoint away; gives the attributes back."""
        self._written()
        attrs = _attributes(self.course)
        zarr.open_group(store=str(self.folder), mode="r+").update_attributes(attrs)
        files.sweep(self.folder)
        (self.folder / CHECKPOINT).unlink(missing_ok=True)
        (self.folder / LOCK).unlink(missing_ok=True)
        return attrs

    def __enter__(self) -> "Recorder":
        self.handlers = {number: signal.signal(number, self._ask) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self.handlers.items():
            signal.signal(number, handler)
        self.thread.shutdown(cancel_futures=True)
        os.close(self.lock)

    def _ask(self, number: int, _: object) -> None:
        self.asked = number


def rows_per_chunk(problem: Problem) -> int:
    """The rows of a chunk of the trajectory: all that are asked for, up to `MOST_ROWS`."""
    asked = len(problem.times) if problem.output == "times" else MOST_ROWS // 4
    return min(MOST_ROWS, max(FEWEST_ROWS, 1 << (asked - 1).bit_length()))


def record(
    problem: Problem, target: Path, *, overwrite: bool = False, progress: Callable[[Course], None] | None = None
) -> tuple[Course, dict[str, Any]]:
    """Integrates a problem into a new store. Raises StoreError, Interrupted."""
    with new_store(target, overwrite=overwrite) as scratch:
        course = Course(problem)
        root = zarr.open_group(store=str(scratch), mode="w", zarr_format=3, attributes=_attributes(course))
        lock = files.locked(scratch)
        empty = course.view.columns(np.zeros(0), course.first[:0])
        trajectory = Appender.created(root, "trajectory", empty, rows_per_chunk(problem))
        events = Appender.created(root, "events", event_columns(EventTable.empty()), EVENTS_PER_CHUNK)
        Recorder(scratch, course, trajectory, events, lock).commit()
    return _run(target, course, lock, progress)


def resume(target: Path, progress: Callable[[Course], None] | None = None) -> tuple[Course, dict[str, Any]]:
    """Continues an interrupted run. Raises StoreError, Interrupted, ScenarioError."""
    attrs = read_attributes(target)
    if attrs["status"] != Status.RUNNING.value:
        for left in (CHECKPOINT, LOCK):  # killed after its last word, before it could tidy up
            (Path(target) / left).unlink(missing_ok=True)
        raise StoreError(f"`{target}` must be unfinished to be resumed, but: {attrs['reason']}.")
    course = Course(build.problem(build.tables_of(attrs)))
    lock = files.locked(Path(target))
    return _run(Path(target), course, lock, progress, resumed=True)


def _run(
    target: Path, course: Course, lock: int, progress: Callable[[Course], None] | None, *, resumed: bool = False
) -> tuple[Course, dict[str, Any]]:
    try:
        with zarr.config.set({"array.write_empty_chunks": True}):  # a chunk of zeros is data too: its absence is damage
            root = zarr.open_group(store=str(target), mode="r+", zarr_format=3)
            trajectory = Appender(root["trajectory"])
            events = Appender(root["events"])
        with Recorder(target, course, trajectory, events, lock) as recorder:
            if resumed:
                _go_back(target, root, recorder)
            course.run(recorder, progress)
            return course, recorder.finish()
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        raise StoreError(
            f"`{target}` must be writable, but: {error.strerror or error}. "
            f"Nothing acknowledged is lost: tippetop resume {target}"
        ) from error


def _go_back(target: Path, root: Any, recorder: Recorder) -> None:
    """Brings a store back to its checkpoint: rows that were not acknowledged go, the rest is read once and checked."""
    try:
        kept = json.loads((target / CHECKPOINT).read_text(encoding="utf-8"))
        recorder.course.restore(kept["course"])
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(
            f"`{target}` must have a whole checkpoint of this release to be resumed, but: {error}."
        ) from None
    files.sweep(target)
    for appender, rows in ((recorder.trajectory, kept["rows"]), (recorder.log, kept["events"])):
        appender.cut(rows)
    for group in (root["trajectory"], root["events"]):
        chunks.verify(group)
    recorder.trajectory.reload(kept["rows"])
    recorder.log.reload(kept["events"])


def _attributes(course: Course) -> dict[str, Any]:
    status = course.status or Status.RUNNING
    return finite(attributes.attributes(course.problem, status, course.reason(), course.last[0], course.report()))

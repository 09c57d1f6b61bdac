"""A sweep on disk: columns with a row per top, written chunk by chunk; the store knows what is done.

A chunk's columns are written first, then a number made of the checksums of their files, then its status. What is opened
again is read once: a chunk whose files are damaged, missing or others is to be done again. Nothing in the store tells
who computed what or when: equal sweeps make equal files.
"""

import contextlib
import hashlib
import json
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..store import files, provenance, seal, skeleton, tables, zarr3
from ..store.chunks import chunk_file, readable
from ..store.lock import Lock
from ..store.root import RUNS, finish, finite, new_store
from ..store.root import attributes as read_attributes
from . import chunk, derived
from .chunk import Rows
from .plan import Plan


GROUP = "sweep"
CHUNK_STATUS, CHUNK_CHECKSUM = "chunk_status", "chunk_checksum"
FAILED = "failed.json"  # while there are failed chunks: number -> sentence
TODO, DONE, BROKEN = 0, 1, 2
BEGUN = {"status": "running", "reason": "tops are still to be run"}
CHUNK_STATUSES = ("todo", "done", "failed")
STATUSES_PER_FILE = 4096  # of chunks
SYNC_EVERY = 5.0  # [s] of the clock: what a power failure can cost


class SweepStore:
    """A sweep's store, open and locked. A context; when it ends nothing is being written any more.

    All writing is done in one thread of its own, which no KeyboardInterrupt enters: a chunk is written whole.
    """

    def __init__(self, plan: Plan, lock: Lock):
        self.folder, self.plan, self.lock = lock.folder, plan, lock
        members = (GROUP, CHUNK_STATUS, CHUNK_CHECKSUM)
        self.root, (self.arrays, self.chunk_status, self.checksums) = tables.open_root(self.folder, *members)
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")
        self.synced_at = time.monotonic()

    def __enter__(self) -> "SweepStore":
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.shutdown()

    def _now(self, work: Callable[[], None]) -> None:
        """Does work in the writing thread; returns when it is done. Raises StoreError."""

        def checked() -> None:
            self.lock.check()
            work()

        with storing(self.folder):
            self.thread.submit(checked).result()

    def check(self) -> None:
        """Clears what a killed writer leaves, and marks chunks that cannot be read as not done."""
        self._now(self._check)

    def _check(self) -> None:
        files.remove_scratch(self.folder)
        try:
            status = self.chunk_status[:]
        except Exception:  # codecs raise what they like; a chunk whose files are all whole is done
            status = np.full(self.plan.chunks, DONE)
        try:
            self.checksums[:]
        except Exception:  # then none is known to be whole
            self.checksums[:] = 0
        sound = np.where([s == DONE and self._sound(k) for k, s in enumerate(status)], DONE, TODO)
        self.chunk_status[:] = sound
        if not sound.all():
            self.root.update_attributes(BEGUN)
        (self.folder / FAILED).unlink(missing_ok=True)

    def _sound(self, chunk: int) -> bool:
        try:
            for array in self.arrays.values():
                readable(array, chunk * self.plan.chunk)
            return checksum(self.arrays, chunk * self.plan.chunk) == self.checksums[chunk]
        except (StoreError, OSError):
            return False

    def todo(self) -> list[int]:
        """Chunks that are not done."""
        return np.flatnonzero(self.chunk_status[:] != DONE).tolist()

    def write(self, chunk: int, rows: Rows) -> None:
        """Data first, then status."""
        tops = self.plan.tops(chunk)
        values = {**self.plan.design.numbers(tops), **self.plan.columns(tops), **rows.columns}

        def work() -> None:
            for name, array in self.arrays.items():
                array[tops[0] : tops[-1] + 1] = values[name]
            if rows.steps_by and "steps_by" not in self.root.attrs:
                self.root.update_attributes({"steps_by": rows.steps_by})
            self.checksums[chunk] = checksum(self.arrays, tops[0])
            self.chunk_status[chunk] = DONE
            if time.monotonic() - self.synced_at > SYNC_EVERY:
                self.root.store.sync()
                self.synced_at = time.monotonic()

        self._now(work)

    def fail(self, chunk: int, sentence: str) -> None:
        """Marks a chunk that could not be computed, and why."""
        sentences = failures(self.folder) | {str(chunk): sentence}

        def work() -> None:
            files.replace_text(self.folder / FAILED, json.dumps(sentences, indent=2))
            self.chunk_status[chunk] = BROKEN

        self._now(work)

    def finish(self) -> None:
        """Says that the sweep is whole."""

        def work() -> None:
            self.root.store.sync()
            finish(self.folder, {"status": "finished", "reason": "every top was run"})
            files.remove_scratch(self.folder)
            self.lock.remove()

        self._now(work)


def checksum(arrays: dict[str, Any], first: int) -> int:
    """A number made of the checksums of the files of the chunk that begins with top `first`. Raises OSError."""
    whole = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        whole.update(name.encode() + seal.checksum(chunk_file(array, first)))
    return int.from_bytes(whole.digest()[:8], "little", signed=True)


def refuse_damage(folder: Path, attrs: dict[str, Any]) -> None:
    """Raises StoreError if a chunk of an unfinished sweep is not what was written; a finished one has its seal."""
    if attrs["status"] != BEGUN["status"]:
        return
    status, known, arrays = (tables.read_member(folder, name) for name in (CHUNK_STATUS, CHUNK_CHECKSUM, GROUP))
    try:
        for k in np.flatnonzero(status[:] == DONE):
            if checksum(arrays, int(k) * attrs["chunk"]) != known[int(k)]:
                raise OSError(f"chunk {k} is another")
    except Exception as error:  # codecs raise what they like
        raise StoreError(
            f"`{folder}` must be a whole store, but is damaged: {error}. The sweep's own command computes it again."
        ) from None


@contextlib.contextmanager
def opened(path: str | Path, plan: Plan) -> Iterator[SweepStore]:
    """The store of a sweep, new or continued, for one writer. Raises StoreError: another plan, other versions, a second
    writer, what cannot be read or written."""
    folder = files.own_folder(path)
    with contextlib.ExitStack() as held:
        with storing(folder):
            lock = held.enter_context(Lock(_there(folder, plan)) if folder.exists() else _created(folder, plan))
            store = held.enter_context(SweepStore(plan, lock))
        store.check()
        yield store


@contextlib.contextmanager
def storing(folder: Path) -> Iterator[None]:
    """A block in which what goes wrong with the disk or the store becomes a StoreError."""
    kept = "What is stored is kept: the same command continues it." if (folder / GROUP).exists() else ""
    try:
        with files.writing(folder, kept):
            yield
    except (KeyError, ValueError) as error:  # zarr's own are ValueErrors
        raise StoreError(f"`{folder}` must be readable, but: {error}: remove it.") from error


def failures(folder: Path) -> dict[str, str]:
    """Why chunks failed, by number."""
    try:
        return json.loads((folder / FAILED).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}


def _attributes(plan: Plan) -> dict[str, Any]:
    return finite(
        {
            "content": GROUP,
            "title": f"sweep: {plan.base.system.title}",
            **BEGUN,
            "plan": plan.document,
            "tops": plan.n,
            "chunk": plan.chunk,
            "dimensions": list(plan.design.sizes),
            "shape": list(plan.design.sizes.values()),
            "coordinates": list(_coordinates(plan)),
            "columns": list(chunk.column_schema(plan.base, plan.keep)),
            **provenance.provenance(),
        }
    )


def _there(folder: Path, plan: Plan) -> Path:
    """The folder of a sweep that was begun, if it is this one."""
    stored, wanted = read_attributes(folder, whole=False), json.loads(json.dumps(_attributes(plan)))
    if stored.get("content") != GROUP:
        raise StoreError(f"`{folder}` must be a sweep to be continued, but is something else.")
    if stored["plan"] != wanted["plan"]:
        differ = [key for key in wanted["plan"] if stored["plan"].get(key) != wanted["plan"][key]]
        raise StoreError(
            f"`{folder}` must be of the same plan to be continued, but differs in {', '.join(differ)}: "
            "name another store."
        )
    for key in ("versions", "cpu", "chunk"):
        if stored[key] != wanted[key]:
            raise StoreError(
                f"`{folder}` must be continued by the same {key}, but was begun with {stored[key]}, "
                f"and here is {wanted[key]}."
            )
    sizes = {"top": (plan.n, plan.chunk)}
    skeleton.compare(folder, GROUP, {name: zarr3.array(c, sizes) for name, c in _columns(plan).items()})
    if (folder / RUNS / "zarr.json").exists():  # it is made with the first of them
        skeleton.group(folder / RUNS)
    return folder


def _columns(plan: Plan) -> dict[str, Column]:
    return {**_coordinates(plan), **chunk.column_schema(plan.base, plan.keep)}


def _created(folder: Path, plan: Plan) -> Lock:
    """A store without a row; gives its lock."""
    with new_store(folder) as scratch:
        root = tables.create_root(scratch, _attributes(plan))
        lock = Lock(scratch)
        tables.create_table(root.create_group(GROUP), _columns(plan), {"top": (plan.n, plan.chunk)})
        if plan.runs:
            root.create_group(RUNS)
        flags = {"flag_values": list(range(3)), "flag_meanings": " ".join(CHUNK_STATUSES), "units": "1"}
        status = Column(("chunk",), np.zeros(0, np.int8), {"long_name": "state of a chunk of tops", **flags})
        sizes = {"chunk": (plan.chunks, min(plan.chunks, STATUSES_PER_FILE))}
        tables.create_table(root, {CHUNK_STATUS: status}, sizes)[CHUNK_STATUS][:] = TODO
        words = {"long_name": "made of the checksums of the chunk's files", "units": "1"}
        checksums = {CHUNK_CHECKSUM: Column(("chunk",), np.zeros(0, np.int64), words)}
        tables.create_table(root, checksums, sizes)[CHUNK_CHECKSUM][:] = 0
        root.store.sync()
    lock.folder = folder
    return lock


def _coordinates(plan: Plan) -> dict[str, Column]:
    """What varies: axes, and the numbers of the scenario that derived axes set."""
    rules, first, none = plan.base.rules, np.zeros(1, int), np.zeros(0)
    columns = {}
    for key in {**plan.design.numbers(first), **plan.columns(first)}:
        words = (
            {"units": rules[key].unit.symbol, "long_name": rules[key].long_name}
            if key in rules
            else {"units": "1", "long_name": derived.DERIVED[key].long_name}
        )
        columns[key] = Column(("top",), none, words)
    return columns

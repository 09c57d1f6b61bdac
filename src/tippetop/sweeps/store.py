"""A sweep on disk: columns with a line per top, written chunk by chunk; the store knows what is done.

A chunk's columns are written first, then its status. What is opened again is read once: a chunk whose files are damaged
or missing is to be done again. Nothing in the store tells who computed what or when: equal sweeps make equal files.
"""

import contextlib
import json
import os
import shutil
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..ensembles.tops import known
from ..errors import StoreError
from ..store import files, provenance
from ..store.chunks import codecs, readable
from ..store.files import LOCK
from ..store.root import attributes as read_attributes
from ..store.root import finite, new_store
from . import chunk, derived
from .plan import Plan


GROUP = "sweep"
RUNS = "runs"
FAILED = "failed.json"  # while there are failed chunks: number -> sentence
TODO, DONE, BROKEN = 0, 1, 2
BEGUN = {"status": "running", "reason": "tops are still to be run"}
CHUNK_STATUSES = ("todo", "done", "failed")
STATUSES_PER_FILE = 4096  # of chunks


class SweepStore:
    """A sweep's store, open and locked."""

    def __init__(self, folder: Path, plan: Plan):
        import zarr

        self.folder, self.plan = folder, plan
        with zarr.config.set({"array.write_empty_chunks": True}):  # a chunk of zeros is data: its absence is damage
            root: Any = zarr.open_group(store=str(folder), mode="r+", zarr_format=3)
            self.arrays, self.chunk_status = dict(root[GROUP].arrays()), root["chunk_status"]
        self.root = root

    def check(self) -> None:
        """Clears what a killed writer leaves, and marks chunks that cannot be read as not done."""
        with storing(self.folder):
            self._check()

    def _check(self) -> None:
        files.sweep(self.folder)
        for left in (self.folder / RUNS).glob(".*.part-*"):
            shutil.rmtree(left)
        try:
            status = self.chunk_status[:]
        except Exception:  # codecs raise what they like; a chunk whose files are all whole is done
            status = np.full(self.plan.chunks, DONE)
        sound = np.where([s == DONE and self._sound(k) for k, s in enumerate(status)], DONE, TODO)
        self.chunk_status[:] = sound
        if not sound.all():
            self.root.update_attributes(BEGUN)
        (self.folder / FAILED).unlink(missing_ok=True)

    def _sound(self, chunk: int) -> bool:
        try:
            for array in self.arrays.values():
                readable(array, chunk * self.plan.chunk)
        except StoreError:
            return False
        return True

    def todo(self) -> list[int]:
        """Chunks that are not done."""
        return np.flatnonzero(self.chunk_status[:] != DONE).tolist()

    def write(self, chunk: int, lines: dict[str, np.ndarray]) -> None:
        """Data first, then status."""
        tops = self.plan.tops(chunk)
        values = {**self.plan.design.numbers(tops), **self.plan.columns(tops), **lines}
        with storing(self.folder):
            for name, array in self.arrays.items():
                array[tops[0] : tops[-1] + 1] = values[name]
            self.chunk_status[chunk] = DONE

    def fail(self, chunk: int, sentence: str) -> None:
        """Marks a chunk that could not be computed, and why."""
        said = failures(self.folder) | {str(chunk): sentence}
        with storing(self.folder):
            files.replace_text(self.folder / FAILED, json.dumps(said, indent=2))
            self.chunk_status[chunk] = BROKEN

    def finish(self) -> None:
        """Says that the sweep is whole."""
        with storing(self.folder):
            self.root.update_attributes({"status": "finished", "reason": "every top was run"})
            files.sweep(self.folder)
            (self.folder / LOCK).unlink(missing_ok=True)


@contextlib.contextmanager
def opened(path: str | Path, plan: Plan) -> Iterator[SweepStore]:
    """The store of a sweep, new or gone on with, for one writer. Raises StoreError: another plan, other versions, a
    second writer, what cannot be read or written."""
    folder = Path(path)
    with storing(folder):
        lock = files.locked(_there(folder, plan)) if folder.exists() else _created(folder, plan)
    try:
        with storing(folder):
            store = SweepStore(folder, plan)
        store.check()
        yield store
    finally:
        os.close(lock)


@contextlib.contextmanager
def storing(folder: Path) -> Iterator[None]:
    """A block that SIGINT and SIGTERM wait for, and in which what goes wrong with the disk becomes a StoreError."""
    import zarr

    asked: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    numbers = (signal.SIGINT, signal.SIGTERM) if main else ()
    handlers = {number: signal.signal(number, lambda n, _: asked.append(n)) for number in numbers}
    try:
        yield
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        kept = " What is stored is kept: the same command goes on with it." if (folder / GROUP).exists() else ""
        raise StoreError(f"`{folder}` must be writable, but: {error.strerror or error}.{kept}") from error
    except (zarr.errors.BaseZarrError, KeyError, ValueError) as error:
        raise StoreError(f"`{folder}` must be readable, but: {error}: remove it.") from error
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if asked:
            signal.raise_signal(asked[0])


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
            "columns": list(chunk.empty(plan.base, plan.keep)),
            **provenance.provenance(),
        }
    )


def _there(folder: Path, plan: Plan) -> Path:
    """The folder of a sweep that was begun, if it is this one."""
    found, wanted = read_attributes(folder), json.loads(json.dumps(_attributes(plan)))
    if found.get("content") != GROUP:
        raise StoreError(f"`{folder}` must be a sweep to be gone on with, but is something else.")
    if found["plan"] != wanted["plan"]:
        differ = [key for key in wanted["plan"] if found["plan"].get(key) != wanted["plan"][key]]
        raise StoreError(
            f"`{folder}` must be of the same plan to be gone on with, but differs in {', '.join(differ)}: "
            "name another store."
        )
    for key in ("versions", "cpu", "chunk"):
        if found[key] != wanted[key]:
            raise StoreError(
                f"`{folder}` must be gone on with by the same {key}, but was begun with {found[key]}, "
                f"and here is {wanted[key]}."
            )
    return folder


def _created(folder: Path, plan: Plan) -> int:
    """A store without a line; gives its lock."""
    import zarr

    with new_store(folder) as scratch:
        root = zarr.open_group(store=str(scratch), mode="w", zarr_format=3, attributes=_attributes(plan))
        lock = files.locked(scratch)
        group = root.create_group(GROUP)
        for name, column in {**_coordinates(plan), **chunk.empty(plan.base, plan.keep)}.items():
            _array(group, name, column, plan.n, plan.chunk)
        if plan.runs:
            root.create_group(RUNS)
        flags = {"flag_values": list(range(3)), "flag_meanings": " ".join(CHUNK_STATUSES), "units": "1"}
        status = Column(("chunk",), np.zeros(0, np.int8), {"long_name": "state of a chunk of tops", **flags})
        array = _array(root, "chunk_status", status, plan.chunks, min(plan.chunks, STATUSES_PER_FILE))
        array[:] = TODO
    return lock


def _array(group: Any, name: str, column: Column, n: int, chunk: int) -> Any:
    return group.create_array(
        name,
        shape=(n,),
        dtype=column.values.dtype,
        chunks=(chunk,),
        dimension_names=column.dims,
        attributes=column.attrs,
        fill_value=np.nan if column.values.dtype.kind == "f" else 0,
        compressors=codecs(),
    )


def _coordinates(plan: Plan) -> dict[str, Column]:
    """What varies: axes, and the numbers of the scenario that derived axes set."""
    rules, first, none = known(plan.base), np.zeros(1, int), np.zeros(0)
    found = {}
    for key in {**plan.design.numbers(first), **plan.columns(first)}:
        words = (
            {"units": rules[key].unit.symbol, "long_name": rules[key].long_name}
            if key in rules
            else {"units": "1", "long_name": derived.DERIVED[key].long_name}
        )
        found[key] = Column(("top",), none, words)
    return found

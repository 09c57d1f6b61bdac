"""A sweep on disk: columns with a row per top, written chunk by chunk; the ledger lists what is
done.

Nothing in a finished store depends on who computed what or when: equal sweeps make equal files.
"""

import contextlib
import json
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..store import files, ledger, provenance, zarr3
from ..store.ledger import Ledger
from ..store.root import RUNS, finite, new_store
from ..store.root import attributes as read_attributes
from . import chunk, derived
from .chunk import Rows
from .plan import Plan


GROUP = "sweep"
BEGUN = {"status": "running", "reason": "tops are still to be run"}
FINISHED = {"status": "finished", "reason": "every top was run"}


class SweepStore:
    """A sweep's store, open and locked. A context; when it ends nothing is being written any more.

    All writing is done in one thread of its own, which no KeyboardInterrupt enters: a chunk is
    written whole.
    """

    def __init__(self, plan: Plan, ledger: Ledger):
        self.folder, self.plan, self.ledger = ledger.path, plan, ledger
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")

    def __enter__(self) -> "SweepStore":
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.shutdown()
        self.ledger.release()

    def _now(self, work: Callable[[], None]) -> None:
        """Does work in the writing thread; returns when it is done. Raises StoreError."""

        def checked() -> None:
            self.ledger.check()
            work()

        with storing(self.folder):
            self.thread.submit(checked).result()

    def check(self) -> None:
        """Read every chunk that is done; those that are damaged are to be done again."""

        def work() -> None:
            if unsound := self.ledger.unsound():
                self.ledger.forget(unsound)

        self._now(work)

    def todo(self) -> list[int]:
        """Chunks that are not done."""
        return [
            k for k in range(self.plan.chunks) if f"{GROUP}/{k}" not in self.ledger.state.chunks
        ]

    def write(self, chunk: int, rows: Rows) -> None:
        """Writes the columns of a chunk; it is done from then on."""
        tops = self.plan.tops(chunk)
        values = {**self.plan.design.numbers(tops), **self.plan.columns(tops), **rows.columns}
        more = (
            {"steps_by": rows.steps_by}
            if rows.steps_by and "steps_by" not in self.ledger.state.attributes
            else {}
        )

        def work() -> None:
            self.ledger.put(f"{GROUP}/{chunk}", values)
            self.ledger.commit(changed=more)
            if more:
                self.ledger.derive({})

        self._now(work)

    def fail(self, chunk: int, sentence: str) -> None:
        """Marks a chunk that could not be computed, and why."""
        self._now(lambda: self.ledger.commit(failed={f"{GROUP}/{chunk}": sentence}))

    def finish(self) -> None:
        """Marks the sweep as whole."""
        if not self.ledger.state.seal:
            self._now(lambda: self.ledger.finish(self.ledger.state.changed | FINISHED))


def chunk_counts(path: Path, attrs: dict[str, Any]) -> tuple[dict[str, int], dict[str, str]]:
    """How many chunks are todo, done and failed; and why chunks failed, by number."""
    state = ledger.read(path, chunks=False)
    failed = {key.rpartition("/")[2]: sentence for key, sentence in state.failed.items()}
    done = len(state.chunks)
    todo = -(-attrs["tops"] // attrs["chunk"]) - done - len(failed)
    return {"todo": todo, "done": done, "failed": len(failed)}, failed


@contextlib.contextmanager
def opened(path: str | Path, plan: Plan) -> Iterator[SweepStore]:
    """The store of a sweep, new or continued, for one writer.

    Raises StoreError: another plan, other versions, a second writer, what cannot be read or
    written.
    """
    folder = files.own_folder(path)
    with contextlib.ExitStack() as held:
        with storing(folder):
            if folder.exists():
                _refuse_another(folder, plan)
                files.refuse_links(folder)
                locked = Ledger.opened(folder)
            else:
                with new_store(folder) as scratch:
                    locked = held.enter_context(Ledger.created(scratch, _header(plan)))
                locked.path = folder
            store = held.enter_context(SweepStore(plan, locked))
        store.check()
        yield store


@contextlib.contextmanager
def storing(folder: Path) -> Iterator[None]:
    """A block in which what goes wrong with the disk becomes a StoreError."""
    kept = (
        "What is stored is kept: the same command continues it."
        if (folder / GROUP).exists()
        else ""
    )
    with files.writing(folder, kept):
        yield


def _header(plan: Plan) -> dict[str, Any]:
    sizes = {"top": (plan.n, plan.chunk)}
    columns = {**_coordinates(plan), **chunk.column_schema(plan.base, plan.keep)}
    arrays = {f"{GROUP}/{name}": zarr3.array(column, sizes) for name, column in columns.items()}
    runs = {RUNS: zarr3.group({})} if plan.runs else {}
    return ledger.header(
        _attributes(plan), {GROUP: zarr3.group({}), **arrays, **runs}, {GROUP: list(arrays)}
    )


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


def _refuse_another(folder: Path, plan: Plan) -> None:
    """Raises StoreError if what is there is not this sweep."""
    stored, wanted = read_attributes(folder, whole=False), json.loads(json.dumps(_attributes(plan)))
    if stored.get("content") != GROUP:
        raise StoreError(f"`{folder}` must be a sweep to be continued, but is something else.")
    if stored["plan"] != wanted["plan"]:
        differ = [key for key in wanted["plan"] if stored["plan"].get(key) != wanted["plan"][key]]
        raise StoreError(
            f"`{folder}` must be of the same plan to be continued, but differs in "
            f"{', '.join(differ)}: "
            "name another store."
        )
    for key in ("versions", "cpu", "chunk"):
        if stored[key] != wanted[key]:
            raise StoreError(
                f"`{folder}` must be continued by the same {key}, but was begun with "
                f"{stored[key]}, "
                f"and here is {wanted[key]}."
            )


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

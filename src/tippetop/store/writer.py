"""Create or continue a store, and write it on a thread that no KeyboardInterrupt enters.

The run computes on its own thread, and queues work such as `Ledger.put` here; errors come back at
the next call.
"""

import contextlib
import json
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Self

from ..arguments import PlainData
from ..errors import StoreError
from . import files, root
from .ledger import Ledger


AHEAD = 8  # pieces of work that wait for the thread


class Writer:
    """A thread that writes a locked store.

    It is a context: at its end nothing is being written any more, and the lock is released.
    """

    def __init__(self, store: Ledger):
        self.store = store
        self.behind: deque[Future] = deque()
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="store")

    def later(self, work: Callable[[], None]) -> None:
        """Queue work for the thread; wait if much is queued.

        An error of earlier work is raised here.
        """
        while len(self.behind) > AHEAD or (self.behind and self.behind[0].done()):
            self.behind.popleft().result()
        self.behind.append(self.thread.submit(work))

    def now(self, work: Callable[[], None]) -> None:
        """Do all queued work, then this work, and return when it is done.

        An error of earlier work is raised, and this work is not begun.
        """
        while self.behind:
            self.behind.popleft().result()
        self.thread.submit(work).result()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.shutdown(cancel_futures=True)
        self.store.release()


def begin(target: str | Path, head: Callable[[], PlainData], **how: bool) -> Ledger:
    """Create a store with the header `head()`, locked; `how` are arguments of `root.new_store`.

    `head` may compile for seconds, so it is called after `new_store` has refused a bad target.
    Raises StoreError.
    """
    # the lock is in a stack around `new_store`, as its rename at the end may fail too
    with contextlib.ExitStack() as held:
        with root.new_store(target, **how) as scratch:
            store = held.enter_context(Ledger.created(scratch, head()))
        held.pop_all()  # success: the lock is kept, and the caller releases it
    store.path = Path(target)  # the scratch folder was renamed; the open folder is the same
    return store


def begin_or_continue(
    path: str | Path,
    head: Callable[[], PlainData],
    same: Iterable[str],
    overwrite: bool,
) -> Ledger:
    """Create a store with the header `head()`, or continue it without its damaged chunks; lock it.

    `sweeps.store` calls it; `runs.resuming` continues runs. With `overwrite` the store is always
    created. Raises StoreError if an existing one differs in one of the attributes `same`, or has
    another writer.
    """
    path = files.own_folder(path)
    if overwrite or not path.exists():
        store = begin(path, head, overwrite=overwrite)
        with store.released_on_failure(), files.writing(path):
            store.derive({})  # the documents: readers may open the store before its first commit
        return store
    stored = root.root_of(path)
    wanted = json.loads(json.dumps(head()["attributes"]))
    content = wanted["content"]
    found = stored.get("content", "run")
    if content != found:
        raise StoreError(f"`{path}` must be a {content} to be continued, but is a {found}.")
    for key in same:
        if stored.get(key) != wanted.get(key):
            words = "events and columns of the user" if key == "own" else key
            raise StoreError(
                f"`{path}` must have the same {words} to be continued, but "
                f"{_difference(stored.get(key, {}), wanted.get(key, {}))}: name another store."
            )
    with files.writing(path):
        files.refuse_links(path)
        store = Ledger.opened(path)
        with store.released_on_failure():
            unsound = store.unsound()
            store.recover()
            if unsound:
                # chunk K of a sweep and its events, with the keys events/J.K of `put_events`, are
                # computed together; from other keys this makes names that no chunk has
                unsound += [f"{content}/{key.rpartition('.')[2]}" for key in unsound]
                keys = store.state.chunks.keys() - {*unsound}
                store.restart(store.state.header, keys, rows=store.state.rows)
    return store


def _difference(old: Any, new: Any) -> str:
    """Return a clause on how a stored attribute `old` differs from the present one, `new`."""
    if not isinstance(new, dict):
        return f"has {old}, and here is {new}"
    return "differs in " + ", ".join(
        f"{name} {old.get(name)} (here {value})" if isinstance(value, str) else name
        for name, value in new.items()
        if old.get(name) != value
    )

"""An interrupted run is taken up where its checkpoint stands, once all that it acknowledges is found there."""

import contextlib
import threading
from pathlib import Path
from typing import Any

from ..engine.status import Status
from ..errors import StoreError
from ..mechanics.system import System
from ..scenario import build
from ..store import checkpoint, chunks, files, skeleton, tables
from ..store.checkpoint import ROWS
from ..store.lock import Lock
from ..store.root import attributes as read_attributes
from .integration import Integration
from .recording import Progress, Recorder, here, run_into, tables_of_run, tidy


def resume(
    target: Path,
    progress: Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues an interrupted run, in any thread: arguments and results as those of `record`.

    With `accept_other_version` also one that other versions or another processor began: its bits may differ from those
    of an undisturbed run, and the store names both. `known` is its system, where that has events or columns of one's
    own.

    Raises
    ------
    StoreError
        The store is finished, damaged, being written, or cannot be written.
    Interrupted
        `stop` was set.
    InputError
        The scenario in the store is not one of this release.
    """
    target, attrs = files.own_folder(target), read_attributes(target)
    if attrs["status"] != Status.RUNNING.value:
        tidy(target)
        raise StoreError(f"`{target}` must be unfinished to be resumed, but: {attrs['reason']}.")
    with contextlib.ExitStack() as held:
        with files.writing(target):
            lock = held.enter_context(Lock(target))
        files.remove_stale(target)
        kept = same_here(target, _checkpoint(target), accept_other_version)
        integration = Integration(build.stored(attrs, known=known), stop)
        compare(target, integration, kept)
        return go_on(integration, lock, kept, progress, stop)


def _checkpoint(target: Path) -> dict[str, Any]:
    """The checkpoint of a store. Raises StoreError."""
    try:
        return checkpoint.read(target, skeleton.root_of(target))
    except FileNotFoundError:
        raise StoreError(f"`{target}` must have a checkpoint to be resumed, but has none.") from None


def same_here(target: Path, kept: dict[str, Any], accept_other_version: bool, verb: str = "resumed") -> dict[str, Any]:
    """A record with the versions and the processor that wrote it, `begun_with` as it is from here on. Raises StoreError
    if they are others here, and that is not accepted."""
    before, now = {key: kept[key] for key in here()}, here()
    if before == now:
        return kept
    if not accept_other_version:
        differ = [
            f"{name} {before['versions'].get(name)} (here {version})"
            for name, version in now["versions"].items()
            if before["versions"].get(name) != version
        ]
        differ += [f"processor {before['cpu']} (here {now['cpu']})"] if before["cpu"] != now["cpu"] else []
        raise StoreError(
            f"`{target}` must be {verb} by the versions and processor that wrote it: {', '.join(differ)}; "
            "its bits may differ with --accept-other-version."
        )
    return kept | {"begun_with": [*kept.get("begun_with", []), before]}


def compare(target: Path, integration: Integration, kept: dict[str, Any]) -> None:
    """Compares what is there with what must be there: every column, its metadata, its acknowledged rows."""
    for name, columns, chunk in tables_of_run(integration):
        rows = kept[ROWS[name]]
        dimension = next(iter(columns.values())).dims[0]
        skeleton.compare(target, name, tables.metadata(columns, {dimension: (0, chunk)}))
        for column, document in skeleton.members(target, name).items():
            if document["shape"][0] < rows:
                raise StoreError(
                    f"`{target}`: `{name}/{column}` must hold the {rows} acknowledged rows, "
                    f"but has {document['shape'][0]}."
                )


def go_on(
    integration: Integration,
    lock: Lock,
    kept: dict[str, Any],
    progress: Progress | None,
    stop: threading.Event | None,
) -> tuple[Integration, dict[str, Any]]:
    """Integrates into a store, whose lock is held, from where its checkpoint stands."""
    return run_into(integration, lock, progress, stop, lambda recorder: _go_back(recorder, integration, kept))


def _go_back(recorder: Recorder, integration: Integration, kept: dict[str, Any]) -> None:
    """Brings a store back to its checkpoint: rows that were not acknowledged go, the rest is read once and checked."""
    target, recorder.begun_with = recorder.lock.folder, kept["begun_with"]
    put_back(target, integration, kept["integration"])
    files.remove_scratch(target)
    for name, appender in recorder.appenders.items():
        rows = kept[ROWS[name]]
        appender.cut(rows)
        chunks.verify(appender.arrays)
        appender.reload(rows)
        if appender.digest() != kept["digests"].get(name):
            raise StoreError(f"`{target}` must hold the {rows} acknowledged rows, but some of them are others.")
    recorder.appenders["events"].mark("significant", integration.log.open_rows(), value=False)


def put_back(target: Path, integration: Integration, kept: dict[str, Any]) -> None:
    """Puts an integration where a record of its store says. Raises StoreError."""
    try:
        integration.restore(kept)
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise StoreError(
            f"`{target}` must have a whole checkpoint that fits what is installed to be resumed, but: {error}."
        ) from None

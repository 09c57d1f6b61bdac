"""A finished run is made longer: bit by bit the run that would have been made at once."""

import contextlib
import shutil
import threading
from pathlib import Path
from typing import Any

from ..columns import Column
from ..engine.status import Status
from ..errors import InputError, StoreError
from ..mechanics.system import System
from ..scenario import build
from ..store import checkpoint, chunks, files, renaming, root, skeleton, tables
from ..store.checkpoint import END, END_FILE, ROWS
from ..store.chunks import Appender
from ..store.lock import Lock
from ..store.provenance import FORMAT_VERSION
from . import attributes, recording, reporting, resuming, sensitivities
from .integration import Integration


def continued(
    target: Path,
    until: float | None,
    progress: recording.Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues a run: an interrupted one to its end, or any to a later end, `until`; see `resuming.resume`."""
    how: dict[str, Any] = {"stop": stop, "accept_other_version": accept_other_version, "known": known}
    return resuming.resume(target, progress, **how) if until is None else extend(target, until, progress, **how)


def extend(
    target: Path,
    until: float,
    progress: recording.Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues a run to a later end: one that is not finished to its own end first.

    The last slice is integrated again from its beginning, because the end shortened its last step. The store becomes
    that of an interrupted run, which `resume` continues whatever happens; before that, nothing in it is changed.

    Parameters
    ----------
    target
        The store.
    until
        The end [s].
    progress, stop, accept_other_version, known
        As for `resuming.resume`.

    Returns
    -------
    Integration, dict
        The run at its end, and the root attributes of the store.

    Raises
    ------
    InputError
        The run is as long already.
    StoreError
        It ended before its time, or the store is damaged, being written, or cannot be written.
    Interrupted
        `stop` was set.
    """
    target = files.own_folder(target)
    files.refuse_inside(target)  # in a sweep, whose plan says until when
    attrs = root.attributes(target)
    if attrs["status"] == Status.RUNNING.value:
        if until < attrs["run"]["until"]:
            raise _no_later(target, until, attrs)
        how: dict[str, Any] = {"stop": stop, "accept_other_version": accept_other_version, "known": known}
        result = resuming.resume(target, progress, **how)
        if until == attrs["run"]["until"] or result[1]["status"] != Status.FINISHED.value:
            return result
    else:
        recording.tidy(target)
    with contextlib.ExitStack() as held:
        with files.writing(target):
            lock = held.enter_context(Lock(target))
            if lock.made:
                held.callback(lock.remove)  # a store that stays as it was has no lock
            attrs = root.attributes(target)
            kept = _ending(target, attrs, until, accept_other_version)
            integration = Integration(build.stored(attrs, until, known), stop)
            kept = _unfinished(target, integration, kept)
        return resuming.go_on(integration, lock, kept, progress, stop)


def _no_later(target: Path, until: float, attrs: dict[str, Any]) -> InputError:
    ends = attrs["run"]["until"]
    return InputError([f"the new end must be later than that of `{target}`, {ends:g} s, but is {until:g} s."])


def _ending(target: Path, attrs: dict[str, Any], until: float, accept_other_version: bool) -> dict[str, Any]:
    """What a finished store keeps for those who continue it. Raises StoreError, InputError."""
    if "replay" in attrs:
        raise StoreError(f"`{target}` must be a run to be continued, but is a replay of a part of one.")
    if attrs["status"] != Status.FINISHED.value:
        raise StoreError(f"`{target}` must have come to its end to be continued, but: {attrs['reason']}.")
    if not until > attrs["run"]["until"]:
        raise _no_later(target, until, attrs)
    try:
        kept = checkpoint.read(target, skeleton.root_of(target), END)
    except FileNotFoundError:
        raise StoreError(f"`{target}` must have the root attribute `{END}` to be continued, but has none.") from None
    before: dict[str, Any] = {key: attrs[key] for key in ("versions", "cpu", "begun_with") if key in attrs}
    return {"begun_with": [], **kept, **resuming.same_here(target, before, accept_other_version, "continued")}


def _unfinished(target: Path, integration: Integration, ending: dict[str, Any]) -> dict[str, Any]:
    """Makes a finished store that of an interrupted run with a later end; gives its checkpoint. Raises StoreError."""
    resuming.put_back(target, integration, ending["slice"])
    for name, columns, chunk in recording.tables_of_run(integration):
        _rechunked(target, name, columns, chunk)
    present = integration.progress()
    attrs = root.finite(attributes.attributes(present))
    done = integration.monitor.steps
    kept: dict[str, Any] = {
        "format_version": FORMAT_VERSION,
        **recording.here(),
        "begun_with": ending["begun_with"],
        "rows": integration.filled,
        "events": integration.log.rows,
        **integration.story.rows(),
        **dict.fromkeys(sensitivities.NAMES, 0),
        "keyframes": done // integration.problem.keyframe_steps if integration.problem.output == "keyframes" else 0,
        "integration": ending["slice"],
        "report": root.finite(reporting.report(present)),
        "reason": reporting.reason(present),
    }
    resuming.compare(target, integration, kept)
    names = [name for name, *_ in recording.tables_of_run(integration)]
    kept["digests"] = {name: root.digest_of_rows(target, name, kept[ROWS[name]]) for name in names}
    checkpoint.write(target, kept, checkpoint.digest(attrs))
    root.replace_attributes(target, attrs)
    (target / END_FILE).unlink(missing_ok=True)
    return kept


def _rechunked(target: Path, name: str, columns: dict[str, Column], chunk: int) -> None:
    """Gives a group of a finished store chunks of so many rows, if it has others: the new one takes its place in one
    step, between the old seal and a new one."""
    arrays = tables.read_member(target, name)
    if {array.chunks[0] for array in arrays.values()} == {chunk}:
        return
    scratch = files.scratch_name(target / name)
    try:
        with tables.every_chunk():
            appender = Appender.created(tables.create_root(scratch, {}), name, columns, chunk)
        for piece in chunks.pieces(target, name, list(arrays)):
            appender.append({key: columns[key]._replace(values=values) for key, values in piece.items()})
        appender.flush()
        appender.sync()
        with root.unsealed(target):
            if not renaming.exchange(scratch / name, target / name):
                raise StoreError(f"`{target}` must be on a file system that can swap two folders to get larger chunks.")
    finally:
        shutil.rmtree(scratch, ignore_errors=True)

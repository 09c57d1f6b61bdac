"""A stored run is continued: an interrupted one from its tail, a finished one to a later end, bit
by bit as one run.
"""

import json
import threading
from pathlib import Path
from typing import Any

from ..engine.status import Status
from ..errors import InputError, StoreError
from ..mechanics.system import System
from ..scenario import build
from ..store import files, ledger, root
from ..store.ledger import Ledger
from ..store.table import LATE
from . import recording
from .integration import Integration
from .recording import Progress, Recorder, here, run_into


def resume(
    target: Path,
    progress: Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues an interrupted run, in any thread: arguments and results as those of `record`.

    With `accept_other_version` also one that other versions or another processor began: its bits
    may differ from those of an undisturbed run, and the store names both. `known` is its system,
    where that has events or columns of one's own.

    Raises
    ------
    StoreError
        The store is finished, damaged, being written, or cannot be written.
    Interrupted
        `stop` was set.
    InputError
        The scenario in the store is not one of this release.
    """
    target = files.own_folder(target)
    with opened(target) as store:
        attrs = store.state.attributes
        if attrs["status"] != Status.RUNNING.value:
            raise StoreError(
                f"`{target}` must be unfinished to be resumed, but: {attrs['reason']}."
            )
        with ledger.sound(target):
            tail = store.tail()
        begun = {**{key: attrs[key] for key in here()}, "begun_with": [], "integration": None}
        state = json.loads(tail.partition(b"\n")[0]) if tail else begun
        state = same_here(target, state, accept_other_version)
        integration = Integration(build.stored(attrs, known=known), stop)
        _compare(store, recording.header(integration))

        def take_up(recorder: Recorder) -> None:
            recorder.begun_with = state["begun_with"]
            if tail:
                recorder.restore(tail)
                put_back(target, integration, state["integration"])
                _unmark(recorder, integration)
                recorder.derive()

        return run_into(integration, store, progress, stop, take_up)


def opened(target: Path) -> Ledger:
    """The store of a run, to continue it: every byte that it acknowledges is read.

    Raises StoreError.
    """
    if "content" in root.root_of(target):
        raise StoreError(f"`{target}` must be the store of a run to be continued, but is another.")
    with files.writing(target):
        files.remove_stale(target)
        files.refuse_links(target)
        store = Ledger.opened(target)
        if unsound := store.unsound():
            store.release()
            name = store.state.files(unsound[0])[0].rpartition("/")[0]
            raise StoreError(
                f"`{target}` must be a whole store, but is damaged: a chunk of `{name}` or its "
                "table is."
            )
    return store


def _compare(store: Ledger, wanted: dict[str, Any]) -> None:
    """Raise StoreError if a store has other columns than its scenario makes here."""
    members, wanted = store.state.header["members"], json.loads(json.dumps(wanted["members"]))
    if differ := [
        path for path in members.keys() | wanted.keys() if members.get(path) != wanted.get(path)
    ]:
        raise StoreError(
            f"`{store.path}` must have the columns of its scenario, but `{sorted(differ)[0]}` "
            "is another here."
        )


def _unmark(recorder: Recorder, integration: Integration) -> None:
    """Clear the flags of events that are still open where the run is taken up."""
    recorder.mark(integration.log.open_rows(), value=False)


def same_here(
    target: Path, kept: dict[str, Any], accept_other_version: bool, verb: str = "resumed"
) -> dict[str, Any]:
    """A record with the versions and the processor that wrote it, `begun_with` as it is from here
    on. Raises StoreError if they are others here, and that is not accepted.
    """
    before, now = {key: kept[key] for key in here()}, here()
    if before == now:
        return kept
    if not accept_other_version:
        differ = [
            f"{name} {before['versions'].get(name)} (here {version})"
            for name, version in now["versions"].items()
            if before["versions"].get(name) != version
        ]
        differ += (
            [f"processor {before['cpu']} (here {now['cpu']})"]
            if before["cpu"] != now["cpu"]
            else []
        )
        raise StoreError(
            f"`{target}` must be {verb} by the versions and processor that wrote it: "
            f"{', '.join(differ)}; "
            "its bits may differ with --accept-other-version."
        )
    return kept | {"begun_with": [*kept.get("begun_with", []), before]}


def put_back(target: Path, integration: Integration, kept: dict[str, Any]) -> None:
    """Puts an integration where a record of its store says. Raises StoreError."""
    try:
        integration.restore(kept)
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise StoreError(
            f"`{target}` must have a whole checkpoint that fits what is installed to be "
            f"resumed, but: {error}."
        ) from None


def continued(
    target: Path,
    until: float | None,
    progress: Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues a run: an interrupted one to its end, or any to a later end, `until`;
    see `resume`.
    """
    how: dict[str, Any] = {
        "stop": stop,
        "accept_other_version": accept_other_version,
        "known": known,
    }
    return (
        resume(target, progress, **how) if until is None else extend(target, until, progress, **how)
    )


def extend(
    target: Path,
    until: float,
    progress: Progress | None = None,
    *,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, dict[str, Any]]:
    """Continues a run to a later end: one that is not finished to its own end first.

    The last slice is integrated again from its beginning, because the end shortened its last step.
    In one step, the store becomes that of an interrupted run, which `resume` continues whatever
    happens.

    Parameters
    ----------
    target
        The store.
    until
        The end [s].
    progress, stop, accept_other_version, known
        As for `resume`.

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
    attrs = root.root_of(target)
    if attrs.get("status") == Status.RUNNING.value and "content" not in attrs:
        if until < attrs["run"]["until"]:
            raise _no_later(target, until, attrs)
        how: dict[str, Any] = {
            "stop": stop,
            "accept_other_version": accept_other_version,
            "known": known,
        }
        result = resume(target, progress, **how)
        if until == attrs["run"]["until"] or result[1]["status"] != Status.FINISHED.value:
            return result
    with opened(target) as store:
        attrs = store.state.attributes
        _refuse(target, attrs, until)
        before: dict[str, Any] = {
            key: attrs[key] for key in ("versions", "cpu", "begun_with") if key in attrs
        }
        kept = same_here(target, before, accept_other_version, "continued")
        integration = Integration(build.stored(attrs, until, known), stop)
        header = recording.header(integration)
        _compare(store, header)
        put_back(target, integration, store.state.end["slice"])

        def take_up(recorder: Recorder) -> None:
            recorder.begun_with = kept.get("begun_with", [])
            for name, rows in _rows(integration).items():
                for part in recorder.growing.keys() & {name, name + LATE}:
                    recorder.growing[part].cut(rows)
            _unmark(recorder, integration)
            chunks = {key for table in recorder.growing.values() for key in table.chunks()}
            store.restart(
                header, chunks, recorder.tail(integration.snapshot()), rows=recorder.counts()
            )
            recorder.derive()

        return run_into(integration, store, progress, stop, take_up)


def _rows(integration: Integration) -> dict[str, int]:
    """The rows of each table at the moment where an integration is."""
    problem = integration.problem
    keyframes = (
        integration.monitor.steps // problem.keyframe_steps if problem.output == "keyframes" else 0
    )
    rows = {
        "trajectory": integration.filled,
        "events": integration.log.rows,
        "keyframes": keyframes,
    }
    return rows | integration.story.rows() | dict.fromkeys(recording.sensitivities.NAMES, 0)


def _no_later(target: Path, until: float, attrs: dict[str, Any]) -> InputError:
    ends = attrs["run"]["until"]
    return InputError(
        [f"the new end must be later than that of `{target}`, {ends:g} s, but is {until:g} s."]
    )


def _refuse(target: Path, attrs: dict[str, Any], until: float) -> None:
    """Raises StoreError, InputError for a store that cannot be continued to this end."""
    if "replay" in attrs:
        raise StoreError(
            f"`{target}` must be a run to be continued, but is a replay of a part of one."
        )
    if attrs["status"] != Status.FINISHED.value:
        raise StoreError(
            f"`{target}` must have come to its end to be continued, but: {attrs['reason']}."
        )
    if not until > attrs["run"]["until"]:
        raise _no_later(target, until, attrs)

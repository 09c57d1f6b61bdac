"""Continue a stored run to its end, or to a later one, with the bits of one undisturbed run.

A store goes in; its run is restored to its last snapshot, and integrated into the same store.
"""

import json
import threading
from pathlib import Path

from ..arguments import PlainData
from ..engine.status import Status
from ..errors import InputError, StoreError
from ..mechanics.system import System
from ..scenario import build
from ..store import files, ledger, root
from ..store.ledger import Ledger
from . import recording
from .integration import Integration
from .recording import Progress, Recorder, here, run_into


def resume(
    target: Path,
    progress: Progress | None = None,
    *,
    until: float | None = None,
    stop: threading.Event | None = None,
    accept_other_version: bool = False,
    known: System | None = None,
) -> tuple[Integration, PlainData]:
    """Continue an interrupted run to its end, or a finished one to a later end, in any thread.

    The last slice of a finished run is integrated again from its beginning, because the end
    shortened its last step. In one step, its store becomes that of an interrupted run, which can be
    resumed whatever happens.

    Parameters
    ----------
    target
        The store.
    progress, stop
        As for `record`.
    until
        A later end [s].
    accept_other_version
        Whether to continue a run that other versions or another processor began: its bits may
        differ from those of an undisturbed run, and the store names both.
    known
        The system, if it has user-defined events or columns.

    Returns
    -------
    Integration, dict
        As for `record`.

    Raises
    ------
    StoreError
        The store is finished (without `until`), ended before its time, damaged, being written, or
        cannot be written.
    Interrupted
        `stop` was set.
    InputError
        The scenario in the store is not one of this release, or the run is as long already.
    """
    target = files.own_folder(target)
    if until is not None:
        files.refuse_inside(target)  # in a sweep, whose plan contains the end
    with opened(target) as store:
        attrs = store.state.attributes
        if attrs["status"] == Status.RUNNING.value and until == attrs["run"]["until"]:
            until = None  # it was interrupted on its way to this end
        _refuse(target, attrs, until)
        with ledger.sound(target):
            tail = store.tail() if until is None else b""
        kept = json.loads(tail.partition(b"\n")[0]) if tail else attrs
        verb = "resumed" if until is None else "continued"
        kept = same_here(target, kept, accept_other_version, verb)
        integration = Integration(build.stored(attrs, until, known), stop)
        header = recording.header(integration)
        _refuse_other_columns(store, header)
        state = kept["integration"] if tail else (store.state.end or {}).get("slice")

        def take_up(recorder: Recorder) -> None:
            """Load the stored state into recorder and integration, then bring the store to it.

            The store is changed only when it is certain that the run can continue.
            """
            recorder.begun_with = kept.get("begun_with", [])
            if state is not None:
                _restore(target, integration, state)
            if until is None:  # nothing is changed before it is certain that the run can continue
                store.recover()
            if state is None:  # it was killed before its first commit
                return
            if tail:
                recorder.restore(tail)
            else:  # a finished run, which is cut back to its last slice
                rows = _rows(integration)
                for table in recorder.growing.values():
                    table.cut(rows[table.group])
            # the rest of the run decides whether these events are significant
            recorder.mark(integration.log.open_rows(), value=False)
            if not tail:
                chunks = {key for table in recorder.growing.values() for key in table.chunks()}
                store.restart(
                    header, chunks, recorder.tail(integration.snapshot()), rows=recorder.counts()
                )
            recorder.derive()

        return run_into(integration, store, progress, stop, take_up)


def opened(target: Path) -> Ledger:
    """Open the store of a run to continue it, reading all that it acknowledges.

    Of a finished one, files that its last writer left are removed, as `sweeps` needs; an unfinished
    one is unchanged, until `Ledger.recover`.

    Raises StoreError.
    """
    if "content" in root.root_of(target):
        raise StoreError(f"`{target}` must be the store of a run to be continued, but is another.")
    with files.writing(target):
        files.remove_stale(target)
        files.refuse_links(target)
        store = Ledger.opened(target)
        with store.released_on_failure():
            if unsound := store.unsound():
                name = store.state.files(unsound[0])[0].rpartition("/")[0]
                raise StoreError(
                    f"`{target}` must be a whole store, but is damaged: a chunk of `{name}` or "
                    "its table is."
                )
            if store.state.seal:
                store.recover()
    return store


def same_here(
    target: Path, kept: PlainData, accept_other_version: bool, verb: str = "resumed"
) -> PlainData:
    """Compare the versions and the processor of a store with those here.

    `kept` are root attributes, or the first line of a tail, which both have the keys of
    `recording.here`. Return `kept`; if the versions or the processor differ and this is accepted,
    with the former ones appended to its list `begun_with`. Raises StoreError if it is not accepted.
    """
    before = {key: kept[key] for key in here()}
    now = here()
    if before == now:
        return kept
    if not accept_other_version:
        pairs = {name: (before["versions"].get(name), v) for name, v in now["versions"].items()}
        pairs["processor"] = before["cpu"], now["cpu"]
        differ = [f"{k} {old} (here {new})" for k, (old, new) in pairs.items() if old != new]
        raise StoreError(
            f"`{target}` must be {verb} by the versions and processor that wrote it: "
            f"{', '.join(differ)}; its bits may differ with --accept-other-version."
        )
    return kept | {"begun_with": [*kept.get("begun_with", []), before]}


def _refuse_other_columns(store: Ledger, wanted: PlainData) -> None:
    """Raise StoreError if a store has other columns than its scenario makes here.

    `wanted` is the header that `recording.header` makes of the scenario.
    """
    members = store.state.header["members"]
    wanted = json.loads(json.dumps(wanted["members"]))
    for path in sorted(members.keys() | wanted.keys()):
        if members.get(path) != wanted.get(path):
            raise StoreError(
                f"`{store.path}` must have the columns of its scenario, but `{path}` is another "
                "here."
            )


def _restore(target: Path, integration: Integration, kept: PlainData) -> None:
    """Restore an integration from a record of its store: the result of `Integration.snapshot`.

    Raises StoreError if it was made with other equations, or is damaged.
    """
    try:
        integration.restore(kept)
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise StoreError(
            f"`{target}` must have a whole checkpoint that fits the installed versions to be "
            f"resumed, but: {error}."
        ) from None


def _rows(integration: Integration) -> dict[str, int]:
    """Return the number of rows of each table at the moment where an integration is.

    `Integration.run` writes a keyframe after each multiple of `keyframe_steps`, except at the end.
    """
    return {
        "trajectory": integration.filled,
        "events": integration.log.rows,
        "keyframes": integration.steps_made // integration.problem.keyframe_steps,
        **integration.phases.rows(),
    }


def _refuse(target: Path, attrs: PlainData, until: float | None) -> None:
    """Raise StoreError, InputError for a store that cannot be continued to this end."""
    if until is None:
        if attrs["status"] != Status.RUNNING.value:
            raise StoreError(
                f"`{target}` must be unfinished to be resumed, but: {attrs['reason']}."
            )
        return
    if "replay" in attrs:
        raise StoreError(
            f"`{target}` must be a run to be continued, but is a replay of a part of one."
        )
    if attrs["status"] != Status.FINISHED.value:
        raise StoreError(
            f"`{target}` must have come to its end to be continued, but: {attrs['reason']}."
        )
    ends = attrs["run"]["until"]
    if not until > ends:
        raise InputError(
            f"the new end must be later than that of `{target}`, {ends:g} s, but is {until:g} s."
        )

"""Integrate a part of a stored run again, from its nearest keyframe, to the same bits.

A store and times go in; out come columns, or a new store with rows at these times.
"""

import math
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..engine.integrator import compiling
from ..engine.status import Status
from ..engine.taylor import fingerprint
from ..errors import InputError, StoreError
from ..mechanics.system import System
from ..problem.options import MOST_ROWS
from ..sampling import EvenTimes
from ..scenario import build
from ..store import chunks, root
from ..store.ledger import Ledger
from . import recording, resuming
from .events import EventTable
from .integration import Integration
from .phases import Rows
from .run import refuse_more_than_memory
from .sinks import Memory, Sink


# Steps between two checks whether all rows are there.
STEPS = 512


class _Rows(recording.Recorder):
    """A recorder of rows only: events and phases are copied from the run."""

    def add_events(self, table: EventTable, marks: list[int]) -> None:
        """Ignore rows of the event log: `into_store` copies them from the run."""

    def add_tables(self, new: dict[str, Rows]) -> None:
        """Ignore rows of phases and impacts: `into_store` copies them from the run."""


def columns(
    path: Path, times: EvenTimes, *, accept_other_version: bool = False, known: System | None = None
) -> dict[str, Column]:
    """Return the rows of a stored run at these times [s], as columns in memory.

    `known` is its system, where that has user-defined events or columns.

    Raises
    ------
    InputError
        The times are not within the run, or more than memory holds.
    StoreError
        The run is unfinished, damaged, has no keyframe near, or was made by other versions.
    """
    integration = _integration_for(path, times, accept_other_version, known)
    rows = Memory()
    refuse_more_than_memory(integration.problem)
    _make(integration, rows)
    return integration.view.columns(np.concatenate(rows.times), np.concatenate(rows.states))


def into_store(
    path: Path,
    times: EvenTimes,
    out: Path,
    *,
    overwrite: bool = False,
    accept_other_version: bool = False,
) -> dict[str, Any]:
    """Write the rows, as `columns` makes them, and the events of that time into a new store.

    Returns
    -------
    dict
        `rows`, `steps`, `seconds`, and the time where it `began` [s].
    """
    if os.path.realpath(out) == os.path.realpath(path):
        raise StoreError(
            f"`{out}` must not be the store that is replayed, because it contains the keyframes."
        )
    integration = _integration_for(path, times, accept_other_version)
    began = integration.t_end
    steps = integration.steps_made
    clock = time.perf_counter() - compiling.seconds  # compiling is not counted
    # from its folder: so it survives another working directory, and moving both stores
    of = os.path.relpath(os.path.realpath(path), os.path.realpath(out.parent))
    about = {"from": times.start, "until": times.until, "step": times.step, "of": of}
    head = recording.header(integration, root.attributes(path) | {"replay": about})
    with (
        root.new_store(out, overwrite=overwrite) as scratch,
        _Rows(integration.problem, Ledger.created(scratch, head)) as recorder,
    ):
        _make(integration, recorder)
        for name, table in recorder.growing.items():
            if name == "trajectory":
                continue
            first, last = ("start", "end") if name == "phases" else ("time", "time")
            for piece in chunks.pieces(path, table.group, [*table.documents, first, last]):
                after = times.start or -1.0  # a replay from 0 includes the events at t = 0
                within = (piece[last] > after) & (piece[first] <= times.until)
                table.append({key: values[within] for key, values in piece.items()})
        recorder.finish({}, None)  # the header has all attributes, and no run continues from it
    return {
        "rows": len(times),
        "began": began,
        "steps": integration.steps_made - steps,
        "seconds": time.perf_counter() - compiling.seconds - clock,
        **about,
    }


def _make(integration: Integration, sink: Sink) -> None:
    """Integrate until all rows are there."""
    integration.part(sink, STEPS, lambda: integration.filled < len(integration.problem.times))


def _integration_for(
    path: Path, times: EvenTimes, accept_other_version: bool, known: System | None = None
) -> Integration:
    """Return a stored run at the keyframe, or the start, from which it reaches these times.

    Raises InputError, StoreError.
    """
    attrs = root.attributes(path)
    if "content" in attrs:
        raise StoreError(f"`{path}` must be the store of a run to be replayed, but is another.")
    if attrs["status"] == Status.RUNNING.value:
        raise StoreError(
            f"`{path}` must be finished to be replayed, but is not: tippetop resume {path}."
        )
    resuming.same_here(path, attrs, accept_other_version, "replayed")
    problem = build.stored(attrs, known=known)
    # the time that a finished run reports may be less than `until` by rounding
    end = problem.until if attrs["status"] == Status.FINISHED.value else 0.0
    _refuse(times, max(attrs["report"]["t_end"], end))
    integration = Integration(replace(problem, output="times", times=times))
    if root.has_keyframes(attrs):
        _go_to_keyframe(path, integration, times.start)
    return integration


def _refuse(times: EvenTimes, end: float) -> None:
    """Raise InputError for times that are not within a run up to `end`, or that are too many."""
    start = times.start
    until = times.until
    step = times.step
    least = 8 * math.ulp(until)
    found = f"but are from {start:g} to {until:g} s."
    if not start <= until:
        raise InputError(f"the rows must not end before they begin, {found}")
    if not (start >= 0 and until <= end):
        raise InputError(f"the rows must be within 0 and {end:.15g} s, {found}")
    if not step >= least:
        raise InputError(
            f"`step` must be at least {least:.3g} s, eight times the distance of doubles at "
            f"{until:g} s, but is {step:g}."
        )
    if not until - start <= MOST_ROWS * step:
        raise InputError(f"`step` must give at most {MOST_ROWS:.0e} rows, but is {step:g} s.")


def _go_to_keyframe(path: Path, integration: Integration, start: float) -> None:
    """Put a run at its last keyframe before `start` [s], or leave it at its start.

    `path` is the store of the run; only the tables of its keyframes are read.
    """
    table = root.open_group(path, "keyframes")
    before = start * (1 - 2**-50)  # the exact time is not that of the column to the last bit
    at = int(np.searchsorted(root.column(path, table, "time"), before)) - 1
    if at < 0:
        return
    if table["state"].attrs.get("equations") != fingerprint(integration.driver):
        raise StoreError(
            f"`{path}` must be of the equations that are installed to be replayed, but is of "
            "others."
        )
    try:
        row = root.loaded(table.isel(keyframe=at), path)
        integration.start_at_keyframe(
            {str(name): value.values for name, value in row.variables.items()}
        )
    except (ValueError, IndexError, TypeError) as error:
        raise StoreError(f"`{path}` must have whole keyframes, but: {error}.") from None

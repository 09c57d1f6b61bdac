"""A part of a stored run is integrated again, from its nearest keyframe: the bits of the rows it
could have kept.
"""

import math
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..engine.status import Status
from ..engine.taylor import fingerprint
from ..errors import InputError, StoreError
from ..mechanics.system import System
from ..problem.options import MOST_ROWS
from ..sampling import EvenTimes
from ..scenario import build
from ..store import chunks, root
from ..store.ledger import Ledger
from ..store.table import Table
from . import keyframes, phases, recording, resuming
from .events import EventTable, event_columns
from .integration import Integration
from .run import refuse_more_than_memory
from .sinks import Memory


STEPS = 512  # between two looks whether all rows are there
# steps from the start of a run to a row, that a replay without keyframes makes: about ten seconds
NEAR = 2_000_000


class _Rows(Memory):
    """Takes the rows of an integration, and nothing else of it."""

    def __init__(self, take: Callable[[np.ndarray, np.ndarray], None]):
        super().__init__()
        self.take = take

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Take rows."""
        self.take(times, states())

    def events(self, table: EventTable, marks: list[int]) -> None:
        """Drop rows of the event log."""


def columns(
    path: Path,
    start: float,
    until: float,
    step: float,
    *,
    accept_other_version: bool = False,
    known: System | None = None,
) -> dict[str, Column]:
    """The rows of a stored run from `start` to `until` [s], every `step` [s], as columns in memory.

    `known` is its system, where that has events or columns of one's own.

    Raises
    ------
    InputError
        The times are not within the run, or more than memory holds.
    StoreError
        The run is unfinished, damaged, has no keyframe near, or was made by other versions.
    """
    integration = _integration(path, EvenTimes(step, until, start), accept_other_version, known)
    refuse_more_than_memory(integration.problem)
    pieces: list[tuple[np.ndarray, np.ndarray]] = []
    _make(integration, lambda times, states: pieces.append((times, states)))
    times, states = (np.concatenate(each) for each in zip(*pieces, strict=True))
    return integration.view.columns(times, states)


def into_store(
    path: Path,
    start: float,
    until: float,
    step: float,
    out: Path,
    *,
    overwrite: bool = False,
    accept_other_version: bool = False,
) -> dict[str, Any]:
    """As `columns`, into a new store that has the events of that time too; gives what was done:
    `rows`, `steps`, `seconds`, and the time where it `began` [s].
    """
    if os.path.realpath(out) == os.path.realpath(path):
        raise StoreError(
            f"`{out}` must be another store than the one that is replayed, which holds its "
            "keyframes."
        )
    integration = _integration(path, EvenTimes(step, until, start), accept_other_version)
    began, steps, clock = integration.t_end, integration.monitor.steps, time.perf_counter()
    attrs = root.attributes(path)
    about = {"from": start, "until": until, "step": step, "of": str(path)}
    empty = {
        "trajectory": integration.view.columns(np.zeros(0), integration.first[:0]),
        "events": event_columns(integration.log.empty),
        **phases.empty(integration.problem.system),
    }
    kinds = {name: (columns, recording.EVENTS_PER_CHUNK) for name, columns in empty.items()}
    kinds["trajectory"] = (empty["trajectory"], recording.ROWS_PER_CHUNK)
    header = recording.header_of(
        attrs | {"replay": about}, ((name, *kind) for name, kind in kinds.items()), late=""
    )
    with (
        root.new_store(out, overwrite=overwrite) as scratch,
        Ledger.created(scratch, header) as store,
    ):
        tables = {name: Table(store, name) for name in empty}

        def take(times: np.ndarray, states: np.ndarray) -> None:
            columns = integration.view.columns(times, states)
            tables["trajectory"].append({name: column.values for name, column in columns.items()})

        _make(integration, take)
        for name in empty.keys() - {"trajectory"}:
            for piece in chunks.pieces(path, name, list(empty[name])):
                begin, end = (
                    (piece["start"], piece["end"])
                    if name == "phases"
                    else (piece["time"], piece["time"])
                )
                within = (end >= start) & (begin <= until)
                tables[name].append({key: values[within] for key, values in piece.items()})
        for table in tables.values():
            table.finish()
        store.finish({}, rows={name: table.rows for name, table in tables.items()})
    return {
        "rows": len(integration.problem.times),
        "began": began,
        "steps": integration.monitor.steps - steps,
        "seconds": time.perf_counter() - clock,
        **about,
    }


def _make(integration: Integration, take: Callable[[np.ndarray, np.ndarray], None]) -> None:
    """Integrates until all rows are there."""
    integration.part(
        _Rows(take), STEPS, lambda: integration.filled < len(integration.problem.times)
    )


def _integration(
    path: Path, times: EvenTimes, accept_other_version: bool, known: System | None = None
) -> Integration:
    """A stored run where it has to be taken up to make its rows at these times.

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
    _refuse(
        times,
        max(
            attrs["report"]["t_end"],
            problem.until if attrs["status"] == Status.FINISHED.value else 0.0,
        ),
    )
    integration = Integration(replace(problem, output="times", times=times))
    if root.has_keyframes(attrs):
        _take_up(path, integration, times.start)
    else:
        _refuse_far(path, attrs["report"], times)
    return integration


def _refuse(times: EvenTimes, end: float) -> None:
    """Raises InputError for times that are not within a run up to `end`, or that are too many."""
    start, until, step = times.start, times.until, times.step
    if start > until:
        raise InputError(
            [f"the rows must end after they begin, but are from {start:g} to {until:g} s."]
        )
    if not 0 <= start <= until <= end:
        raise InputError(
            [f"the rows must be within 0 and {end:.15g} s, but are from {start:g} to {until:g} s."]
        )
    if not 0 < step < math.inf:
        raise InputError([f"`step` must be greater than 0 and finite, but is {step:g}."])
    if not step >= 8 * math.ulp(until):
        least = f"{8 * math.ulp(until):.3g} s, eight times the distance of doubles at {until:g} s"
        raise InputError([f"`step` must be at least {least}, but is {step:g}."])
    if not (until - start) / step <= MOST_ROWS:
        raise InputError(
            [
                f"`step` must give at most {MOST_ROWS:.0e} rows, but gives "
                f"{(until - start) / step:.3g}."
            ]
        )


def _refuse_far(path: Path, report: dict[str, Any], times: EvenTimes) -> None:
    """Raises StoreError where the start of a run, from which it must be taken up, is
    too far away.
    """
    end, steps = report["t_end"], report["steps"]
    far = steps * times.until / end if end > 0 else 0.0
    if far > NEAR:
        raise StoreError(
            f'`{path}` must have keyframes (run.output = "keyframes") to be replayed at t = '
            f"{times.until:g} s, "
            f"but has none, and its start is {far:.2g} steps away."
        )


def _take_up(path: Path, integration: Integration, start: float) -> None:
    """Takes a run up at its last keyframe before `start` [s], or leaves it at its start."""
    table = root.open_group(path, "keyframes")
    if table.variables.keys() != keyframes.empty(integration.problem, integration.driver).keys():
        found = ", ".join(sorted(map(str, table.variables)))
        raise StoreError(f"`{path}` must have the columns of keyframes, but has {found}.")
    clock = root.loaded(table[["clock"]], path)["clock"].values
    at = int(np.searchsorted(clock[:, 0, 0], start / integration.second, side="left")) - 1
    if at < 0:
        return
    if table["state"].attrs.get("equations") != fingerprint(integration.driver):
        raise StoreError(
            f"`{path}` must be of the equations that are installed to be replayed, but is of "
            "others."
        )
    try:
        row = root.loaded(table.isel(keyframe=at), path)
        integration.take_up({str(name): value.values for name, value in row.variables.items()})
    except (ValueError, IndexError, TypeError) as error:
        raise StoreError(f"`{path}` must have whole keyframes, but: {error}.") from None

"""A chunk of a sweep: the task of a worker, and the rows that it returns, without integrators.

Plain data go in and come out, so that they can travel to another process.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import PlainData
from ..columns import Arrays, Column, column, without_rows
from ..ensembles import ensemble, outcomes
from ..ensembles.top_events import event_table
from ..mechanics.variables import Variables
from ..problem import Problem
from ..scenario import build
from ..scenario.identity import Records
from ..store import provenance


Rows = Arrays  # the columns of a chunk by name
# names in `keep` for several columns; those of the orientation are left out unless they are named
FINAL = "final_state"
DRIFT = "drift"
ORIENTATION = "orientation"
EVENTS = "events"  # the name in `keep` of the table of events, which is left out unless it is named


class Task(NamedTuple):
    """A chunk to compute.

    `sweep` makes one for each chunk that is to be done.
    """

    chunk: int  # its number; a worker does not use it
    tables: PlainData  # of the base scenario
    columns: Arrays  # numbers that vary, by dotted key such as "initial.theta", each (tops,), SI
    keep: list[str] | None  # columns that are kept; None: all
    versions: dict[str, str]  # of the store
    own: Records = ((), ())  # user-defined events and columns


class OtherVersions(Exception):
    """A worker has other releases than the sweep: its bits could differ."""


def compute_chunk(task: Task, threads: int = 1) -> Rows:
    """Compute the rows of a chunk: columns (tops, ...) by name, SI.

    They depend on the task and the model of the processor, not on `threads`: a store has equal bits
    on any workers of one model. Versions are compared here, the processor of a worker is not.
    Raises OtherVersions.
    """
    here = provenance.versions()
    if differ := [name for name in here if here[name] != task.versions.get(name)]:
        raise OtherVersions(
            f"the worker has other versions of {', '.join(differ)} than the sweep was begun with"
        )
    measured = measure(base_of(task.tables, task.own), task.columns, task.keep, threads)
    table = columns(measured, task.keep)
    return {name: each.values for name, each in table.items()}


def base_of(tables: PlainData, own: Records) -> Problem:
    """Return the problem of a scenario's tables; `own` are user-defined (events, columns).

    Tables are plain data and cannot contain formulas, so these records travel separately.
    """
    return build.problem(tables, build.system_of(tables).with_records(*own))


def measure(
    base: Problem, numbers: Arrays, keep: list[str] | None, threads: int = 1
) -> outcomes.Outcomes:
    """Run tops of a scenario as far as the columns `keep` require, and return their outcomes.

    `numbers` are those that vary, (tops,) by dotted key, SI; `keep` as in `Task`.
    """
    names = keep or []
    tops = ensemble.vary(base, numbers, orientation=ORIENTATION in map(_group, names))
    events = EVENTS in names
    return ensemble.measure(
        tops,
        threads=threads,
        wanted=[*names, *base.events] if events else keep,  # all events are logged
        lyapunov=outcomes.LYAPUNOV in names,
        events=events,
    )


def columns(measured: outcomes.Outcomes, keep: list[str] | None) -> dict[str, Column]:
    """Return the columns of tops that are kept, by name; `status` always is.

    Those of events have other rows: they are a part of a table, and are named `events/NAME`, by
    which `store` recognises them.
    """
    with np.errstate(all="ignore"):  # of invalid tops
        table = {**outcomes.table(measured), **_final_states(measured)}
    kept = None if keep is None else {*keep, "status"}
    found = {n: c for n, c in table.items() if kept is None or {n, _group(n)} & kept}
    if EVENTS in (kept or ()):
        for name, (dims, values, attrs) in event_table(measured).items():
            found[f"{EVENTS}/{name}"] = Column(("row", "part", *dims[1:]), values[:, None], attrs)
    return found


def _final_states(measured: outcomes.Outcomes) -> dict[str, Column]:
    """Return the integrated variables at the end of each run, SI; NaN where there was no run."""
    tops = measured.tops
    # the records of the form's variables and of its integrals
    q, carried = tops.variables.split(measured.final)
    values = {**q._asdict(), **carried._asdict()}
    # the orientation has other columns
    plain = Variables(tops.base.form, orientation=False)
    return {
        f"final_{name}": column(
            values[name] * tops.unit(unit), unit, f"{name} at the end", ("top",)
        )
        for name, unit in plain.units.items()
    }


def column_schema(base: Problem, keep: list[str] | None) -> dict[str, Column]:
    """Return the columns that a sweep keeps, labelled, without a row, for the header of a store."""
    invalid = {"run.until": np.array([np.nan])}  # an invalid top is not run
    return without_rows(columns(measure(base, invalid, keep), keep))


def keep_choices(base: Problem) -> list[str]:
    """Return the valid names of `keep`: columns, groups of columns, and `lyapunov`.

    Columns have one row a top, and differ from those of a single run (`problem.column_names`).
    """
    oriented = [ORIENTATION, *outcomes.ORIENTATION] if base.form.orientation else []
    return [*column_schema(base, None), FINAL, DRIFT, EVENTS, *oriented, outcomes.LYAPUNOV]


def _group(name: str) -> str:
    """Return the name by which `keep` selects a column: of its group, or its own."""
    if name in outcomes.ORIENTATION:
        return ORIENTATION
    return FINAL if name.startswith("final_") else DRIFT if name.startswith("drift_") else name

"""A chunk of a sweep: what a worker is sent, and the rows that it gives back.

Numbers travel, no integrators.
"""

from typing import Any, NamedTuple

import numpy as np

from ..columns import Column
from ..ensembles import ensemble, outcomes
from ..ensembles.hybrid_tops import Ended
from ..mechanics.variables import Variables
from ..problem import Problem, derivative_faults
from ..runs.run import run_to_end
from ..scenario import build
from ..store import provenance


FINAL, DRIFT = "final_state", "drift"  # in `keep`, names for all columns that begin so
ORIENTATION = (
    "orientation"  # in `keep`, the name for its columns, which are left out unless they are named
)


class Task(NamedTuple):
    """A chunk to compute: its number, the base scenario, the numbers of its tops, the columns that
    are kept (None: all), and the versions that the store promises.
    """

    chunk: int
    tables: dict[str, Any]
    columns: dict[str, np.ndarray]
    keep: list[str] | None
    versions: dict[str, str]


class Rows(NamedTuple):
    """What a worker gives back: the columns of a chunk by name, and "heyoka" if its loop made
    steps, else nothing.
    """

    columns: dict[str, np.ndarray]
    steps_by: str


class OtherVersions(Exception):
    """A worker has other releases than the sweep was begun with: its bits could differ."""


def compute_chunk(task: Task, threads: int = 1) -> Rows:
    """The rows of a chunk. What it computes depends on the task alone."""
    if provenance.versions() != task.versions:
        differ = [
            name
            for name, release in provenance.versions().items()
            if release != task.versions.get(name)
        ]
        raise OtherVersions(
            f"the worker has other versions of {', '.join(differ)} than the sweep was begun with"
        )
    measured = measure(build.problem(task.tables), task.columns, task.keep, threads)
    table = columns(measured, task.keep)
    return Rows({name: column.values for name, column in table.items()}, measured.steps_by)


def measure(
    base: Problem, numbers: dict[str, np.ndarray], keep: list[str] | None, threads: int = 1
) -> outcomes.Outcomes:
    """Runs tops as far as what is kept of them needs it."""
    oriented = any(_group(name) == ORIENTATION for name in keep or [])
    chaos = outcomes.LYAPUNOV in (keep or [])
    tops = ensemble.vary(base, numbers, orientation=oriented)
    wanted = [*(keep or []), "t_end"] if chaos else keep
    return ensemble.measure(tops, threads=threads, wanted=wanted, alone=alone, lyapunov=chaos)


def alone(problem: Problem) -> Ended:
    """Runs one top by itself."""
    return Ended(*run_to_end(problem))


def columns(measured: outcomes.Outcomes, keep: list[str] | None) -> dict[str, Column]:
    """The rows of tops as labelled columns; `status` is among them whatever is kept."""
    with np.errstate(all="ignore"):  # of invalid tops
        table = {**outcomes.table(measured), **_final_states(measured)}
    return {
        name: column
        for name, column in table.items()
        if name == "status" or keep is None or _kept(name, keep)
    }


def _final_states(measured: outcomes.Outcomes) -> dict[str, Column]:
    """The integrated variables at the end of each run, SI, as columns `final_ux`, ...; NaN where
    there was no run.
    """
    tops = measured.tops
    q, carried = tops.variables.split(measured.final)
    values = {**q._asdict(), **carried._asdict()}
    plain = Variables(
        tops.base.form, orientation=False
    )  # what is carried for the orientation is read from its columns
    return {
        f"final_{name}": Column(
            ("top",),
            values[name] * tops.unit(unit),
            {"units": unit.symbol, "long_name": f"{name} at the end"},
        )
        for name, unit in plain.units.items()
    }


def column_schema(base: Problem, keep: list[str] | None) -> dict[str, Column]:
    """Labelled columns without a row."""
    table = columns(
        measure(base, {"run.until": np.array([np.nan])}, keep), keep
    )  # an invalid top is not run
    return {name: Column(c.dims, c.values[:0], c.attrs) for name, c in table.items()}


def column_names(base: Problem) -> list[str]:
    """What `keep` may name: columns, and the groups of columns `final_state`, `drift` and
    `orientation`; where there are derivatives, `lyapunov`.
    """
    oriented = [ORIENTATION, *outcomes.ORIENTATION] if base.form.orientation else []
    chaos = [] if derivative_faults(base) else [outcomes.LYAPUNOV]
    return [name for name in column_schema(base, None) if name != "status"] + [
        FINAL,
        DRIFT,
        *oriented,
        *chaos,
    ]


def _kept(name: str, keep: list[str]) -> bool:
    return _group(name) in keep or name in keep


def _group(name: str) -> str:
    """The name that stands in `keep` for a column and others like it."""
    if name in outcomes.ORIENTATION:
        return ORIENTATION
    return FINAL if name.startswith("final_") else DRIFT if name.startswith("drift_") else name

"""Accuracy contract: the drift that a run may show, and its comparison with a wider precision.

Root attributes or a problem go in; out come sentences on what a run must keep and does not, and the
data of `results.Certificate`.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Column
from ..errors import InputError
from ..problem import Problem
from . import phases
from .attributes import groups
from .reporting import Progress
from .run import solve, with_rows_at


# Largest relative drift that a run may show, by invariant.
MAX_DRIFT = {"jellett": 1e-13, "axis_norm": 1e-13, "energy_balance": 1e-12}
# The same for all other integrals (Routh's function, L_z, L_3).
MAX_DRIFT_DEFAULT = 1e-12
# Rounding errors accumulate like a random walk: beyond this time [s] the bounds grow with sqrt(t).
DRIFT_GROWS_AFTER = 1e4
# The contract holds for runs at machine precision (2^-52 = 2.2e-16), not for looser tolerances.
MAX_TOLERANCE = 2.3e-16
# Largest difference in theta [rad] between a run and its repetition in the next wider precision.
MAX_THETA_ERROR = 1e-10
NEXT_PRECISION: dict[str, Any] = {"double": "longdouble", "longdouble": "quad"}
CERTIFICATE_ROWS = 2001
# Thresholds of contact that both runs share, with their effect on theta [rad]: see the manual.
THRESHOLDS = {
    "disc": "a disc that comes to rest, or leaves its rest (up to 1e-5 rad)",
    "both": "a body that comes to stand on both balls (up to 1e-7 rad)",
    "impact": "sliding that begins within an impact with torques (up to 1e-8 rad)",
}


def broken_promises(attrs: PlainData) -> list[str]:
    """Return one message for each promise that a run with these root attributes does not keep."""
    broken = contract_violations(attrs["report"], attrs["tolerance"])
    if "certificate" in attrs:
        broken += certificate_violations(attrs["certificate"])
    return [f"the accuracy contract is broken: {sentence}" for sentence in broken]


def contract_violations(report: PlainData, tolerance: float) -> list[str]:
    """Return one message for each drift in a report that exceeds the contract."""
    if tolerance > MAX_TOLERANCE:
        return []
    messages = []
    for name, drift in report["drift"].items():
        bound = _bound(name, report["t_end"])
        if drift is None:  # JSON has no NaN
            drift = math.nan
        if not drift <= bound:  # also true for NaN
            label = name.replace("_", " ")
            messages.append(
                f"the drift of {label} must be at most {bound:.1e}, but is {drift:.1e}."
            )
    return messages


def broken_by_tops(table: Any, tolerance: float) -> list[str]:
    """Return a message if tops of a table, (top,), drift beyond the contract; else nothing."""
    t_end = table.get("t_end", math.inf)  # a plan may leave it out: no bound is exceeded then
    beyond = [
        table[column] > _bound(column.removeprefix("drift_"), t_end)
        for column in table
        if column.startswith("drift_") and tolerance <= MAX_TOLERANCE
    ]
    count = np.count_nonzero(np.any(beyond, axis=0))
    tops = f"{count} of {table.sizes['top']} tops: see their columns drift_NAME"
    return [f"the accuracy contract is broken by {tops}."] if count else []


def _bound(name: str, t_end: Any) -> Any:
    """Return the largest relative drift of an invariant that a run up to `t_end` [s] may show."""
    growth = np.sqrt(np.maximum(1.0, t_end / DRIFT_GROWS_AFTER))
    return MAX_DRIFT.get(name, MAX_DRIFT_DEFAULT) * growth


def certificate(
    problem: Problem,
    window: float | None = None,
    progress: Progress | None = None,
) -> PlainData:
    """Repeat a run in the next wider precision and compare.

    Parameters
    ----------
    problem : Problem
        The run; it is repeated from its start, in its own precision too.
    window : float, optional
        Compare only the first `window` seconds. By default the whole run.
    progress : callable, optional
        Called with the progress of each of the two runs.

    Returns
    -------
    dict
        Largest differences of every column of the trajectory (`columns`), of the times of the
        significant turnings and of each column of phases and impacts, in SI units; if the two runs
        have different numbers of them, only these `counts`. `theta` [rad] is that of theta again,
        if the system has it. `against` is None if there is no wider precision. `thresholds` of
        contact have an effect that no wider precision shows. Stores keep it as an attribute, of
        which `certificate_violations` and `summary.certificate_sentence` are made.
    """
    if problem.precision not in NEXT_PRECISION:
        return {"against": None, "reason": "no wider precision than quad"}
    if window is not None and not 0 < window < math.inf:
        raise InputError(f"`window` must be greater than 0 and finite, but is {window:g}.")
    until = min(problem.until, window or problem.until)
    times = np.linspace(0.0, until, CERTIFICATE_ROWS)
    # the turn of the body has no effect on the motion; tolerance 0: the rounding of the precision
    narrow = with_rows_at(problem, times, orientation=False)
    wide = dataclasses.replace(narrow, precision=NEXT_PRECISION[problem.precision], tolerance=0.0)
    run = solve(narrow, progress)
    reference = solve(wide, progress)
    tables = groups(run)
    expected = groups(reference)
    columns = _differences(tables["trajectory"], expected["trajectory"])
    largest = {name: _largest(values) for name, values in columns.items() if name != "time"}
    result: PlainData = {
        "against": wide.precision,
        "window": [0.0, min(until, run.report["t_end"])],
        "same_end": run.status is reference.status,
        "columns": largest,
    }
    if "theta" in columns:
        result["theta"] = float(columns["theta"].max(initial=0.0))  # NaN is a violation
    logs = (each.events.of("turning", significant=True) for each in (run, reference))
    compared = _compare(*({"time": log["time"]} for log in logs))
    if any(compared["counts"]):
        result["turnings"] = compared
    for name in phases.DIMENSIONS:
        if name in tables:
            result[name] = _compare(tables[name], expected[name])
    result["thresholds"] = [] if problem.contact is None else _thresholds(problem, tables)
    return result


def _thresholds(problem: Problem, tables: Mapping[str, Any]) -> list[str]:
    """Return the thresholds that the run met and that change its motion by more than 1e-12.

    They are sentences; `tables` are the tables of the run, as Datasets or columns by name.
    """
    kinds = problem.system.tables

    def words(table: str, column: str) -> set[str]:
        """Return the words that occur in a column of a table."""
        return {kinds[table][column][k] for k in tables[table][column].values}

    sticks = words("impacts", "mode") - {"slip"} if problem.law.torque else {}
    labels = words("phases", "phase")
    rests = "rest" in labels or (sticks and problem.law.regions)  # only laws of a disc have regions
    met = {"disc": rests, "both": "both" in labels, "impact": sticks}
    return [text for name, text in THRESHOLDS.items() if met[name]]


def certificate_violations(result: PlainData) -> list[str]:
    """Return one message for each way in which the wider run contradicts the run.

    `result` is what `certificate` returns, perhaps read from a store.
    """
    if result["against"] is None:
        return []
    messages = []
    if "theta" in result and not result["theta"] <= MAX_THETA_ERROR:  # also true for NaN
        messages.append(
            f"theta must be within {MAX_THETA_ERROR:.0e} of the wider run, but differs by "
            f"{result['theta']:.1e}."
        )
    if not result["same_end"]:
        messages.append("the run must end as the wider run does, but ends otherwise.")
    return messages


def _differences(
    table: Mapping[str, Column], reference: Mapping[str, Column]
) -> dict[str, np.ndarray]:
    """Return the absolute differences of each column of numbers, by name, SI, (rows,) each.

    Columns of flags are left out, as are rows that one table lacks; angles may differ by 2 pi.
    """
    result = {}
    for name, column in table.items():
        if "flag_meanings" in column.attrs:
            continue
        rows = min(len(column.values), len(reference[name].values))
        difference = np.abs(column.values[:rows] - reference[name].values[:rows])
        if column.attrs["units"] == "rad":
            difference = np.minimum(difference, np.abs(difference - 2 * np.pi))  # phi and psi jump
        result[name] = difference
    return result


def _largest(differences: np.ndarray) -> float:
    """Return the largest difference; rows in which a column is undefined (NaN) do not count."""
    return float(np.nanmax(differences, initial=0.0))


def _compare(table: Mapping[str, Column], reference: Mapping[str, Column]) -> PlainData:
    """Return how two tables differ, row by row, as plain data.

    `compared` is the number of rows, `counts` that of each table, and each column has its largest
    difference, SI. Tables with different numbers of rows are not compared: `compared` is 0.
    """
    rows, expected = counts = [len(next(iter(each.values())).values) for each in (table, reference)]
    if rows != expected:
        return {"compared": 0, "counts": counts}
    largest = {name: _largest(d) for name, d in _differences(table, reference).items()}
    return {"compared": rows, "counts": counts, **largest}

"""Derivatives of every column, and of the times and angles of events, along a run."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...columns import Column, column, flag_attributes
from ...mechanics.units import SECOND
from ...problem import Problem
from ..observables import sources
from ..orientation import quaternion
from ..tangent import Tangents
from ..variational import TURN
from .through import Pass


PARAMETER = "parameter"
OTHER = "parameter_2"
NONE_BELOW = 1e-9
"""Relative change of a number within which the phases must follow each other as they do."""
OF_EVENT = "of the event, as the numbers change"


class Derivatives(NamedTuple):
    """The derivatives of a run, as columns by name.

    Parameters
    ----------
    trajectory
        Along time and parameter.
    events
        Along event and parameter: of the time of an event, and of theta there.
    second
        Along time, parameter and a second parameter; none where they were not asked for.
    moments
        Of the times in further tables, by the dimension of each.
    sentences
        Why there are no derivatives, where there are none.
    """

    trajectory: dict[str, Column]
    events: dict[str, Column]
    second: dict[str, Column]
    moments: dict[str, dict[str, Column]]
    sentences: list[str]


def differentiate(
    problem: Problem,
    wrt: Sequence[str],
    times: np.ndarray,
    events: Any,
    order: int = 1,
    moments: Mapping[str, np.ndarray] = {},
) -> Derivatives:
    """Return the derivatives of the columns and events of a run by some of its numbers.

    Parameters
    ----------
    problem
        The run, in doubles.
    wrt
        Dotted names of numbers.
    times
        Of the rows [s], (n,), ascending, up to the end of the run.
    events
        Those of the run: arrays `time` [s] and `kind`, (n,), and the names `kinds`.
    order
        1, or 2 for second derivatives of the columns too.
    moments
        Times at which phases change [s], by the dimension of their table.

    Returns
    -------
    Derivatives
        SI units per SI unit.

    Raises
    ------
    InputError
        If the run has no derivatives, or a name is wrong.
    """
    n = len(wrt)
    i = j = np.arange(n)
    every = np.unique(np.concatenate([[0.0], times, events.time]))
    passed: Any = None
    if problem.system.is_hybrid:
        passed = Pass(problem, wrt, every / problem.unit(SECOND))
        sizes = passed.numbers.sizes
        values = passed.read()
    else:
        tangents = Tangents(problem, wrt)
        sizes = np.array([tangents.scale(name) for name in wrt])
        if order == 2:
            i, j = np.tril_indices(n)  # second derivatives along means of two directions too
        ways = (tangents.directions[:, i] + tangents.directions[:, j]) / 2
        values = tangents.read(order, tangents.parameters(ways), every[:, None])
    own = i == j

    rows = np.searchsorted(every, times)
    time = column(times, SECOND, "time")
    found = Derivatives({"time": time}, {}, {"time": time} if order == 2 else {}, {}, [])
    for name, source in sources(problem).items():
        if source.flags:
            continue
        if name == "orientation":
            whole = _quaternions(values)
        else:
            whole = np.array([values[part] for part in source.parts])
        whole = whole[:, :, rows]
        if passed:
            whole = np.array([passed.in_units(part, source.unit) for part in whole])
        whole = whole * problem.unit(source.unit)
        first = whole[:, 1][..., own] / sizes
        symbol = source.unit.symbol
        found.trajectory[name] = _column(first, symbol, name, ("time", PARAMETER), source.dims)
        if order == 2:
            mixed = _mixed(whole[:, 2], i, j) / np.outer(sizes, sizes)
            by = "time", PARAMETER, OTHER
            found.second[name] = _column(mixed, symbol, name, by, source.dims)

    at = np.searchsorted(every, events.time)
    names = [events.kinds[kind] for kind in events.kind]
    second = problem.unit(SECOND)
    if passed:
        shift = passed.times_of(names, events.time / second) * second
    else:
        shift = np.full((len(names), len(sizes)), np.nan)
        for k, name in enumerate(names):
            if f"event {name}" in values:
                function = values[f"event {name}"][:, at[k]]
                with np.errstate(divide="ignore", invalid="ignore"):  # it stays zero
                    shift[k] = (-function[1] / function[-1])[own]
    pace = values["theta_dot"][0][:, own] / second
    by_time = shift / sizes
    by_theta = (values["theta"][1][at][:, own] + pace[at] * shift) / sizes
    found.events.update(
        kind=Column(("event",), events.kind, flag_attributes(events.kinds, "kind of event")),
        time=_column(by_time[None], "s", f"the time {OF_EVENT}", ("event", PARAMETER)),
        theta=_column(by_theta[None], "rad", f"theta {OF_EVENT}", ("event", PARAMETER)),
    )
    if passed:
        for name, some in moments.items():
            shift = passed.times_of([""] * len(some), some / second) * second / sizes
            moved = _column(shift[None], "s", "the time, as the numbers change", (name, PARAMETER))
            found.moments[name] = {"time": moved}
        _limit(
            found, passed.margins(), wrt, second, {"time": times, "event": events.time, **moments}
        )
    return found


def _limit(
    found: Derivatives, notes: Sequence[Any], wrt: Sequence[str], second: float, times: Any
) -> None:
    """Add `valid_within` to the tables of first derivatives, and remove undefined derivatives."""
    least = np.fmin.accumulate([np.full(len(wrt), np.inf), *(note.least for note in notes)])
    starts = np.array([note.time for note in notes]) * second
    every = {"time": found.trajectory, "event": found.events, **found.moments}
    for by, table in every.items():
        within = least[np.searchsorted(starts, times[by], side="right")]
        for one in table.values():
            if one.dims[1:2] == (PARAMETER,):
                one.values[within < NONE_BELOW] = np.nan
        text = "relative change of the number up to which the phases follow each other as they do"
        table["valid_within"] = Column((by, PARAMETER), within, {"units": "1", "long_name": text})
    for name, course in zip(wrt, least[1:].T, strict=True):
        none = np.flatnonzero(course < NONE_BELOW)
        if len(none):
            note = notes[none[0]]
            found.sentences.append(
                f"from t = {note.time * second:.6g} s on there are no derivatives by {name}: "
                f"{note.what} turns out otherwise at a relative change of {course[none[0]]:.1g}"
            )


def _mixed(along: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return second derivatives by n numbers, (..., n, n).

    `along` are those along the means of the directions i and j, (..., lanes).
    """
    n = i[-1] + 1
    means = np.empty((*along.shape[:-1], n, n))
    means[..., i, j] = means[..., j, i] = along
    own = along[..., i == j]
    return 2 * means - (own[..., None] + own[..., None, :]) / 2


def _column(
    values: np.ndarray, units: str, subject: str, by: tuple[str, ...], dims: tuple[str, ...] = ()
) -> Column:
    """Return a column of derivatives (parts, ...), SI per SI, along `by` and then `dims`."""
    attributes = {
        "units": f"{units} per unit of the parameter",
        "long_name": f"derivative of {subject}",
    }
    return Column((*by, *dims), np.moveaxis(values, 0, -1) if dims else values[0], attributes)


def _quaternions(values: dict[str, np.ndarray]) -> np.ndarray:
    """Return unit quaternions with their derivatives along the line, (4, derivatives, rows, lanes).

    The entries of P = 4 q q^t are known: P' q = 4 q' and P'' q = 4 (q'' - q |q'|^2), as |q| = 1.
    """
    products = np.array([values[name] for name in TURN])
    products = products.reshape(4, 4, *products.shape[1:])
    q = quaternion(products[:, :, 0])
    turns = np.einsum("ijk...,j...->ik...", products, q) / 4
    turns[:, 0] = q
    if turns.shape[1] > 2:
        turns[:, 2] += q * (turns[:, 1] ** 2).sum(axis=0)
    return turns

"""Derivatives of every column, and of the times and angles of events, along a run."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...columns import Column, column, flag_attributes
from ...mechanics.units import SECOND
from ...problem import Problem
from ..observables import sources
from ..orientation import quaternion
from ..tangent import Tangents
from ..variational import TURN


PARAMETER = "parameter"
OTHER = "parameter_2"
OF_EVENT = "of the event, as the numbers change"


class Derivatives(NamedTuple):
    """Columns of derivatives by name.

    Parameters
    ----------
    trajectory
        Along time and parameter.
    events
        Along event and parameter: of the time of an event, and of theta there.
    second
        Along time, parameter and a second parameter; none where they were not asked for.
    """

    trajectory: dict[str, Column]
    events: dict[str, Column]
    second: dict[str, Column]


def differentiate(
    problem: Problem, wrt: Sequence[str], times: np.ndarray, events: Any, order: int = 1
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

    Returns
    -------
    Derivatives
        SI units per SI unit.

    Raises
    ------
    InputError
        If the run has no derivatives, or a name is wrong.
    """
    tangents = Tangents(problem, wrt)
    n = len(wrt)
    sizes = np.array([tangents.scale(name) for name in wrt])
    i = j = np.arange(n)
    if order == 2:
        i, j = np.tril_indices(n)  # second derivatives along means of two directions too
    own = i == j
    ways = (tangents.directions[:, i] + tangents.directions[:, j]) / 2
    every = np.unique(np.concatenate([[0.0], times, events.time]))
    values = tangents.read(order, tangents.parameters(ways), every[:, None])

    rows = np.searchsorted(every, times)
    time = column(times, SECOND, "time")
    found = Derivatives({"time": time}, {}, {"time": time} if order == 2 else {})
    for name, source in sources(problem).items():
        if source.flags:
            continue
        if name == "orientation":
            whole = _quaternions(values)
        else:
            whole = np.array([values[part] for part in source.parts])
        whole = whole[:, :, rows] * problem.unit(source.unit)
        first = whole[:, 1][..., own] / sizes
        symbol = source.unit.symbol
        found.trajectory[name] = _column(first, symbol, name, ("time", PARAMETER), source.dims)
        if order == 2:
            mixed = _mixed(whole[:, 2], i, j) / np.outer(sizes, sizes)
            by = "time", PARAMETER, OTHER
            found.second[name] = _column(mixed, symbol, name, by, source.dims)

    by_time, by_theta = np.full((2, len(events.time), n), np.nan)
    for event in problem.system.events:
        of = np.flatnonzero(events.kind == events.kinds.index(event.name))
        at = np.searchsorted(every, events.time[of])
        name = f"event {event.name}"
        with np.errstate(divide="ignore", invalid="ignore"):  # the function stays zero
            shift = -values[name][1, at] / values[name][-1, at]
        theta = values["theta"][1, at] + values["theta"][-1, at] * shift
        by_time[of], by_theta[of] = shift[:, own] / sizes, theta[:, own] / sizes
    found.events.update(
        kind=Column(("event",), events.kind, flag_attributes(events.kinds, "kind of event")),
        time=_column(by_time[None], "s", f"the time {OF_EVENT}", ("event", PARAMETER)),
        theta=_column(by_theta[None], "rad", f"theta {OF_EVENT}", ("event", PARAMETER)),
    )
    return found


def _mixed(along: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return second derivatives by n numbers, (..., n, n), of those along the means of the
    directions i and j, (..., lanes).
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

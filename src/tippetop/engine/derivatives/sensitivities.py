"""Derivatives of every column, and of the times and angles of events, along a run.

A problem and names of its numbers go in; tables of derivatives as columns in SI units come out, and
sentences where there are none. `library.derivatives` calls it.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...columns import Column, column, flag_attributes
from ...mechanics.units import SECOND
from ...problem import Problem
from ..observables import sources
from .through import followed


PARAMETER = "parameter"
OTHER = "parameter_2"
NONE_BELOW = 1e-9
"""Relative change of a number within which the phases must follow each other as they do."""
OF_EVENT = "of the event, as the numbers change"


def differentiate(
    problem: Problem,
    wrt: Sequence[str],
    times: np.ndarray,
    events: Any,
    order: int = 1,
    moments: Mapping[str, Any] = {},
    driver: Any = None,
) -> tuple[dict[str, dict[str, Column]], list[str]]:
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
        The `runs.events.EventTable` of the run: `time` [s] and `kind`, (n,), and the names `kinds`.
    order
        1, or 2 to add second derivatives of the columns.
    moments
        Columns of times at which phases change [s], by the name of their table.
    driver
        The `HybridDriver` of the run, at its end, with its `intervals` (`runs.run.with_phases`);
        only read if the contact may change its phase.

    Returns
    -------
    tables
        SI units per SI unit: `trajectory`, along time and parameter; `events`, of the time of an
        event, and of theta there; `second`, along time and two parameters, empty for order 1; and
        one table for each of `moments`. The keys are fields of `library.derivatives.Sensitivities`.
    sentences
        Why there are no derivatives, where there are none.

    Raises
    ------
    InputError
        If the run has no derivatives, or a name is wrong.
    """
    n = len(wrt)
    # second derivatives along means of two directions too
    i, j = np.tril_indices(n) if order == 2 else np.diag_indices(n)
    own = i == j  # directions that change one number; the others serve mixed derivatives only
    every = np.unique(np.concatenate([[0.0], times, events.time]))
    # means of two directions, as `_mixed` takes them: a change of one is a change of both
    ways = (np.eye(n)[:, i] + np.eye(n)[:, j]) / 2
    passed = followed(problem, wrt, every, driver, ways, order)
    sizes = passed.sizes[:, None]
    values = passed.read()

    rows = np.searchsorted(every, times)
    time = column(times, SECOND, "time")
    trajectory = {"time": time}
    second = {"time": time} if order == 2 else {}
    for name, source in sources(problem).items():
        if source.flags:
            continue
        scale = passed.scales.of(source.unit)
        each = [(values[part] * scale).parts for part in source.parts]
        _, *derivatives = zip(*each, strict=True)
        first, *others = (np.array(parts)[..., rows] for parts in derivatives)
        symbol = source.unit.symbol
        by = "time", PARAMETER
        trajectory[name] = _column(first[:, own] / sizes, symbol, name, by, source.dims)
        for other in others:
            mixed = _mixed(other, i, j) / (sizes * sizes.T)[..., None]
            second[name] = _column(mixed, symbol, name, (*by, OTHER), source.dims)

    at = np.searchsorted(every, events.time)
    unit = problem.unit(SECOND)

    def moved(names: Any, when: np.ndarray) -> np.ndarray:
        """Return the derivatives of the times `when` [s] of events by each number, SI.

        `names` are their kinds, or "" for starts of phases; the result is (numbers, events).
        """
        return passed.times_of(names, when / unit)[own] * unit / sizes

    by_time = moved([events.kinds[kind] for kind in events.kind], events.time)
    # at the event: theta changes at a fixed time, and moves with the time of the event
    pace = values["theta_dot"].value[at]
    by_theta = values["theta"].first[own][:, at] / sizes + pace / unit * by_time
    by = "event", PARAMETER
    tables = {
        "trajectory": trajectory,
        "second": second,
        "events": {
            "kind": Column(by[:1], events.kind, flag_attributes(events.kinds, "kind of event")),
            "time": _column(by_time[None], "s", f"the time {OF_EVENT}", by),
            "theta": _column(by_theta[None], "rad", f"theta {OF_EVENT}", by),
        },
    }
    if not problem.system.is_hybrid:
        return tables, []
    whens = {"trajectory": times, "events": events.time}
    for name, moment in moments.items():
        whens[name] = moment.values
        by_time = moved("", moment.values)
        by = *moment.dims, PARAMETER
        tables[name] = {"time": _column(by_time[None], "s", "the time, as the numbers change", by)}
    return tables, _limit(tables, passed.margins(), wrt, unit, whens)


def _limit(
    tables: dict[str, dict[str, Column]],
    notes: Sequence[Any],
    wrt: Sequence[str],
    unit: float,
    whens: Mapping[str, np.ndarray],
) -> list[str]:
    """Add `valid_within` to tables, and make undefined derivatives NaN, in place.

    Return sentences on why they are undefined. Only for runs whose contact may change.

    Parameters
    ----------
    tables
        Columns of derivatives by table.
    notes
        `Pass.margins()`, ascending in time: a change of a number is valid up to the least of the
        notes at or before the time of a row.
    wrt
        Names of the numbers.
    unit
        The internal unit of time [s].
    whens
        The time of each row [s], by the name of each table that gets `valid_within`.
    """
    least = np.fmin.accumulate([np.full(len(wrt), np.inf), *(note.least for note in notes)])
    # least[k] is that of the first k notes, so the search counts the notes up to a row
    starts = np.array([note.time for note in notes]) * unit
    for name, when in whens.items():
        within = least[np.searchsorted(starts, when, side="right")]
        table = tables[name]
        for one in table.values():
            if one.dims[1:2] == (PARAMETER,):  # derivatives; the others are times and kinds
                one.values[within < NONE_BELOW] = np.nan
        text = "relative change of the number up to which the phases follow each other as they do"
        by = *table["time"].dims[:1], PARAMETER
        table["valid_within"] = Column(by, within, {"units": "1", "long_name": text})
    sentences = []
    for name, course in zip(wrt, least[1:].T, strict=True):
        k = np.sum(course >= NONE_BELOW)  # notes before the first that leaves no derivative
        if k < len(notes):
            note = notes[k]
            sentences.append(
                f"from t = {note.time * unit:.6g} s on there are no derivatives by {name}: "
                f"{note.what} turns out otherwise at a relative change of {course[k]:.1g}"
            )
    return sentences


def _mixed(along: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return all second derivatives by n numbers, (parts, n, n, times).

    `along` are second derivatives along lines, (parts, lines, times): line k goes along the mean of
    the directions of the numbers i[k] and j[k]. There is one for each pair i >= j, that of the last
    number at the end, as `np.tril_indices` has them. The mixed ones follow by polarisation.
    """
    n = i[-1] + 1
    means = np.empty((len(along), n, n, along.shape[-1]))
    means[:, i, j] = means[:, j, i] = along
    own = along[:, i == j]
    # along (a + b)/2 the derivative is (f_aa + 2 f_ab + f_bb)/4
    return 2 * means - (own[:, :, None] + own[:, None]) / 2


def _column(
    values: np.ndarray, units: str, subject: str, by: tuple[str, ...], dims: tuple[str, ...] = ()
) -> Column:
    """Return a column of derivatives (parts, numbers, times), SI per SI, along `by` and `dims`.

    All dimensions are reversed: `by` begins with the time, `dims` are those of the parts, if any.
    """
    attributes = {
        "units": f"{units} per unit of the parameter",
        "long_name": f"derivative of {subject}",
    }
    return Column((*by, *dims), (values if dims else values[0]).T, attributes)

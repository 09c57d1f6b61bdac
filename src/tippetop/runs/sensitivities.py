"""Derivatives that a scenario lists in addition to rows and events: made at its end."""

from typing import TYPE_CHECKING

import numpy as np

from ..columns import Column
from ..problem import MOST_DERIVATIVES, Problem
from .events import EventTable


if TYPE_CHECKING:
    from ..engine.derivatives.along_run import Derivatives

NAMES = ("sensitivities", "event_sensitivities")
# Rows per chunk.
PER_CHUNK = 1 << 12


def tables(problem: Problem, times: np.ndarray, events: EventTable) -> dict[str, dict[str, Column]]:
    """Return the tables of derivatives by name; possibly empty.

    Parameters
    ----------
    problem
        The run.
    times
        Of its rows [s], (n,).
    events
        Its log. Of a longer one than the derivatives may be (`MOST_DERIVATIVES`) those of the first
        events are computed, and the rest are NaN.
    """
    wrt = problem.sensitivities
    if not wrt:
        return {}
    from ..engine.derivatives.along_run import differentiate  # a fiftieth of a start

    most = MOST_DERIVATIVES // len(wrt)
    first = EventTable(events.kinds, *(values[:most] for values in events.columns().values()))
    derived = _named(problem, differentiate(problem, wrt, times, first))
    gap = np.full((max(len(events.time) - most, 0), len(wrt)), np.nan)
    if len(gap):
        derived[NAMES[1]] = {
            name: c._replace(
                values=events.kind if name == "kind" else np.concatenate([c.values, gap])
            )
            for name, c in derived[NAMES[1]].items()
        }
    return derived


def no_rows(problem: Problem, kinds: tuple[str, ...]) -> dict[str, dict[str, Column]]:
    """Return the tables without rows, by name."""
    if not problem.sensitivities:
        return {}
    from ..engine.derivatives.along_run import empty

    return _named(problem, empty(problem, problem.sensitivities, kinds))


def _named(problem: Problem, derived: "Derivatives") -> dict[str, dict[str, Column]]:
    """Return the tables of a store: each column of derivatives lists its numbers, in order."""
    by = {"parameters": " ".join(problem.sensitivities)}
    return {
        name: {
            key: c._replace(attrs=c.attrs | by) if len(c.dims) > 1 else c
            for key, c in columns.items()
        }
        for name, columns in zip(NAMES, (derived.trajectory, derived.events), strict=True)
    }

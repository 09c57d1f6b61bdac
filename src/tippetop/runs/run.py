"""A problem integrated in memory: the solution as it comes from the integrator, and the call that
makes it.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..columns import Column
from ..engine.observables import Observables
from ..engine.status import Status
from ..errors import InputError
from ..mechanics.caching import cached_property
from ..problem import Problem
from . import reporting, sensitivities
from .events import EventTable
from .integration import Integration
from .reporting import RunProgress
from .sinks import Memory


@dataclass
class Solution:
    """A problem integrated to its end, in memory: rows and events, and what was measured on the
    way.

    `library.run.Run` shows it to the user, with labels and in SI units.
    """

    progress: RunProgress  # at its end
    times: np.ndarray  # [s]
    rows: np.ndarray  # (n, variables), internal
    events: EventTable
    seconds: dict[str, float]  # where the time went: compile, integrate
    last_slice: dict[str, Any] | None = None  # where it began: what a longer run continues from
    others: dict[str, list[dict[str, np.ndarray]]] = field(
        default_factory=dict
    )  # parts of further tables

    @property
    def problem(self) -> Problem:
        """What was integrated."""
        return self.progress.problem

    @property
    def status(self) -> Status:
        """How it ended."""
        assert self.progress.status is not None
        return self.progress.status

    @property
    def final(self) -> np.ndarray:
        """The last good state, internal."""
        return self.progress.last[0]

    @cached_property
    def reason(self) -> str:
        """The same in a sentence."""
        return reporting.reason(self.progress)

    @cached_property
    def report(self) -> dict[str, Any]:
        """What was measured on the way."""
        return reporting.report(self.progress)

    @cached_property
    def sensitivities(self) -> dict[str, dict[str, Column]]:
        """The tables of derivatives that the scenario asks for, by name."""
        return sensitivities.tables(self.problem, self.times, self.events)

    def columns(self) -> dict[str, Any]:
        """The rows as named SI columns."""
        return Observables(self.problem).columns(self.times, self.rows)


LARGE_ROW = (
    1 << 14
)  # bytes that no row has: where so many fit, none need be made to see how large one is


def refuse_more_than_memory(problem: Problem) -> None:
    """Raises InputError for rows that this machine cannot hold: the states, and the columns that
    are made of them.
    """
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if problem.output != "times" or len(problem.times) * LARGE_ROW < there:
        return
    columns = Observables(problem).columns(np.zeros(1), problem.start()[None, :])
    per_row = sum(c.values.nbytes for c in columns.values()) + problem.start().nbytes + 8
    needed = len(problem.times) * per_row
    if needed > there:
        raise InputError(
            [
                f"{len(problem.times):.3g} rows of {per_row} bytes must fit in "
                f"{there / 1e9:.3g} GB of memory, but "
                f"take {needed / 1e9:.3g} GB: give a store (--out, out=), which takes any "
                "number, or a longer "
                "`run.output_step`."
            ]
        )


def run_to_end(problem: Problem) -> tuple[Status, np.ndarray, dict[str, Any], dict[str, Any], bool]:
    """Integrates a problem and keeps its end alone: status, final internal state, report, what
    events keep of their passages, and whether it has settled.
    """
    integration = Integration(problem)
    integration.run(Memory(keeps_rows=False))
    end = integration.progress()
    assert end.status is not None
    return (
        end.status,
        end.last[0],
        reporting.report(end),
        end.events.kept(),
        end.settled_since is not None,
    )


def _joined(pieces: list[np.ndarray], empty: np.ndarray) -> np.ndarray:
    """Pieces as one array: of a single one, itself."""
    return pieces[0] if len(pieces) == 1 else np.concatenate([empty, *pieces])


def solve(
    problem: Problem, progress: Callable[[RunProgress], None] | None = None, *, keep: bool = True
) -> Solution:
    """Integrates a problem to its end, gathering rows and events in memory.

    Parameters
    ----------
    problem
        What is integrated.
    progress
        Called after every slice.
    keep
        Whether rows and events are kept. If not, nobody can read the orientation of the body, and
        its integrals are left out: they have no effect on the motion, but cost 1.0 to 1.24 times
        its equations.

    Returns
    -------
    Solution
        Its `problem` is what was integrated: without orientation if nothing was kept.
    """
    if keep:
        refuse_more_than_memory(problem)
    else:
        problem = replace(problem, orientation=False)
    integration, memory = Integration(problem), Memory(keep)
    integration.run(memory, progress)
    return Solution(
        integration.progress(),
        _joined(memory.times, np.zeros(0)),
        _joined(memory.states, integration.first[:0]),
        memory.table(),
        integration.seconds,
        integration.last_slice,
        memory.others,
    )

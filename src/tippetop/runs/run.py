"""Integrate a problem in memory.

A `Problem` goes in, a `Solution` comes out, with its rows in internal units.
"""

import os
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..engine.observables import Observables
from ..engine.status import Status
from ..engine.taylor import driver_of
from ..errors import InputError
from ..mechanics.caching import cached_property
from ..problem import Problem
from ..sampling import ListedTimes
from . import reporting
from .events import EventTable
from .integration import Integration
from .phases import Rows
from .reporting import Progress, RunProgress
from .sinks import Memory, Sink


@dataclass
class Solution:
    """A problem integrated to its end, in memory: rows, events and measurements.

    `solve` makes it.

    `library.finished_run.Run` shows it to the user, with labels and in SI units.
    """

    progress: RunProgress  # at its end
    times: np.ndarray  # (n,) [s]
    rows: np.ndarray  # (n, variables), internal, at `times`
    events: EventTable
    seconds: dict[str, float]  # times of compiling and of integrating
    ending: dict[str, Any]  # states from which other runs continue: see `Integration.ending`
    others: dict[str, list[Rows]] = field(default_factory=dict)
    """Parts of the tables of phases and impacts, in order of time, by name: see `phases.joined`."""

    @property
    def problem(self) -> Problem:
        """Return the problem that was integrated."""
        return self.progress.problem

    @property
    def status(self) -> Status:
        """Return how the run ended."""
        assert self.progress.status is not None
        return self.progress.status

    @property
    def final(self) -> np.ndarray:
        """Return the last good state, internal."""
        return self.progress.last[0]

    @cached_property
    def reason(self) -> str:
        """Return a sentence about the end of the run."""
        return reporting.reason(self.progress)

    @cached_property
    def report(self) -> dict[str, Any]:
        """Return the measurements of the run, as `info --json` prints them."""
        return reporting.report(self.progress)

    def columns(self) -> dict[str, Any]:
        """Return the rows as named SI columns, computed anew by each call."""
        return Observables(self.problem).columns(self.times, self.rows)


def with_rows_at(
    problem: Problem, times: np.ndarray, *, orientation: bool = True, **changes: Any
) -> Problem:
    """Return a problem whose only rows are at these times [s], ascending; it ends at the last.

    They have all columns; without `orientation`, all but those of the turn about the axis.
    """
    return replace(
        problem,
        times=ListedTimes(times),
        until=float(times[-1]),
        output="times",
        stop_when="until",
        columns=None,
        orientation=orientation,
        **changes,
    )


def refuse_more_than_memory(problem: Problem) -> None:
    """Raise InputError for rows that this machine cannot hold as states and columns."""
    if problem.output != "times":
        return
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    # doubles: the state and the columns, and the time with each of the two
    per_row = 8 * (len(problem.variables.names) + len(problem.kept_columns) + 2)
    needed = len(problem.times) * per_row
    if needed > there:
        raise InputError(
            f"{len(problem.times):.3g} rows of {per_row} bytes must fit in {there / 1e9:.3g} GB "
            f"of memory, but take {needed / 1e9:.3g} GB: give a store (--out, out=), which takes "
            "any number, or a longer `run.output_step`."
        )


def solve(
    problem: Problem, progress: Progress | None = None, *, keep: bool = True, driver: Any = None
) -> Solution:
    """Integrate a problem to its end, gathering rows and events in memory.

    Parameters
    ----------
    problem
        The run.
    progress
        Called after every slice.
    keep
        Whether rows and events are kept. If not, the orientation of the body is not integrated:
        it has no effect on the motion, but costs 1.0 to 1.24 times its equations.
    driver
        That of the problem, at its start.

    Returns
    -------
    Solution
        Its `problem` is without orientation if nothing was kept.
    """
    if keep:
        refuse_more_than_memory(problem)
    else:
        problem = replace(problem, orientation=False)
    integration = Integration(problem, driver=driver)
    memory = Memory()
    integration.run(memory if keep else Sink(), progress)
    return Solution(
        integration.progress(),
        np.concatenate([np.zeros(0), *memory.times]),
        np.concatenate([integration.first[:0], *memory.states]),
        memory.table(),
        integration.seconds,
        integration.ending(),
        memory.others,
    )


def with_phases(problem: Problem) -> tuple[Solution, Any]:
    """Return the solution of a problem, and its driver, which has kept its phases: `intervals`."""
    driver: Any = driver_of(problem)
    driver.intervals = []
    return solve(problem, driver=driver), driver

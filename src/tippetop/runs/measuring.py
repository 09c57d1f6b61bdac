"""What a run takes on the computer at hand: its beginning is integrated, and timed."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..engine.status import Status
from ..problem import Problem
from ..sampling import EvenTimes, ListedTimes
from .integration import Integration
from .run import Solution, solve


WORTH = 0.2  # [s] of computing from which the rest is inferred
MOST = 1.0  # [s] that a piece may take
FIRST_STEPS, FIRST_ROWS = 100, 1000  # of the first piece, roughly


class _TooLong(Exception):
    """A piece took longer than it may."""


def measured(problem: Problem, steps: float, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Steps and seconds of a run of which the first part is integrated, and the seconds of compiling it.

    Parameters
    ----------
    problem
        The run.
    steps
        How many it may make; an order of magnitude.
    clock
        Seconds.

    Returns
    -------
    dict
        `steps` and `seconds` of the whole run, in memory; `compiling`, the seconds that compiling took now: the
        integrator is kept on disk. Nothing where the beginning itself takes too long.
    """
    shortest = problem.until * min(1.0, FIRST_STEPS / max(steps, 1.0), FIRST_ROWS / max(len(problem.times), 1))
    try:
        began = clock()
        _piece(problem, shortest / FIRST_STEPS, clock)
        middle = clock()
        _piece(problem, shortest / FIRST_STEPS, clock)
        fixed = clock() - middle
        compiling = middle - began - fixed
        until = shortest
        while True:
            began = clock()
            solution = _piece(problem, until, clock)
            took = max(clock() - began - fixed, 0.0)
            ended = solution.status is not Status.FINISHED
            if ended or until >= problem.until or took >= WORTH:
                break
            until = min(problem.until, until * min(8.0, max(2.0, WORTH / max(took, 1e-3))))
    except _TooLong:
        return {}
    whole = 1.0 if ended else problem.until / until
    return {
        "steps": round(solution.report["steps"] * whole),
        "seconds": round(fixed + took * whole, 4),
        "compiling": round(max(compiling, 0.0), 2),
    }


def _piece(problem: Problem, until: float, clock: Callable[[], float]) -> Solution:
    """The run up to some time, with its rows as columns. Raises _TooLong."""
    times: Any = problem.times
    if isinstance(times, EvenTimes):
        times = replace(times, until=until)
    else:
        times = ListedTimes(times.times[times.times <= until])
    began: list[float] = []

    def watch(integration: Integration) -> None:
        began.append(clock())  # the first slice comes after compiling
        if began[-1] - began[0] > MOST:
            raise _TooLong

    solution = solve(replace(problem, until=until, times=times), watch)
    solution.columns()
    return solution

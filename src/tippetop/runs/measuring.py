"""What a run takes on the computer at hand: its beginning is integrated, and timed."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ..engine.status import Status
from ..engine.taylor import driver_of
from ..problem import Problem
from ..sampling import EvenTimes, ListedTimes
from .reporting import RunProgress
from .run import Solution, solve


WORTH = 0.2  # [s] of computing from which the rest is inferred
MOST = 1.0  # [s] that a piece may take
FIRST_STEPS, FIRST_ROWS = 100, 1000  # of the first piece, roughly


FEWEST = 10  # steps of a piece that say how long steps are


class _TooLong(Exception):
    """A piece took longer than it may; `seconds` to the whole end, by how far it came."""

    def __init__(self, seconds: float):
        super().__init__(seconds)
        self.seconds = seconds


def measured(problem: Problem, steps: float, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Steps and seconds of a run of which the first part is integrated, and the seconds of compiling it.

    Parameters
    ----------
    problem
        The run.
    steps
        How many it may make; an order of magnitude. Where friction drills its beginning says what a step takes, but not
        how many there are: these count.
    clock
        Seconds.

    Returns
    -------
    dict
        `steps` and `seconds` of the whole run, in memory; `compiling`, the seconds that compiling took now: the
        integrator is kept on disk. Without `steps` where the beginning has too few of them, or takes too long.
    """
    shortest = problem.until * min(1.0, FIRST_STEPS / max(steps, 1.0), FIRST_ROWS / max(len(problem.times), 1))
    try:
        began = clock()
        if problem.system.is_hybrid:  # later phases would be compiled on the way
            driver_of(problem).prepare()  # type: ignore[attr-defined]  # it is a ContactDriver
        _piece(problem, shortest / FIRST_STEPS, steps, clock)
        middle = clock()
        _piece(problem, shortest / FIRST_STEPS, steps, clock)
        fixed = clock() - middle
        compiling = middle - began - fixed
        until = shortest
        while True:
            try:
                began = clock()
                solution = _piece(problem, until, steps, clock)
            except _TooLong:  # it may have compiled what it met on its way: the second time counts
                began = clock()
                solution = _piece(problem, until, steps, clock)
            took = max(clock() - began - fixed, 0.0)
            ended = solution.status is not Status.FINISHED
            if ended or until >= problem.until or took >= WORTH:
                break
            until = min(problem.until, until * min(8.0, max(2.0, WORTH / max(took, 1e-3))))
    except _TooLong as reached:
        return {"seconds": round(reached.seconds, 4)}
    whole, count = 1.0 if ended else problem.until / until, solution.report["steps"]
    if problem.law.regions and whole > 1:
        whole = max(1.0, steps / max(count, 1))
    steps_of_all = {"steps": round(count * whole)} if count >= FEWEST or whole == 1.0 else {}
    return {
        **steps_of_all,
        "seconds": round(fixed + took * whole, 4),
        "compiling": round(max(compiling, 0.0), 2),
    }


def _piece(problem: Problem, until: float, steps: float, clock: Callable[[], float]) -> Solution:
    """The run up to some time, with its rows as columns. Raises _TooLong."""
    times: Any = problem.times
    if isinstance(times, EvenTimes):
        times = replace(times, until=until)
    else:
        times = ListedTimes(times.times[times.times <= until])
    first: list[tuple[float, float]] = []  # clock and share after the first slice, which comes after compiling
    uneven = bool(problem.law.regions)

    def watch(progress: RunProgress) -> None:
        now = clock()
        share = progress.steps / max(steps, 1) if uneven else progress.t_end / problem.until
        if not first:
            first.append((now, share))
        seconds, advance = now - first[0][0], share - first[0][1]
        if seconds > MOST:
            raise _TooLong(seconds / max(advance, 1e-300))

    solution = solve(replace(problem, until=until, times=times), watch)
    solution.columns()
    return solution

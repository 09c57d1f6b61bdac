"""Compare a whole run with its motion, in time and processors, after a first run."""

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tippetop.engine.taylor import driver_of
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.runs.integration import Integration
from tippetop.runs.run import solve
from tippetop.runs.sinks import Sink

from .measure import interleaved, ratio, timed
from .minimal import Minimal
from .ours import alone, by_hand, end_of, motion, to_the_end


RUNS = {
    "canonical inversion": ("inverting", 10.0),
    "rolling tippe top": ("rolling", 400.0),
    "heavy top": ("heavy-top", 100.0),
    "cylinder that glides": ("gliding-cylinder", 4.0),
}
BESIDE = ("equations", "loop", "whole", "rows")
HAND = "canonical inversion"  # the run that is also typed into heyoka
HOPS, SMOOTH = "flying", "inverting"  # presets: the same top, which hops, or slides all along


def compare(quick: bool) -> dict[str, Any]:
    """Return processor seconds of motion, whole run and rows, and processor over wall time."""
    found: dict[str, Any] = {"title": "A whole run beside its motion", "runs": {}}
    for name, (preset, until) in RUNS.items():
        problem = starting.load(preset, None, until / 4 if quick else until)
        works = {
            what: partial(timed, work) for what, work in of(problem, hand=name == HAND).items()
        }
        seconds = interleaved(works, 5 if quick else 21)
        entry = {
            "form": problem.form.name,
            "seconds": {what: statistics.median(times) for what, times in seconds.items()},
            **{f"{way} / motion": ratio(seconds[way], seconds["motion"]) for way in BESIDE},
            **processors(partial(_often, problem)),
        }
        if name == HAND:
            entry["rows / by hand"] = ratio(seconds["rows"], seconds["by hand"])
        found["runs"][name] = entry
    found["hops"] = hops(5 if quick else 21)
    return found


def hops(rounds: int) -> dict[str, Any]:
    """Return the cost of a second of motion with rows, of a top that hops and one that slides."""
    problems = {name: starting.load(name) for name in (HOPS, SMOOTH)}
    seconds = interleaved(
        {name: partial(timed, partial(solve, problem)) for name, problem in problems.items()},
        rounds,
    )
    each = {name: [s / problem.until for s in seconds[name]] for name, problem in problems.items()}
    return {
        "seconds": {name: statistics.median(times) for name, times in each.items()},
        "changes": solve(problems[HOPS]).report["contact_phases"]["impacts"] * 2,
        "ratio": ratio(each[HOPS], each[SMOOTH]),
    }


def of(problem: Problem, *, hand: bool) -> dict[str, Callable[[], Any]]:
    """Return what is measured of a run, by name.

    motion
        The motion alone.
    equations
        With the integrals of a run.
    loop
        The compiled loop, with all that it finds, and the making of its driver.
    whole
        The whole run without rows, for which the orientation is not integrated.
    rows
        With the rows of its preset in memory, and the orientation.
    by hand
        The motion typed into heyoka.
    """
    minimal = Minimal(problem, np.array([problem.until]))
    moving, bare = motion((), minimal)(0.0), replace(problem, orientation=False)
    integrals, start = alone(bare), bare.start()

    def equations() -> None:
        integrals.time, integrals.state[:] = 0.0, start
        integrals.propagate_until(end_of(bare))

    works = {
        "motion": lambda: moving.work(None),
        "equations": equations,
        "loop": lambda: looped(bare),
        "whole": lambda: Integration(bare).run(Sink()),
        "rows": lambda: solve(problem),
    }
    if hand:
        plain = by_hand(False, minimal)(0.0)
        works["by hand"] = lambda: plain.work(None)
    return works


def looped(problem: Problem) -> None:
    """Drive the compiled loop to the end of a run, and keep nothing of what it finds."""
    to_the_end(driver_of(problem))


def _often(problem: Problem) -> None:
    """Run for half a second: the clock of the processor ticks each 10 ms."""
    end = time.perf_counter() + 0.5
    while time.perf_counter() < end:
        Integration(problem).run(Sink())


def processors(work: Callable[[], Any]) -> dict[str, float]:
    """Return processor time over wall time, and over that of the thread that works.

    The latter counts where others keep the processors busy.
    """
    before, mine, clock = time.process_time(), time.thread_time(), time.perf_counter()
    work()
    wall, alone, spent = (
        time.perf_counter() - clock,
        time.thread_time() - mine,
        time.process_time() - before,
    )
    return {"processor / wall": spent / wall, "all threads / one": spent / alone}

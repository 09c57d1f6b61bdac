"""The cost of a run: an estimate, a measurement of its first slices, and a progress bar.

A problem goes in; out come steps, seconds and megabytes, for `forecast` and `sweeps.plan`.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from ..engine.observables import Observables
from ..engine.taylor import driver_of
from ..mechanics.units import SECOND
from ..problem import Problem
from ..progress import Bar
from .integration import Integration
from .reporting import Progress, RunProgress
from .sinks import Sink


# Measured: 1337 steps in the 8 s of the canonical inversion.
STEPS_PER_RADIAN = 0.9
# On two shared cores of an AMD EPYC.
MICROSECONDS_PER_STEP = {"double": 2.0, "longdouble": 35.0, "quad": 900.0}
# Steps of a slice that is timed.
STEPS = 512
# Rows of such a slice, roughly.
ROWS = 100_000
# Fewest steps of such a slice.
FEWEST = 10
# Slices from which the rest is inferred: a fixed count, so that every call finds as many steps.
SLICES = 8


def estimate(problem: Problem) -> dict[str, float]:
    """Return the order of magnitude of steps, seconds and megabytes of a run.

    Under friction with a torque there may be many more steps: a spin that it stops becomes stiff,
    which neither the start nor the first steps show. Nothing is measured: `Plan.chunk` takes the
    steps, and must be the same on every computer.
    """
    initial = problem.initial
    second = problem.unit(SECOND)
    spin = initial.get("omega3", initial.get("psi_dot", 0.0))
    # 1/second: a top without spin swings at about one radian per internal unit of time
    fastest = max(abs(float(spin)), abs(float(initial.get("phi_dot", 0.0))), 1.0 / second)
    steps = problem.until * fastest * STEPS_PER_RADIAN
    return {
        "steps": round(steps),
        "seconds": round(steps * MICROSECONDS_PER_STEP[problem.precision] * 1e-6, 4),
        "megabytes": round(len(problem.times) * 8 * 24 / 1e6, 3),  # some 24 columns of doubles
    }


def measured(problem: Problem, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Return the steps and seconds of a run in memory, from its first slices, once compiled.

    Parameters
    ----------
    problem
        The run.
    clock
        Seconds.

    Returns
    -------
    dict
        `steps` and `seconds` of the whole run.
    """
    expected = max(float(estimate(problem)["steps"]), 1.0)
    # fewer steps where rows are dense: a slice has about ROWS of them at most
    size = max(FEWEST, min(STEPS, int(ROWS * expected / max(len(problem.times), 1))))
    if problem.system.is_hybrid:  # later phases would be compiled on the way
        driver_of(problem).codes()  # the integrators of all phases
    _timed(problem, size, 1, clock)  # compiles
    seconds, progress = _timed(problem, size, SLICES, clock)
    whole = 1.0  # a run that ended within these slices
    if progress.status is None:
        whole = max(1.0, problem.until / progress.t_end)
    return {"steps": round(progress.steps * whole), "seconds": round(seconds * whole, 4)}


class _Columns(Sink):
    """A sink that converts rows to columns, as a store would, and drops them."""

    keeps_rows = True

    def __init__(self, view: Observables):
        self.view = view

    def add_rows(self, times: np.ndarray, states: np.ndarray) -> None:
        """Convert rows to columns."""
        self.view.columns(times, states)


def _timed(
    problem: Problem, size: int, slices: int, clock: Callable[[], float]
) -> tuple[float, RunProgress]:
    """Return the seconds that the first `slices` slices of `size` steps take, and the progress.

    They include the setup of the run and the conversion of its rows to columns. A run may end
    earlier; `clock` returns seconds.
    """
    began = clock()
    integration = Integration(problem)
    integration.part(
        _Columns(integration.view), size, lambda: integration.steps_made < slices * size
    )
    return clock() - began, integration.progress()


@contextmanager
def bar_of_run() -> Iterator[Progress]:
    """Provide a run's progress callback that draws a bar in a terminal."""

    with Bar("s", "t = {done:.4g} s") as bar:
        yield lambda progress: bar.update(progress.t_end, progress.problem.until)

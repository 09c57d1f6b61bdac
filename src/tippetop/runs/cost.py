"""What a run costs: an estimate, a measurement of its first slices, and a warning while it runs."""

import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from ..engine.observables import Observables
from ..engine.taylor import driver_of
from ..mechanics.units import SECOND
from ..problem import Problem
from ..progress import Bar
from .integration import Integration
from .reporting import RunProgress, report
from .sinks import Sink


# --- an estimate --------------------------------------------------------------------------------

# Measured: 1337 steps in the 8 s of the canonical inversion.
STEPS_PER_RADIAN = 0.9
# On two shared cores of an AMD EPYC.
MICROSECONDS_PER_STEP = {"double": 2.0, "longdouble": 35.0, "quad": 900.0}
# Cost of a step where friction drills: these equations are not optimised; measured: 23 to 35 us.
DEARER = 15.0


def estimate(problem: Problem) -> dict[str, float]:
    """Return the order of magnitude of steps, seconds and megabytes of a run.

    A disc that slows under friction that drills takes more steps: it becomes stiff.
    """
    initial, until = problem.initial, problem.until
    second = float(problem.scales.of(SECOND))
    spin = initial.get("omega3", initial.get("psi_dot", 0.0))
    fastest = max(abs(float(spin)), abs(float(initial.get("phi_dot", 0.0))), 1.0 / second)
    steps = until * fastest * STEPS_PER_RADIAN
    dearer = DEARER if problem.law.regions else 1.0
    return {
        "steps": round(steps),
        "seconds": round(steps * MICROSECONDS_PER_STEP[problem.precision] * dearer * 1e-6, 4),
        "megabytes": round(len(problem.times) * 8 * 24 / 1e6, 3),
    }


# --- a measurement ------------------------------------------------------------------------------

# Steps and, roughly, rows of a slice.
STEPS, ROWS, FEWEST = 512, 100_000, 10
# Computing [s] from which the rest is inferred.
WORTH = 0.2


def measured(problem: Problem, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Return the steps and seconds of a run, from its first slices, and those of compiling it.

    Parameters
    ----------
    problem
        The run.
    clock
        Seconds.

    Returns
    -------
    dict
        `steps` and `seconds` of the whole run, in memory; `compiling`, the seconds that compiling
        took now: the integrator is kept on disk.
    """
    expected = max(float(estimate(problem)["steps"]), 1.0)
    size = max(FEWEST, min(STEPS, int(ROWS * expected / max(len(problem.times), 1))))
    began = clock()
    if problem.system.is_hybrid:  # later phases would be compiled on the way
        driver_of(problem).prepare()  # type: ignore[attr-defined]
    _timed(problem, size, 0.0, clock)
    compiled = clock() - began
    seconds, progress = _timed(problem, size, WORTH, clock)
    steps, whole = progress.steps, 1.0
    if progress.status is None:
        whole = max(1.0, problem.until / progress.t_end)
    return {
        "steps": round(steps * whole),
        "seconds": round(seconds * whole, 4),
        "compiling": round(max(compiled - seconds * min(1.0, size / max(steps, 1)), 0.0), 2),
    }


class _Columns(Sink):
    """Make columns of rows, and keep none."""

    keeps_rows = True

    def __init__(self, view: Observables):
        self.view = view

    def rows(self, times: np.ndarray, states: Callable[[], np.ndarray]) -> None:
        """Take rows."""
        self.view.columns(times, states())


def _timed(
    problem: Problem, size: int, worth: float, clock: Callable[[], float]
) -> tuple[float, RunProgress]:
    """Return the time of the first slices of a run, rows as columns included, and its progress."""
    began, integration = clock(), Integration(problem)
    integration.part(
        _Columns(integration.view),
        size,
        lambda: integration.fresh or clock() - began < worth,
    )
    return clock() - began, integration.progress()


# --- a warning ----------------------------------------------------------------------------------

# Time left [s] from which a sentence reports it, and that after WAITED seconds of computing.
LONG, WAITED = 600.0, 30.0
# Computing [s] from which the rest is inferred.
AGAIN_AFTER = 3.0
# Times in a row: a compilation, or another program, may take the time of a single one.
AGREED = 3
# Step in radians of the fastest angle: shorter steps have another cause than the spin.
SHORT = 0.02
# Phases of the contact per step that make the steps short.
OFTEN = 0.2


class Patience:
    """A progress callback that reports once that the rest of a run will take long.

    Parameters
    ----------
    say
        Takes the sentence.
    clock
        Seconds.
    """

    def __init__(self, say: Callable[[str], object], clock: Callable[[], float] = time.monotonic):
        self.say, self.clock = say, clock
        self.began = clock()
        # Clock, time of the run, steps, phases of the contact.
        self.since: tuple[float, float, int, int] | None = None
        self.inferred: list[float] = []  # long rests [s] in a row

    def __call__(self, progress: RunProgress) -> None:
        """Infer the rest from the slices since the last look."""
        if len(self.inferred) == AGREED:
            return
        changes = 0 if progress.phases is None else sum(progress.phases["counts"].values())
        now = self.clock(), progress.t_end, progress.steps, changes
        if self.since is None:
            self.since, self.began = now, now[0]
        seconds, advance, steps, phases = (b - a for a, b in zip(self.since, now, strict=True))
        if seconds < AGAIN_AFTER:
            return
        self.since = now
        left = seconds * (progress.problem.until - now[1]) / max(advance, 1e-300)
        long = LONG if now[0] - self.began < WAITED else min(LONG, WAITED)
        self.inferred = [*self.inferred, left] if left > long else []
        if len(self.inferred) == AGREED:
            often = phases > OFTEN * steps
            self.say(sentence(progress.problem, min(self.inferred), advance / max(steps, 1), often))


def warn(words: str) -> None:
    """Issue a warning to callers from Python."""
    warnings.warn(words, stacklevel=2)


@contextmanager
def following(
    say: Callable[[str], object] = warn, *, bar: bool = True
) -> Iterator[Callable[[RunProgress], None]]:
    """Provide a run's progress callback: it warns of a long run, and draws a bar in a terminal."""
    patience = Patience(say)
    if not bar:
        yield patience
        return

    def note(progress: RunProgress) -> str:
        facts = report(progress)
        drift = max(facts["drift"].values(), default=0.0)
        turnings = facts["event_counts"].get("turning", 0)
        return f"theta {facts['theta_end']:.4f}, {turnings} turnings, drift {drift:.0e}"

    def follow(progress: RunProgress) -> None:
        progress_bar.update(progress.t_end, progress.problem.until, lambda: note(progress))
        patience(progress)

    with Bar("s", "t = {done:.4g} s") as progress_bar:
        yield follow


def sentence(problem: Problem, left: float, step: float, often: bool = False) -> str:
    """Return that the rest of a run takes `left` [s], in steps of `step` [s], and why."""
    rates = ("omega3", "psi_dot", "phi_dot", "theta_dot")
    fastest = max(1.0, *(abs(float(problem.initial.get(name, 0.0))) for name in rates))
    why = ""
    if often:
        why = ", because the contact changes its phase about as often (contact.e_n, stem)"
    elif step * fastest < SHORT and problem.law.regions:
        why = "friction on a disc that hardly turns is stiff (friction.patch, initial.omega3)"
        why = f", because {why}"
    elif step * fastest < SHORT:
        keys = ", ".join(f"friction.{name}" for name in problem.friction._fields)
        why = f", because friction is stiff ({keys})"
    return (
        f"the rest of this run will take about {left:.2g} s ({left / 3600:.2g} hours): its "
        f"steps are {step:.2g} s long{why}. Ctrl-C stops it; a store can be resumed."
    )

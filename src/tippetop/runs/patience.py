"""Whether a run that is under way will take long, in a sentence that says what makes its steps short."""

import time
import warnings
from collections.abc import Callable
from typing import Any

from ..problem import Problem
from .reporting import RunProgress


LONG = 600.0  # [s] that are left: from there on there is a sentence
WAITED = 30.0  # [s] of computing without a word: from there on so much that is left is long
AGAIN_AFTER = 3.0  # [s] of computing from which the rest is inferred
AGREED = 3  # so many times in a row: what one of them compiled, or another program took, is not the run's
SHORT = 0.02  # of a radian of the fastest angle: steps that spin alone does not ask for
OFTEN = 0.2  # phases of the contact a step: it is they that make the steps short


class Patience:
    """A progress callback of an integration, which says once that its rest will take long.

    Parameters
    ----------
    say
        Takes the sentence.
    clock
        Seconds.
    """

    def __init__(self, say: Callable[[str], Any], clock: Callable[[], float] = time.monotonic):
        self.say, self.clock = say, clock
        self.since: tuple[float, float, int, int] | None = None  # clock, time of the run, steps, phases of the contact
        self.began = 0.0  # clock
        self.inferred: list[float] = []  # [s], long ones in a row

    def __call__(self, progress: RunProgress) -> None:
        """Look how far the run has come."""
        changes = 0 if progress.phases is None else sum(progress.phases["counts"].values())
        now = self.clock(), progress.t_end, progress.steps, changes
        if self.since is None:
            self.since = now
            self.began = now[0]
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
            self.clock, self.since = (lambda: 0.0), (0.0, 0.0, 0, 0)  # once is enough


def warning() -> Patience:
    """A progress callback for those who call from Python: what it says is a warning."""
    return Patience(lambda words: warnings.warn(words, stacklevel=2))


def sentence(problem: Problem, left: float, step: float, often: bool = False) -> str:
    """That the rest of a run takes so many seconds, its steps being so long [s]; whether its contact changes often."""
    rates = ("omega3", "psi_dot", "phi_dot", "theta_dot")
    fastest = max(1.0, *(abs(float(problem.initial.get(name, 0.0))) for name in rates))
    why = ""
    if often:
        why = ", because the contact changes its phase about as often (contact.e_n, stem)"
    elif step * fastest < SHORT:
        keys = [f"friction.{name}" for name in problem.friction._fields]
        why = f", because friction is stiff ({', '.join(keys)})"
        if problem.law.regions:
            why = ", because friction on a disc that hardly turns is stiff (friction.patch, initial.omega3)"
    return (
        f"the rest of this run will take about {left:.2g} s ({left / 3600:.2g} hours): its steps are {step:.2g} s "
        f"long{why}. Ctrl-C stops it; a store can be resumed."
    )

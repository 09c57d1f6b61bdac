"""The drift of the invariants of runs: relative, and the worst so far."""

from typing import Any

import numpy as np

from ..engine.invariants import invariants, sizes
from ..engine.observables import values_of
from ..problem import Problems


class Drift:
    """Compare the invariants of runs with those of their start.

    Parameters
    ----------
    problems
        The runs.
    start
        Their states at the start, (variables, n), internal.
    valid
        Which runs are valid, (n,), or all.

    Attributes
    ----------
    worst
        Of each invariant, the largest relative deviation from the start, (n,); NaN where a run is
        not valid.
    """

    def __init__(self, problems: Problems, start: np.ndarray, valid: Any = True):
        self.problems = problems
        values = values_of(problems, start, np.arange(problems.n))
        self.start = invariants(problems.base, values)
        self.size = sizes(problems.base, values)
        self.worst = {name: np.where(valid, np.zeros(problems.n), np.nan) for name in self.start}

    @np.errstate(all="ignore")  # the numbers of invalid runs
    def look(self, states: np.ndarray, which: np.ndarray) -> None:
        """Take in states (variables, k), internal, of the runs `which`, (k,)."""
        problems = self.problems
        values = values_of(problems, states[: len(problems.start)], which)
        for name, value in invariants(problems.base, values).items():
            off = np.abs(value - self.start[name][which]) / self.size[name][which]
            np.maximum.at(self.worst[name], which, off.astype(float))

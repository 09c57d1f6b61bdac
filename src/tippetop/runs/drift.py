"""Measure the drift of the invariants of runs: the largest relative deviation so far.

States of runs in internal units go in, at the start and later; `Drift.worst` has the result.
"""

from typing import Any

import numpy as np

from ..engine.invariants import invariants, sizes
from ..engine.observables import values_of
from ..problem import Problems


class Drift:
    """Compare the invariants of runs with those of their start.

    `Integration` makes one for its run, `ensembles.outcomes` one for all tops.

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
    start, size
        Of each invariant, its value at the start and the size that deviations are relative to
        (`engine.invariants.sizes`), (n,) each, internal.
    worst
        Of each invariant, the largest relative deviation from the start, (n,); NaN where a run is
        not valid.
    """

    def __init__(self, problems: Problems, start: np.ndarray, valid: Any = True):
        self.problems = problems
        self.start: dict[str, np.ndarray] = {}
        self.size: dict[str, np.ndarray] = {}
        self.begin(start, np.arange(problems.n))
        self.worst = {name: np.where(valid, np.zeros(problems.n), np.nan) for name in self.start}

    def begin(self, start: np.ndarray, which: np.ndarray) -> None:
        """Compare the runs `which`, (k,), with these starts (variables, k), internal, from now on.

        Tops in lanes, whose starts are known later than the ensemble, begin by it too.
        """
        problems = self.problems
        values = values_of(problems, start, which)
        for kept, of in (self.start, invariants), (self.size, sizes):
            for name, value in of(problems.base, values).items():
                kept.setdefault(name, np.empty(problems.n))[which] = value

    @np.errstate(all="ignore")  # the numbers of invalid runs
    def look(self, states: np.ndarray, which: np.ndarray) -> None:
        """Update the worst drift by states (variables, k), internal, of the runs `which`, (k,)."""
        problems = self.problems
        values = values_of(problems, states[: len(problems.start)], which)
        for name, value in invariants(problems.base, values).items():
            off = np.abs(value - self.start[name][which]) / self.size[name][which]
            # `which` may contain a run several times, with one of its states each
            np.maximum.at(self.worst[name], which, off.astype(float))

"""The drift of the invariants of a run, and the range of its normal force."""

from typing import Any

import numpy as np

from ..engine.driver import Extremes
from ..engine.invariants import invariants, sizes
from ..engine.observables import Observables
from ..problem import Problem


class Monitor:
    """Follow a run slice by slice. Drifts are relative, and the worst of the run.

    Parameters
    ----------
    problem, view
        The run and its observables.
    row
        The start, (1, variables), with which the invariants are compared.
    """

    def __init__(self, problem: Problem, view: Observables, row: np.ndarray):
        self.problem = problem
        self.view = view
        values = view.evaluate(row)
        self.start, self.size = (
            {name: float(value[0]) for name, value in of(problem, values).items()}
            for of in (invariants, sizes)
        )
        self.drift = dict.fromkeys(self.start, 0.0)
        self.force = Extremes()
        self.steps = 0

    def follow(self, rows: np.ndarray, force: Extremes, steps: int) -> None:
        """Take in samples (n, variables) of a slice of `steps` steps, and the force so far."""
        values = invariants(self.problem, self.view.evaluate(rows)) if len(rows) else {}
        for name, each in values.items():
            worst = float(np.max(np.abs(each - self.start[name]) / self.size[name]))
            self.drift[name] = max(self.drift[name], worst)
        self.force = force
        self.steps += steps

    def snapshot(self) -> dict[str, Any]:
        """Return the data of a checkpoint."""
        return {"drift": dict(self.drift), "force": list(self.force), "steps": self.steps}

    def restore(self, kept: dict[str, Any]) -> None:
        """Continue from a checkpoint; the start is that of the problem."""
        self.drift = kept["drift"]
        self.force = Extremes(*kept["force"])
        self.steps = kept["steps"]

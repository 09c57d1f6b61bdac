"""The drift of the invariants of a run, and the range of its normal force."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..engine.driver import Extremes
from ..engine.invariants import invariants, sizes
from ..engine.observables import Observables
from ..problem import Problem


@dataclass
class Monitor:
    """Follows a run slice by slice. Drifts are relative, and the worst of the run."""

    problem: Problem
    view: Observables
    drift: dict[str, float] = field(default_factory=dict)
    force: Extremes = field(default_factory=Extremes)
    steps: int = 0
    _start: dict[str, float] = field(default_factory=dict)
    _size: dict[str, float] = field(default_factory=dict)

    def begin(self, row: np.ndarray) -> None:
        """Takes the start, (1, variables), as what the invariants are compared with."""
        values = self.view.evaluate(row)
        self._start = {
            name: float(value[0]) for name, value in invariants(self.problem, values).items()
        }
        self._size = {name: float(value[0]) for name, value in sizes(self.problem, values).items()}
        self.drift = dict.fromkeys(self._start, 0.0)

    def follow(self, rows: np.ndarray, force: Extremes, steps: int) -> None:
        """Takes in step ends (n, variables) of a slice of so many steps, and the extremes of the
        force so far.
        """
        for name, values in (
            invariants(self.problem, self.view.evaluate(rows)).items() if len(rows) else ()
        ):
            worst = float(np.max(np.abs(values - self._start[name]) / self._size[name]))
            self.drift[name] = max(self.drift[name], worst)
        self.force = force
        self.steps += steps

    def snapshot(self) -> dict[str, Any]:
        """What a checkpoint keeps."""
        return {"drift": dict(self.drift), "force": list(self.force), "steps": self.steps}

    def restore(self, kept: dict[str, Any]) -> None:
        """Continues from a checkpoint; the start is that of the problem."""
        self.drift, self.force, self.steps = kept["drift"], Extremes(*kept["force"]), kept["steps"]

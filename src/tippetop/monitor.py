"""What a run says of itself: drift of the invariants, range of the normal force, inversion, band."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .events import EventTable
from .problem import Problem
from .system import NEWTON, SECOND
from .trajectory import View
from .watch import Extremes


SAMPLES_PER_SLICE = 256  # step ends at which the invariants are compared: 1 % of the cost of a slice of 4096 steps


@dataclass
class Monitor:
    """Follows a run slice by slice. Drifts are relative, and the worst of the run."""

    problem: Problem
    view: View = field(init=False)
    drift: dict[str, float] = field(default_factory=dict)
    force: Extremes = field(default_factory=Extremes)
    steps: int = 0
    _start: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.view = View(self.problem)

    def begin(self, row: np.ndarray) -> None:
        """Takes the start, (1, variables), as what the invariants are compared with."""
        self._start = {name: float(values[0]) for name, values in self._invariants(row).items()}
        self.drift = dict.fromkeys(self._start, 0.0)

    def follow(self, rows: np.ndarray, force: Extremes, steps: int) -> None:
        """Takes in the step ends (n, variables) of a slice."""
        every = max(1, len(rows) // SAMPLES_PER_SLICE)
        for name, values in self._invariants(np.concatenate([rows[::every], rows[-1:]])).items():
            start = self._start[name]
            size = abs(start) if abs(start) > 1e-6 else 1.0  # an invariant that is zero: in internal units
            self.drift[name] = max(self.drift[name], float(np.max(np.abs(values - start))) / size)
        self.force = self.force.joined(force)
        self.steps += steps

    def _invariants(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        record, scalars = self.view.record(rows), self.view.scalars(rows)
        found = {name: self.view.internal(name, scalars) for name in self.problem.system.integrals}
        work = getattr(record, "work", 0.0)
        found["energy_balance"] = self.view.internal("energy", scalars) + work
        if hasattr(record, "ux"):
            found["axis_norm"] = np.sqrt(scalars.s2 + scalars.z**2)
        return found

    def report(self, events: EventTable, t_end: float, theta_end: float) -> dict[str, Any]:
        """The measured part of `info --json`."""
        report: dict[str, Any] = {
            "t_end": t_end,
            "steps": self.steps,
            "event_counts": event_counts(events),
            "inversion": inversion(events),
            "nutational_band": band(events),
            "theta_end": theta_end,
            "drift": self.drift,
        }
        if math.isfinite(self.force.least):
            newton = float(self.problem.scales.of(NEWTON))
            second = float(self.problem.scales.of(SECOND))
            report["normal_force"] = {
                "min": self.force.least * newton,
                "max": self.force.most * newton,
                "t_min": self.force.t_least * second,
                "t_max": self.force.t_most * second,
                "weight": self.problem.parameters["m"] * self.problem.parameters["g"],
            }
        return report


def event_counts(events: EventTable) -> dict[str, int]:
    """How many events of each kind were logged, and how many turnings are more than rounding."""
    from .events import KINDS

    counts = {kind: int(np.sum(events.kind == i)) for i, kind in enumerate(KINDS)}
    counts["turning_significant"] = len(events.of("turning", significant=True).time)
    return {name: n for name, n in counts.items() if n}


def inversion(events: EventTable) -> dict[str, float | None]:
    """First and last passage of theta = pi/2 and first of pi - 0.1 [s]; None if there was none."""
    equator, inverted = events.of("equator").time, events.of("inverted").time
    return {
        "first_equator": float(equator[0]) if len(equator) else None,
        "last_equator": float(equator[-1]) if len(equator) else None,
        "inverted_at": float(inverted[0]) if len(inverted) else None,
    }


def band(events: EventTable) -> dict[str, float | None]:
    """Smallest and largest turning angle of the run [rad]; None if theta' had no zero above rounding."""
    theta = events.of("turning", significant=True).theta
    return {
        "theta_min": float(theta.min()) if len(theta) else None,
        "theta_max": float(theta.max()) if len(theta) else None,
    }

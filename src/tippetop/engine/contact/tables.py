"""The phases and the impacts of a run, as tables that grow: what the store's groups `phases` and `impacts` hold."""

from typing import Any

import numpy as np

from ...mechanics.contact.phases.row import BALLS, PHASES
from ...mechanics.units import JOULE, METRE_PER_SECOND, NEWTON_SECOND, SECOND
from ...problem import Problem


MODES = ("slip", "stick", "reverse")
REASONS = ("start", "stick", "slip", "liftoff", "landing", "other-ball", "opens-at-once", "other-leaves")
"""Why a phase began; the place of a word is its number in a store."""
PHASE_COLUMNS = ("start", "end", "phase", "ball", "reason")
IMPACT_COLUMNS = (
    "time", "ball", "v_n_before", "v_n_after", "speed_before", "speed_after", "impulse", "friction_impulse", "work",
    "mode",
)  # fmt: skip

FLAGS = {"phase": PHASES, "ball": BALLS, "mode": MODES, "reason": REASONS}
Table = dict[str, np.ndarray]


class Tables:
    """Rows that nobody has taken yet, in SI units; and the phase that is under way.

    Parameters
    ----------
    problem
        The run.
    """

    def __init__(self, problem: Problem):
        def si(unit: Any) -> float:
            return float(problem.scales.of(unit))

        self.second, self.speed = si(SECOND), si(METRE_PER_SECOND)
        self.impulse, self.energy = si(NEWTON_SECOND), si(JOULE)
        self.under_way: list[Any] | None = None
        self.phases: list[list[Any]] = []
        self.impacts: list[list[Any]] = []

    def begin(self, phase: int, ball: int, time: float, change: Any) -> None:
        """A phase begins at an internal time, with what struck the plane then."""
        if self.under_way is not None:
            self.end(time, "")
        self.struck(time, change)
        self.under_way = [time * self.second, phase, ball, REASONS.index(change.reason)]

    def struck(self, time: float, change: Any) -> None:
        """What struck the plane at an internal time."""
        for strike in change.strikes:
            numbers = (*strike.v_n, *strike.slide)
            self.impacts.append(
                [time * self.second, strike.ball, *(v * self.speed for v in numbers), strike.impulse * self.impulse,
                 strike.friction_impulse * self.impulse, strike.work * self.energy, MODES.index(strike.mode)]
            )  # fmt: skip

    def end(self, time: float, word: str) -> None:
        """The phase under way ends."""
        if self.under_way is not None:
            start, phase, ball, reason = self.under_way
            self.phases.append([start, time * self.second, phase, ball, reason])
            self.under_way = None

    def take(self) -> dict[str, Table]:
        """The rows that came since the last time."""
        phases, impacts = self.phases, self.impacts
        self.phases, self.impacts = [], []
        return {"phases": as_table(PHASE_COLUMNS, phases), "impacts": as_table(IMPACT_COLUMNS, impacts)}


def as_table(names: tuple[str, ...], rows: list[list[Any]]) -> Table:
    """Columns of rows."""
    columns: Table = {}
    for k, name in enumerate(names):
        values = [row[k] for row in rows]
        columns[name] = np.array(values, dtype=np.int8 if name in FLAGS else float)
    return columns


__all__ = ["FLAGS", "IMPACT_COLUMNS", "PHASE_COLUMNS", "Table", "Tables", "as_table"]

"""The event log as a table: one row per event, and which turnings are more than rounding."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ..columns import Column, column
from ..mechanics.events import NOISE_FLOOR, NUMBERED, hysteresis
from ..mechanics.units import RADIAN, SECOND


@dataclass(frozen=True)
class EventTable:
    """Columns of the log, (events,) each, ascending in time."""

    kinds: tuple[str, ...]  # names of the kinds by number
    time: np.ndarray  # [s]
    kind: np.ndarray  # index into `kinds`, int8
    theta: np.ndarray  # [rad]
    theta_dot_sign: np.ndarray  # of theta' just after the event: +1 at a minimum of theta, -1 at a maximum; int8
    amplitude: np.ndarray  # swing |theta - theta of the turning before| [rad]; NaN for other kinds
    significant: np.ndarray  # False where rounding could have made the event, or it did not last; bool
    state: dict[str, Column] = field(default_factory=dict, kw_only=True)  # of runs with user-defined events

    @classmethod
    def empty(cls, kinds: tuple[str, ...] = NUMBERED) -> "EventTable":
        """A log without rows."""
        return cls(kinds, *(np.zeros(0, dtype) for dtype in (float, np.int8, float, np.int8, float, bool)))

    @classmethod
    def joined(cls, tables: list["EventTable"]) -> "EventTable":
        """One log of several of the same kinds, in order."""
        if not tables:
            return cls.empty()
        columns = zip(*(table.columns().values() for table in tables), strict=True)
        state = {
            name: column._replace(values=np.concatenate([table.state[name].values for table in tables]))
            for name, column in tables[0].state.items()
        }
        return cls(tables[0].kinds, *map(np.concatenate, columns), state=state)

    def columns(self) -> dict[str, np.ndarray]:
        """The columns by name."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("kinds", "state")}

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """The rows of one kind; only the significant ones, if asked."""
        keep = self.kind == self.kinds.index(kind)
        if significant:
            keep &= self.significant
        return EventTable(self.kinds, *(values[keep] for values in self.columns().values()))


class Confirmation:
    """Tells which turnings of theta are more than rounding, as they come, by the rule `hysteresis`.

    A turning waits, by its row in the log, until a later one confirms it.
    """

    def __init__(self) -> None:
        self.row, self.theta, self.sign = -1, 0.0, 0  # the turning that waits; sign 0: none

    def take(self, rows: np.ndarray, theta: np.ndarray, sign: np.ndarray) -> list[tuple[int, float]]:
        """Takes turnings in order (sign +1 minima, -1 maxima); gives (row, theta) of those that are now confirmed.

        A sign of 0 is a passage through a pole: it ends a swing, and is no turning itself.
        """
        if self._all_count(theta, sign):  # nearly always; one by one takes 0.5 us a turning
            waiting = [(self.row, self.theta)] if self.sign else []
            confirmed = waiting + list(zip(rows[:-1].tolist(), theta[:-1].tolist(), strict=True))
            self.row, self.theta, self.sign = int(rows[-1]), float(theta[-1]), int(sign[-1])
            return confirmed
        marks = []
        for row, angle, way in zip(rows.tolist(), theta.tolist(), sign.tolist(), strict=True):
            marks += self._next(row, angle, way)
        return marks

    def reached(self, theta: float) -> list[tuple[int, float]]:
        """(row, theta) of the waiting turning if the end of the run, at theta, confirms it; then none waits."""
        return self._next(-1, theta, 0)

    def _all_count(self, theta: np.ndarray, sign: np.ndarray) -> bool:
        """Whether each turning confirms the one before: minima and maxima in turn, all swings above the floor."""
        if not len(theta) or not sign.all():
            return False
        every, ways = (np.append(self.theta, theta), np.append(self.sign, sign)) if self.sign else (theta, sign)
        return bool((ways[1:] == -ways[:-1]).all() and (ways[1:] * (every[1:] - every[:-1]) <= -NOISE_FLOOR).all())

    def _next(self, row: int, theta: float, sign: int) -> list[tuple[int, float]]:
        before = (self.row, self.theta)
        confirmed, waits = hysteresis(self.sign, self.theta, sign, theta)
        if waits:
            self.row, self.theta, self.sign = row, theta, sign
        elif confirmed:
            self.row, self.sign = -1, 0
        return [before] if confirmed else []


def event_columns(table: EventTable) -> dict[str, Column]:
    """The event log as columns of the store's group `events`."""
    flags = {"flag_values": list(range(len(table.kinds))), "flag_meanings": " ".join(table.kinds)}
    about: dict[str, dict[str, Any]] = {
        "kind": {"long_name": "kind of event", **flags},
        "theta_dot_sign": {"long_name": "sign of theta' just after: +1 at a minimum of theta, -1 at a maximum"},
        "significant": {"long_name": "false where rounding could have made the event"},
    }
    measured = {
        "time": (SECOND, "time of the event"),
        "theta": (RADIAN, "theta at the event"),
        "amplitude": (RADIAN, "swing of theta since the turning before (or the start); NaN unless a turning"),
    }
    columns = {
        name: column(values, *measured[name], ("event",))
        if name in measured
        else Column(("event",), values, {"units": "1", **about[name]})
        for name, values in table.columns().items()
    }
    return {**table.state, **columns}

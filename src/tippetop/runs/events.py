"""The event log as a table: one row per event, and which turnings are more than rounding."""

from typing import Any, NamedTuple

import numpy as np

from ..columns import Column, column
from ..mechanics.system import KINDS, NOISE_FLOOR
from ..mechanics.units import RADIAN, SECOND


class EventTable(NamedTuple):
    """Columns of the log, one row per event, ascending in time."""

    time: np.ndarray  # [s]
    kind: np.ndarray  # index into KINDS, int8
    theta: np.ndarray  # [rad]
    theta_dot_sign: np.ndarray  # of theta' just after the event: +1 at a minimum of theta, -1 at a maximum; int8
    amplitude: np.ndarray  # swing |theta - theta of the turning before| [rad]; NaN for other kinds
    significant: np.ndarray  # False where rounding could have made the event, or it did not last; bool

    @classmethod
    def empty(cls) -> "EventTable":
        """A log without rows."""
        return cls(*(np.zeros(0, dtype) for dtype in (float, np.int8, float, np.int8, float, bool)))

    @classmethod
    def joined(cls, tables: list["EventTable"]) -> "EventTable":
        """One log of several, in order."""
        return cls(*map(np.concatenate, zip(*tables, strict=True))) if tables else cls.empty()

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """The rows of one kind; only the significant ones, if asked."""
        keep = self.kind == KINDS.index(kind)
        return EventTable(*(column[keep & self.significant] if significant else column[keep] for column in self))


class Confirmation:
    """Tells which turnings of theta are more than rounding, as they come.

    Hysteresis: the extreme of a stretch counts once theta has come back from it by the floor, whatever small wiggles
    lie between. So a true turning that rounding splits into three counts once, and a decay that ends in noise not
    at all. A turning waits, by its row in the log, until a later one confirms it.
    """

    def __init__(self, floor: float = NOISE_FLOOR):
        self.floor = floor
        self.row, self.theta, self.sign = -1, 0.0, 0  # the turning that waits; row -1: none

    def take(self, rows: np.ndarray, theta: np.ndarray, sign: np.ndarray) -> list[tuple[int, float]]:
        """Takes turnings in order (sign +1 minima, -1 maxima); gives (row, theta) of those that are now confirmed."""
        if not len(rows):
            return []
        every = np.append(self.theta, theta) if self.row >= 0 else theta
        if np.all(np.abs(np.diff(every)) >= self.floor) and (self.row < 0 or sign[0] != self.sign):
            waiting = [(self.row, self.theta)] if self.row >= 0 else []
            confirmed = waiting + list(zip(rows[:-1].tolist(), theta[:-1].tolist(), strict=True))
            self.row, self.theta, self.sign = int(rows[-1]), float(theta[-1]), int(sign[-1])
            return confirmed
        found = []
        for row, angle, way in zip(rows.tolist(), theta.tolist(), sign.tolist(), strict=True):
            found += self.reached(angle)
            if self.row < 0 or (way == self.sign and way * (angle - self.theta) < 0):
                self.row, self.theta, self.sign = row, angle, way
        return found

    def reached(self, theta: float) -> list[tuple[int, float]]:
        """(row, theta) of the waiting turning if theta has come back from it by the floor; then none waits."""
        if self.row < 0 or self.sign * (theta - self.theta) < self.floor:
            return []
        confirmed = [(self.row, self.theta)]
        self.row = -1
        return confirmed


def event_columns(table: EventTable) -> dict[str, Column]:
    """The event log as columns of the store's group `events`."""
    flags = {"flag_values": list(range(len(KINDS))), "flag_meanings": " ".join(KINDS)}
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
    return {
        name: column(values, *measured[name], ("event",))
        if name in measured
        else Column(("event",), values, {"units": "1", **about[name]})
        for name, values in table._asdict().items()
    }

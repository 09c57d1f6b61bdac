"""The event log as a table: one row per event."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ..columns import Column, column
from ..mechanics.event import NUMBERED
from ..mechanics.units import RADIAN, SECOND


@dataclass(frozen=True)
class EventTable:
    """Columns of the log, (events,) each, ascending in time."""

    kinds: tuple[str, ...]  # names of the kinds by number
    time: np.ndarray  # [s]
    kind: np.ndarray  # index into `kinds`, int8
    theta: np.ndarray  # [rad]
    theta_dot_sign: (
        np.ndarray
    )  # of theta' just after the event: +1 at a minimum of theta, -1 at a maximum; int8
    amplitude: np.ndarray  # swing |theta - theta of the turning before| [rad]; NaN for other kinds
    significant: (
        np.ndarray
    )  # False where rounding could have made the event, or it did not last; bool
    state: dict[str, Column] = field(
        default_factory=dict, kw_only=True
    )  # of runs with user-defined events

    @classmethod
    def empty(cls, kinds: tuple[str, ...] = NUMBERED) -> "EventTable":
        """A log without rows."""
        return cls(
            kinds, *(np.zeros(0, dtype) for dtype in (float, np.int8, float, np.int8, float, bool))
        )

    @classmethod
    def joined(cls, tables: list["EventTable"]) -> "EventTable":
        """One log of several of the same kinds, in order."""
        if not tables:
            return cls.empty()
        columns = zip(*(table.columns().values() for table in tables), strict=True)
        state = {
            name: column._replace(
                values=np.concatenate([table.state[name].values for table in tables])
            )
            for name, column in tables[0].state.items()
        }
        return cls(tables[0].kinds, *map(np.concatenate, columns), state=state)

    def columns(self) -> dict[str, np.ndarray]:
        """The columns by name."""
        return {
            f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("kinds", "state")
        }

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """The rows of one kind; only the significant ones, if asked."""
        keep = self.kind == self.kinds.index(kind)
        if significant:
            keep &= self.significant
        return EventTable(self.kinds, *(values[keep] for values in self.columns().values()))


def event_columns(table: EventTable) -> dict[str, Column]:
    """The event log as columns of the store's group `events`."""
    flags = {"flag_values": list(range(len(table.kinds))), "flag_meanings": " ".join(table.kinds)}
    about: dict[str, dict[str, Any]] = {
        "kind": {"long_name": "kind of event", **flags},
        "theta_dot_sign": {
            "long_name": "sign of theta' just after: +1 at a minimum of theta, -1 at a maximum"
        },
        "significant": {"long_name": "false where rounding could have made the event"},
    }
    measured = {
        "time": (SECOND, "time of the event"),
        "theta": (RADIAN, "theta at the event"),
        "amplitude": (
            RADIAN,
            "swing of theta since the turning before (or the start); NaN unless a turning",
        ),
    }
    columns = {
        name: column(values, *measured[name], ("event",))
        if name in measured
        else Column(("event",), values, {"units": "1", **about[name]})
        for name, values in table.columns().items()
    }
    return {**table.state, **columns}

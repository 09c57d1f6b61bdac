"""The event log as a table: one row per event.

`event_log` makes an `EventTable`; `event_columns` converts it to columns of a store.
"""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ..columns import Column, column, flag_attributes
from ..mechanics.event import NUMBERED
from ..mechanics.units import RADIAN, SECOND


@dataclass(frozen=True)
class EventTable:
    """Columns of the log, (events,) each, ascending in time.

    Attributes
    ----------
    kinds
        Names of the kinds by number.
    time
        Times [s].
    kind
        Indices into `kinds`, int8.
    theta
        Angles [rad].
    theta_dot_sign
        Signs of theta' just after the events: +1 at a minimum of theta, -1 at a maximum; int8.
    amplitude
        Swings |theta - theta of the turning before| [rad]; NaN for other kinds.
    significant
        False where rounding could have made the event, or it did not last.
    state
        Columns of the trajectory at the events, in runs with user-defined events.
    """

    kinds: tuple[str, ...]
    time: np.ndarray
    kind: np.ndarray
    theta: np.ndarray
    theta_dot_sign: np.ndarray
    amplitude: np.ndarray
    significant: np.ndarray
    state: dict[str, Column] = field(default_factory=dict, kw_only=True)

    @classmethod
    def empty(cls, kinds: tuple[str, ...] = NUMBERED) -> "EventTable":
        """Return a table without rows."""
        return cls(
            kinds, *(np.zeros(0, dtype) for dtype in (float, np.int8, float, np.int8, float, bool))
        )

    @classmethod
    def joined(cls, tables: list["EventTable"]) -> "EventTable":
        """Return several tables of the same kinds as one, in order."""
        if not tables:
            return cls.empty()
        columns = zip(*(table.columns().values() for table in tables), strict=True)
        state = {
            name: column._replace(values=np.concatenate([t.state[name].values for t in tables]))
            for name, column in tables[0].state.items()
        }
        return cls(tables[0].kinds, *map(np.concatenate, columns), state=state)

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)[1:-1]}

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """Return the rows of one kind, or only the significant ones."""
        keep = self.kind == self.kinds.index(kind)
        if significant:
            keep &= self.significant
        return EventTable(self.kinds, *(values[keep] for values in self.columns().values()))


def event_columns(table: EventTable) -> dict[str, Column]:
    """Return the event log as columns of the store's group `events`."""
    measured = {
        "time": (SECOND, "time of the event"),
        "theta": (RADIAN, "theta at the event"),
        "amplitude": (
            RADIAN,
            "swing of theta since the turning before (or the start); NaN unless a turning",
        ),
    }
    sign = "sign of theta' just after: +1 at a minimum of theta, -1 at a maximum"
    about: dict[str, dict[str, Any]] = {
        "kind": flag_attributes(table.kinds, "kind of event"),
        "theta_dot_sign": {"long_name": sign, "units": "1"},
        "significant": {
            "long_name": "false where rounding could have made the event",
            "units": "1",
        },
    }
    columns = {
        name: column(values, *measured[name], ("event",))
        if name in measured
        else Column(("event",), values, about[name])
        for name, values in table.columns().items()
    }
    return {**table.state, **columns}

"""The event log as a table: one row per event.

`event_log` makes an `EventTable` by `event_table`; its columns are those of a store.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..columns import Column, flag_attributes, flagged


class EventTable(dict[str, Column]):
    """Columns of the log by name, (events,) each, ascending in time; attributes are their values.

    Attributes
    ----------
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
    """

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return self[name].values
        except KeyError:
            raise AttributeError(name) from None

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the kinds by number."""
        return tuple(self["kind"].attrs["flag_meanings"].split())

    @classmethod
    def joined(cls, tables: Sequence["EventTable"]) -> "EventTable":
        """Return several tables of the same kinds as one, in order; of none one without columns."""
        first = tables[0] if tables else {}
        return cls(
            (name, each._replace(values=np.concatenate([t[name].values for t in tables])))
            for name, each in first.items()
        )

    def of(self, kind: str, *, significant: bool = False) -> "EventTable":
        """Return the rows of one kind, or only the significant ones."""
        keep = flagged(self["kind"], kind) & (self.significant | (not significant))
        return EventTable((n, c._replace(values=c.values[keep])) for n, c in self.items())


def event_table(
    kinds: Sequence[str], state: Mapping[str, Column], rows: Sequence[Any] = ((),) * 6
) -> EventTable:
    """Return the columns of the store's group `events`.

    Parameters
    ----------
    kinds
        Names of the kinds by number.
    state
        Columns of the trajectory at the events, in runs with user-defined events.
    rows
        Values of the six other columns, in the order of `about` below; by default empty ones.
        `EventLog.add_zeros` passes them in this order: a change of one is a change of both.
    """
    swing = "swing of theta since the turning before (or the start); NaN unless a turning"
    sign = "sign of theta' just after: +1 at a minimum of theta, -1 at a maximum"
    noise = "false where rounding could have made the event"
    about = {
        "time": (float, {"units": "s", "long_name": "time of the event"}),
        "kind": (np.int8, flag_attributes(tuple(kinds), "kind of event")),
        "theta": (float, {"units": "rad", "long_name": "theta at the event"}),
        "theta_dot_sign": (np.int8, {"long_name": sign, "units": "1"}),
        "amplitude": (float, {"units": "rad", "long_name": swing}),
        "significant": (bool, {"long_name": noise, "units": "1"}),
    }
    columns = {
        name: Column(("event",), np.asarray(values, dtype), attrs)
        for (name, (dtype, attrs)), values in zip(about.items(), rows, strict=True)
    }
    return EventTable({**state, **columns})

"""The phases of a run's contact and its impacts, as tables of its store."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..columns import Column, column
from ..engine.phase_tables import as_table
from ..mechanics.system import System
from ..mechanics.units import JOULE, METRE_PER_SECOND, NEWTON_SECOND, SECOND


PER_CHUNK = 4096  # rows
DIMENSIONS = {"phases": "interval", "impacts": "impact"}
MEASURED: dict[str, Any] = {
    "start": (SECOND, "when the phase began"),
    "end": (SECOND, "when it ended"),
    "time": (SECOND, "time of the impact"),
    "v_n_before": (METRE_PER_SECOND, "vertical velocity of the contact point before"),
    "v_n_after": (METRE_PER_SECOND, "vertical velocity of the contact point after"),
    "speed_before": (METRE_PER_SECOND, "sliding speed before"),
    "speed_after": (METRE_PER_SECOND, "sliding speed after"),
    "impulse": (NEWTON_SECOND, "normal impulse"),
    "friction_impulse": (NEWTON_SECOND, "size of the horizontal impulse"),
    "work": (JOULE, "energy that the body gained, negative where it lost"),
}
NAMED = {
    "phase": "phase of the contact",
    "ball": "what touches the plane, or did last",
    "reason": "why the phase began",
    "mode": "how friction ended within the impact",
}


FIRST = 6  # phases that a report names
NAMES = tuple(DIMENSIONS)
"""The tables of a run whose contact may change its phase."""


def tables_of(attributes: dict[str, Any]) -> tuple[str, ...]:
    """Return the names of the tables of a run with these root attributes."""
    return (
        NAMES
        if "contact" in attributes
        else NAMES[:1]
        if "contact_phases" in attributes["report"]
        else ()
    )


@dataclass
class Story:
    """What a report says of the phases of a contact: how many there were of each, the first ones
    and the last.
    """

    words: dict[str, Any]  # those of the table of phases, by column
    counts: dict[str, int] = field(default_factory=dict)
    impacts: int = 0
    first: list[dict[str, Any]] = field(default_factory=list)
    last: dict[str, Any] | None = None

    def follow(self, new: dict[str, dict[str, np.ndarray]]) -> None:
        """Takes rows of the tables."""
        if not new:
            return
        self.impacts += len(new["impacts"]["time"]) if "impacts" in new else 0
        table = new["phases"]
        numbers = np.bincount(table["phase"], minlength=len(self.words["phase"]))
        for name, count in zip(self.words["phase"], numbers.tolist(), strict=True):
            if count:
                self.counts[name] = self.counts.get(name, 0) + count
        for k in range(len(table["phase"])):
            if len(self.first) == FIRST and k < len(table["phase"]) - 1:
                continue
            self.last = {
                key: self.words[key][values[k]] if key in self.words else float(values[k])
                for key, values in table.items()
            }
            if len(self.first) < FIRST:
                self.first.append(self.last)

    def rows(self) -> dict[str, int]:
        """How many rows the tables have, by name."""
        rows = {"phases": sum(self.counts.values()), "impacts": self.impacts}
        return rows if "ball" in self.words else {"phases": rows["phases"]}

    def report(self) -> dict[str, Any]:
        """The part of a run's report."""
        return {
            "counts": dict(self.counts),
            "impacts": self.impacts,
            "first": list(self.first),
            "last": self.last,
        }

    def snapshot(self) -> dict[str, Any]:
        """Plain data, of which `Story(words, **data)` makes it again."""
        return {name: value for name, value in asdict(self).items() if name != "words"}


def columns(system: System, name: str, table: dict[str, np.ndarray]) -> dict[str, Column]:
    """Rows of a table as columns of the store's group of this name."""
    dims = (DIMENSIONS[name],)
    result = {}
    for key, values in table.items():
        if key in MEASURED:
            unit, text = MEASURED[key]
            result[key] = column(values, unit, text, dims)
            continue
        words = system.tables[name][key]
        flags = {"flag_values": list(range(len(words))), "flag_meanings": " ".join(words)}
        result[key] = Column(dims, values, {"units": "1", "long_name": NAMED[key], **flags})
    return result


def empty(system: System) -> dict[str, dict[str, Column]]:
    """The tables without rows, by name."""
    return {
        name: columns(system, name, as_table(name, kinds, []))
        for name, kinds in system.tables.items()
    }


def joined(
    system: System, parts: dict[str, list[dict[str, np.ndarray]]]
) -> dict[str, dict[str, Column]]:
    """Tables whose rows came in parts."""
    whole = empty(system)
    for name, tables in parts.items():
        whole[name] = columns(
            system, name, {key: np.concatenate([t[key] for t in tables]) for key in tables[0]}
        )
    return whole

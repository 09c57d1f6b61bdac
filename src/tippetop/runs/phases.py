"""The phases of a run's contact and its impacts, as tables of its store.

Rows of the tables of a driver go in, as columns in SI; out come columns with labels for the store,
and counts for the report.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arguments import PlainData
from ..columns import Column, column, counted, flag_attributes
from ..engine.phase_tables import as_table
from ..mechanics.system import System
from ..mechanics.units import SECOND


Rows = dict[str, np.ndarray]
"""Rows of a table, by column."""

# Rows per chunk.
PER_CHUNK = 4096
DIMENSIONS = {"phases": "interval", "impacts": "impact"}
"""The tables of a run whose contact may change its phase, and their dimensions."""
WORDS = {
    "start": "when the phase began",
    "end": "when it ended",
    "time": "time of the impact",
    "v_n_before": "vertical velocity of the contact point before",
    "v_n_after": "vertical velocity of the contact point after",
    "speed_before": "sliding speed before",
    "speed_after": "sliding speed after",
    "impulse": "normal impulse",
    "friction_impulse": "size of the horizontal impulse",
    "work": "energy that the body gained, negative where it lost",
    "phase": "phase of the contact",
    "ball": "what touches the plane, or did last",
    "reason": "why the phase began",
    "mode": "how friction ended within the impact",
}
"""Meanings of the columns."""
# Number of first phases that a report lists.
FIRST = 6


def tables_of(attributes: PlainData) -> tuple[str, ...]:
    """Return the names of the further tables of a run with these root attributes.

    They are groups of its store, not tables of its scenario as in `build.tables_of`.
    """
    if "contact" in attributes:
        return tuple(DIMENSIONS)
    return ("phases",) if "contact_phases" in attributes["report"] else ()


@dataclass
class PhaseHistory:
    """Count the phases and impacts of a run for its report, and keep the first and last phases.

    `Integration` makes it.
    """

    words: dict[str, Any]  # those of the table of phases, by column
    counts: dict[str, int] = field(default_factory=dict)  # of phases, by their names
    impacts: int = 0  # their number
    first: list[PlainData] = field(default_factory=list)  # FIRST at most, as `last`
    last: PlainData | None = None  # numbers in SI and words, by column of the table of phases

    def add(self, new: dict[str, Rows]) -> None:
        """Count new rows, by table and column; in the order of time, as the last phase is kept."""
        if not new:
            return
        self.impacts += len(new["impacts"]["time"]) if "impacts" in new else 0
        table = new["phases"]
        count = len(table["phase"])
        for name, n in counted(table["phase"], self.words["phase"]).items():
            self.counts[name] = self.counts.get(name, 0) + n
        # the rows that still fit into `first`, and the last one
        for k in sorted({*range(min(count, FIRST - len(self.first))), *range(count)[-1:]}):
            self.last = {
                key: self.words[key][values[k]] if key in self.words else float(values[k])
                for key, values in table.items()
            }
            if len(self.first) < FIRST:
                self.first.append(self.last)

    def rows(self) -> dict[str, int]:
        """Return the number of rows of each table; only contacts that open record impacts."""
        phases = {"phases": sum(self.counts.values())}
        return phases | ({"impacts": self.impacts} if "ball" in self.words else {})

    def report(self) -> PlainData:
        """Return plain data for the report of the run and for `PhaseHistory(words, **data)`.

        So its keys are the names of the fields; reports and snapshots in stores contain them.
        """
        return {
            "counts": dict(self.counts),
            "impacts": self.impacts,
            "first": list(self.first),
            "last": self.last,
        }


def columns(system: System, name: str, table: Rows) -> dict[str, Column]:
    """Return rows, by column in SI, as labelled columns of the store's group `name`."""
    dims = (DIMENSIONS[name],)
    kinds = dict.fromkeys(table, SECOND) | dict(system.tables[name])
    return {
        key: Column(dims, values, flag_attributes(kinds[key], WORDS[key]))
        if isinstance(kinds[key], tuple)
        else column(values, kinds[key], WORDS[key], dims)
        for key, values in table.items()
    }


def joined(system: System, parts: dict[str, list[Rows]]) -> dict[str, dict[str, Column]]:
    """Return the tables of a system as columns, joined from parts; empty tables without parts."""
    whole = {}
    for name, kinds in system.tables.items():
        tables = [as_table(name, kinds, []), *parts.get(name, [])]
        rows = {key: np.concatenate([table[key] for table in tables]) for key in tables[0]}
        whole[name] = columns(system, name, rows)
    return whole

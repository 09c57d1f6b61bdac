"""Tables of the phases of a run and of occurrences between them: groups of its store."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..mechanics.form import Phase
from ..mechanics.units import SECOND
from ..problem import Problem


Table = dict[str, np.ndarray]


class PhaseTables:
    """New rows of the tables, in SI units; and the phase that is under way.

    Parameters
    ----------
    problem
        The run; its system has `tables`.
    """

    def __init__(self, problem: Problem):
        self.tables = problem.system.tables
        self.second = float(problem.scales.of(SECOND))
        self.factors = {
            name: [
                None if isinstance(kind, tuple) else float(problem.scales.of(kind))
                for kind in kinds.values()
            ]
            for name, kinds in self.tables.items()
        }
        self.under_way: list[Any] | None = None
        self.rows: dict[str, list[list[Any]]] = {name: [] for name in self.tables}

    def begin(self, name: str, phase: Phase, time: float, cause: str) -> None:
        """Begin a phase of this name at an internal time."""
        self.end(time)
        if "phases" not in self.tables:
            return
        words = self.tables["phases"]
        row = {"phase": phase.label or name, "ball": phase.ball, "reason": cause}
        numbers = [
            words[key].index(row[key]) if isinstance(row[key], str) else row[key] for key in words
        ]
        self.under_way = [time * self.second, *numbers]

    def end(self, time: float) -> None:
        """End the phase that is under way."""
        if self.under_way is not None:
            start, *rest = self.under_way
            self.rows["phases"].append([start, time * self.second, *rest])
            self.under_way = None

    def add(self, time: float, rows: Sequence[tuple[str, tuple]]) -> None:
        """Add rows of other tables at an internal time."""
        for name, some in rows:
            kinds = self.tables[name].values()
            for row in some:
                values = [
                    value * factor
                    if factor is not None
                    else kind.index(value)
                    if isinstance(value, str)
                    else value
                    for value, factor, kind in zip(row, self.factors[name], kinds, strict=True)
                ]
                self.rows[name].append([time * self.second, *values])

    def take(self) -> dict[str, Table]:
        """Return the rows that came since the last call, by table."""
        rows, self.rows = self.rows, {name: [] for name in self.tables}
        return {name: as_table(name, self.tables[name], some) for name, some in rows.items()}


def columns_of(name: str, kinds: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the columns of a table."""
    return (*(("start", "end") if name == "phases" else ("time",)), *kinds)


def as_table(name: str, kinds: Mapping[str, Any], rows: list[list[Any]]) -> Table:
    """Return rows as columns."""
    return {
        column: np.array(
            [row[k] for row in rows], np.int8 if isinstance(kinds.get(column), tuple) else float
        )
        for k, column in enumerate(columns_of(name, kinds))
    }

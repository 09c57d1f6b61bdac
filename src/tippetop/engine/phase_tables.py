"""The tables of phases and impacts of a run, which become groups of its store.

A `HybridDriver` reports each change of phase; `take_rows` returns the new rows, as columns in SI
units by table, for a `Slice`.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..mechanics.units import SECOND
from ..problem import Problem


Table = dict[str, np.ndarray]


class PhaseTables:
    """Collect new rows of the tables of phases and impacts, in internal units.

    Parameters
    ----------
    problem
        The run; its system has `tables`.

    Attributes
    ----------
    under_way
        Internal time at which the present phase began, then the indices of its words, as
        `number_of` returns them; empty without a phase. Snapshots contain it.
    """

    def __init__(self, problem: Problem):
        self.tables = problem.system.tables
        self.scales = problem.scales
        self.under_way: list[float] = []
        self.rows = defaultdict[str, list[Sequence]](list)
        self.numbers = dict[tuple, list]()  # (phase, cause) -> indices of its words

    def begin(self, time: float, solver: Any, cause: str) -> None:
        """Add the row of the phase that ends, and begin that of `solver` at an internal time.

        `solver` is a `PhaseSolver`, `cause` the word in the column `reason` of its row. A
        system's table of phases may have the columns `phase`, `ball` and `reason`, no others.
        """
        self.end(time)
        name = solver.name
        phase = solver.phase
        if (name, cause) not in self.numbers:
            row = {"phase": phase.label or name, "ball": phase.ball, "reason": cause}
            kinds = self.tables["phases"].items()
            self.numbers[name, cause] = [number_of(row[key], kind) for key, kind in kinds]
        self.under_way = [time, *self.numbers[name, cause]]

    def end(self, time: float) -> None:
        """Add the row of the present phase, which ends at an internal time; then none is under way.

        Without a present phase nothing happens.
        """
        if self.under_way:
            start, *rest = self.under_way
            self.rows["phases"].append([start, time, *rest])
            self.under_way = []

    def add(self, time: float, rows: Mapping[str, Sequence]) -> None:
        """Add rows of other tables, by table, at an internal time, which is put before each.

        `JumpPrograms.drive` adds those of changes by programs in the same layout.
        """
        for name, some in rows.items():
            self.rows[name] += [(time, *row) for row in some]

    def take_rows(self) -> dict[str, Table]:
        """Return the rows since the last call, as columns by table, and remove them.

        A table without new rows has empty columns.
        """
        rows = self.rows
        self.rows = defaultdict(list)
        return {
            name: as_table(name, kinds, rows[name], self.scales)
            for name, kinds in self.tables.items()
        }


def number_of(value: Any, kind: Any) -> Any:
    """Return the index of a word in `kind`, the words of its column; a number unchanged.

    So stores have the index: the order of words is part of their format.
    """
    return kind.index(value) if isinstance(value, str) else value


def as_table(
    name: str, kinds: Mapping[str, Any], rows: Sequence[Sequence[Any]], scales: Any = None
) -> Table:
    """Return rows of the table `name`, in internal units, as columns in SI, by name.

    `kinds` are the entries of `System.tables`: the unit of each column, or its words, which become
    their indices. A row begins with its times. `scales` may be left out without rows.
    """
    table = Table()
    times = ("start", "end") if name == "phases" else ("time",)
    for k, (column, kind) in enumerate({**dict.fromkeys(times, SECOND), **kinds}.items()):
        is_word = isinstance(kind, tuple)
        unit = float(scales.of(kind)) if rows and not is_word else 1
        values = [number_of(row[k], kind) if is_word else row[k] for row in rows]
        table[column] = unit * np.array(values, np.int8 if is_word else float)
    return table

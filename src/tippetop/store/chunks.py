"""Read the columns of a store in blocks, or thinned to a number of rows that figures can draw.

A path and the name of a group go in; Datasets in memory come out.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..sampling import extremes
from .root import column, groups_of, loaded, open_group


BLOCK = 1 << 18  # rows that are read at a time
Window = tuple[float | None, float | None]


def pieces(path: str | Path, group: str, names: list[str]) -> Iterator[dict[str, np.ndarray]]:
    """Yield those columns of a group that exist, a block of rows at a time. Raises StoreError.

    Other names are left out: `samples.needed` of views lists columns that a run may lack.
    """
    table = open_group(path, group)
    names = [name for name in names if name in table]
    for piece in blocks(table[names], path):
        yield {name: piece[name].values for name in names}


def blocks(table: Any, path: str | Path, first: int = 0, last: int | None = None) -> Iterator[Any]:
    """Yield rows of a lazy Dataset of a store as Datasets in memory, a block at a time.

    `first` and `last` are numbers of rows, by default all. There is at least one block, perhaps
    without rows: `export` takes the names of columns from the first. `path` is for messages. Raises
    StoreError.
    """
    dim = row_dimension(table)
    last = table.sizes[dim] if last is None else last
    for start in range(first, max(last, first + 1), BLOCK):
        yield loaded(table.isel({dim: slice(start, min(start + BLOCK, last))}), path)


def row_dimension(table: Any) -> str:
    """Return the name of the dimension of the rows of a group: the first of each of its arrays."""
    return next(iter(table.variables.values())).dims[0]


def thin(
    path: str | Path,
    group: str,
    key: str = "theta",
    most: int = 400_000,
    window: Window = (None, None),
) -> Any:
    """Return a group as a Dataset of at most about `most` rows. Raises StoreError.

    Of more rows, the one with the least and the one with the largest `key` (a column) of each bin
    are kept, so that no peak is lost. With a window (start, until) [s], the rows of these times and
    the first row of all are kept: `figures.window.in_window` takes the start of the run from it.
    """
    table = open_group(path, group)
    dim = row_dimension(table)
    first = 0
    last = table.sizes[dim]
    if window != (None, None):
        times = column(path, table, "time")
        low, high = window
        first = 0 if low is None else int(np.searchsorted(times, low))
        last = last if high is None else int(np.searchsorted(times, high, side="right"))
    rows = np.arange(first, last)
    if rows.size > most:
        keys = [piece[key].values for piece in blocks(table[[key]], path, first, last)]
        # of each bin two rows are kept
        rows = first + extremes(np.concatenate(keys), -(-rows.size // (most // 2)))
    return loaded(table.isel({dim: np.append(np.arange(min(first, 1)), rows)}), path)


def for_figures(path: str | Path, window: Window = (None, None)) -> dict[str, Any]:
    """Return the groups of a run for figures: rows and events thinned, phases and impacts whole."""
    groups = {name: thin(path, name, window=window) for name in ("trajectory", "events")}
    whole = [name for name in ("phases", "impacts") if name in groups_of(path)]
    return groups | {name: thin(path, name, most=2**62) for name in whole}

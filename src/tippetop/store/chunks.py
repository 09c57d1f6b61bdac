"""Columns of a store as they are read: checked, a block at a time, and thinly where
they are many.
"""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..sampling import extremes
from .root import groups_of


Window = tuple[float | None, float | None]


def read_member(path: str | Path, name: str) -> dict[str, Any]:
    """The arrays of a group of a store, by name. Raises StoreError."""
    import zarr  # a run is written without

    try:
        group: Any = zarr.open_group(store=str(path), mode="r")[name]
        return dict(sorted(group.arrays()))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{name}`, but: {error}.") from None


def rows(array: Any, start: int, end: int) -> np.ndarray:
    """Return rows of an array.

    Raises StoreError where a chunk is damaged, or missing, which zarr would fill.
    """
    begins = start // array.chunks[0] * array.chunks[0]
    further = (range(0, n, c) for n, c in zip(array.shape[1:], array.chunks[1:], strict=True))
    place = array.store_path.store.root / array.path
    try:
        for first in itertools.product(range(begins, end, array.chunks[0]), *further):
            key = array.metadata.encode_chunk_key(
                tuple(i // c for i, c in zip(first, array.chunks, strict=True))
            )
            if not (place / key).is_file():
                raise OSError("a chunk is missing")
        return array[start:end]
    except Exception as error:  # codecs raise what they like
        raise StoreError(
            f"`{place}` must be readable in rows {start} to {end}, but: {error}."
        ) from None


def pieces(
    path: str | Path,
    group: str,
    names: list[str],
    size: int = 1 << 18,
    first: int = 0,
    last: int | None = None,
) -> Iterator[dict[str, np.ndarray]]:
    """The columns of a group from row `first` to before row `last`, a block at a time.

    Raises StoreError.
    """
    arrays = {name: array for name, array in read_member(path, group).items() if name in names}
    total = min((array.shape[0] for array in arrays.values()), default=0)
    total = total if last is None else min(total, last)
    for start in range(first, total, size):
        end = min(start + size, total)
        yield {name: rows(array, start, end) for name, array in arrays.items()}


def digest(
    path: str | Path,
    group: str,
    key: str | None = None,
    most: int = 400_000,
    window: Window = (None, None),
) -> dict[str, Column]:
    """A group as columns of at most about `most` rows: all rows if there are no more; else of every
    bin of rows the one where `key` is least and the one where it is largest, so that no peak is
    lost (without key, the first). With a window, the rows of these times and the first row of all.
    """
    arrays = read_member(path, group)
    total = min((array.shape[0] for array in arrays.values()), default=0)
    first, last = _rows_of(path, group, window, total)
    size = -(-(last - first) // (most // 2)) if last - first > most else 1
    kept: dict[str, list[np.ndarray]] = {name: [] for name in arrays}
    if first > 0:
        for name, values in next(pieces(path, group, list(arrays), 1)).items():
            kept[name].append(values)
    for piece in pieces(path, group, list(arrays), (1 << 19) // size * size, first, last):
        picked = _picked(piece.get(key) if key else None, len(next(iter(piece.values()))), size)
        for name, values in piece.items():
            kept[name].append(values[picked])
    return {
        name: Column(
            tuple(map(str, array.metadata.dimension_names)),
            np.concatenate(kept[name]) if kept[name] else array[:0],
            dict(array.attrs),
        )
        for name, array in arrays.items()
    }


def _rows_of(path: str | Path, group: str, window: Window, total: int) -> tuple[int, int]:
    """The first row of a window of times and the row after its last. Raises StoreError."""
    if window == (None, None):
        return 0, total
    times = np.concatenate(
        [np.empty(0), *(piece["time"] for piece in pieces(path, group, ["time"], 1 << 20))]
    )[:total]
    low, high = (
        (-np.inf if window[0] is None else window[0]),
        (np.inf if window[1] is None else window[1]),
    )
    return int(np.searchsorted(times, low)), int(np.searchsorted(times, high, side="right"))


def for_figures(path: str | Path, window: Window = (None, None)) -> dict[str, dict[str, Column]]:
    """The groups of a run that figures are made of: rows and events (of a window of times) thinned
    by theta, phases and impacts whole.
    """
    groups = {name: digest(path, name, "theta", window=window) for name in ("trajectory", "events")}
    whole = [name for name in ("phases", "impacts") if name in groups_of(path)]
    return groups | {name: digest(path, name, most=2**62) for name in whole}


def _picked(key: np.ndarray | None, count: int, size: int) -> np.ndarray:
    """Indices of the rows that stand for bins of `size` rows; the last row is always among them."""
    if size == 1:
        return np.arange(count)
    return (
        np.union1d(np.arange(0, count, size), [count - 1]) if key is None else extremes(key, size)
    )

"""Columns in chunks on disk: growing row by row, checked, and read thinly where there are more than memory holds."""

import dataclasses
import hashlib
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from zarr.core.sync import sync

from ..columns import Column
from ..errors import StoreError
from ..sampling import extremes
from . import seal
from .skeleton import groups_of
from .tables import create_table, read_member


MOST_ROWS = 1 << 62
Window = tuple[float | None, float | None]


class Appender:
    """Grows the arrays of a group row by row, in whole chunks; rows that do not fill a chunk wait in memory.

    A flush writes the waiting rows too, as a chunk that is written again when it is full: so the files of a finished
    store do not depend on when it was flushed. Only then the metadata say how many rows there are: chunks beyond are
    not acknowledged yet.
    """

    def __init__(self, arrays: dict[str, Any]):
        self.arrays = arrays
        self.endless = {name: _endless(array) for name, array in arrays.items()}
        self.chunk = chunk = next(iter(self.arrays.values())).chunks[0]
        self.written, self.waiting = 0, 0  # rows in full chunks, rows in memory
        self.buffers = {name: np.empty((chunk, *array.shape[1:]), array.dtype) for name, array in self.arrays.items()}
        self.unflushed = False
        self.checksums: dict[tuple[str, int], bytes] = {}  # of full chunks

    @classmethod
    def created(cls, root: Any, name: str, columns: dict[str, Column], chunk: int) -> "Appender":
        """A new group whose arrays have the columns' names, types and attributes, and no rows."""
        rows = next(iter(columns.values())).dims[0]
        return cls(create_table(root.create_group(name), columns, {rows: (0, chunk)}))

    @property
    def rows(self) -> int:
        """How many rows were appended."""
        return self.written + self.waiting

    def append(self, columns: dict[str, Column]) -> None:
        """Takes rows; writes every chunk that they fill."""
        values = {name: column.values for name, column in columns.items()}
        count, taken = len(next(iter(values.values()))), 0
        while taken < count:
            step = min(self.chunk - self.waiting, count - taken)
            for name, buffer in self.buffers.items():
                buffer[self.waiting : self.waiting + step] = values[name][taken : taken + step]
            self.waiting, taken, self.unflushed = self.waiting + step, taken + step, True
            if self.waiting == self.chunk:
                self._write(self.chunk)
                self.written, self.waiting = self.written + self.chunk, 0

    def flush(self) -> None:
        """Writes the rows that wait, and how many there are."""
        if self.unflushed and self.waiting:
            self._write(self.waiting)
        self.unflushed = False
        for array in self.arrays.values():
            if array.shape[0] < self.rows:
                array.resize((self.rows, *array.shape[1:]))

    def _write(self, count: int) -> None:
        end = self.written + count
        for name, array in self.endless.items():
            array[self.written : end] = self.buffers[name][:count]

    def sync(self) -> None:
        """Wait until the disk has all that was written to the store of these arrays."""
        next(iter(self.arrays.values())).store_path.store.sync()

    def mark(self, name: str, rows: list[int], value: bool = True) -> None:
        """Sets a column of flags in some rows, written or waiting."""
        waiting = [row - self.written for row in rows if row >= self.written]
        self.buffers[name][waiting] = value
        self.unflushed = self.unflushed or bool(waiting)
        older = [row for row in rows if row < self.written]
        for start in {row // self.chunk * self.chunk for row in older}:
            some = slice(start, start + self.chunk)
            flags = self.endless[name][some]
            flags[[row - start for row in older if start <= row < some.stop]] = value
            self.endless[name][some] = flags

    def cut(self, rows: int) -> None:
        """Cuts the arrays to the rows that a checkpoint acknowledges."""
        for name, array in self.arrays.items():
            if array.shape[0] < rows:
                raise StoreError(f"`{name}` must hold the {rows} acknowledged rows, but has {array.shape[0]}.")
        for array in self.arrays.values():
            _shrink(array, rows)

    def digest(self) -> str:
        """A digest of all rows that were appended: of full chunks the checksums in their files, and those that wait.

        Flags are passed over: `mark` may change them before the next checkpoint. Raises OSError.
        """
        waiting = {name: buffer[: self.waiting] for name, buffer in self.buffers.items()}
        return _digest(self.arrays, self.written, waiting, self.checksums)

    def reload(self, rows: int) -> None:
        """Takes the rows that do not fill a chunk back into memory."""
        self.written = rows // self.chunk * self.chunk
        self.waiting = rows - self.written
        for name, array in self.arrays.items():
            self.buffers[name][: self.waiting] = array[self.written : rows]
        self.unflushed = True


def _endless(array: Any) -> Any:
    """An array into which rows can be written beyond those that its metadata on the disk tell of."""
    inner = array.async_array
    metadata = inner.metadata.update_shape((MOST_ROWS, *array.shape[1:]))
    return type(array)(dataclasses.replace(inner, metadata=metadata))


def _shrink(array: Any, rows: int) -> None:
    """Cuts an array, its metadata first: a writer that is killed on the way leaves chunks too many, which the next cut
    removes, and never too few, which would be damage."""
    store, needed = array.store_path.store, -(-rows // array.chunks[0])
    sync(array.async_array.resize((rows, *array.shape[1:]), delete_outside_chunks=False))
    folder = store.root / array.store_path.path / "c"
    for entry in sorted(folder.iterdir()) if folder.is_dir() else ():
        if entry.name.isdigit() and int(entry.name) >= needed:
            store.delete_sync(f"{array.store_path.path}/c/{entry.name}")


def digest_of_rows(arrays: dict[str, Any], rows: int) -> str:
    """The digest that an appender of so many rows would give. Raises what codecs raise."""
    chunk = next(iter(arrays.values())).chunks[0]
    written = rows // chunk * chunk
    return _digest(arrays, written, {name: array[written:rows] for name, array in arrays.items()}, {})


def _digest(
    arrays: dict[str, Any],
    written: int,
    waiting: dict[str, np.ndarray],
    checksums: dict[tuple[str, int], bytes],
) -> str:
    whole = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        if array.dtype == bool:
            continue
        for start in range(0, written, array.chunks[0]):
            if (name, start) not in checksums:
                checksums[name, start] = seal.checksum(chunk_file(array, start))
            whole.update(checksums[name, start])
        whole.update(name.encode() + np.ascontiguousarray(waiting[name]).tobytes())
    return whole.hexdigest()


def verify(arrays: dict[str, Any]) -> None:
    """Reads every chunk of some arrays. Raises StoreError, which names the array and the rows that cannot be read."""
    for array in arrays.values():
        for first in itertools.product(*(range(0, n, c) for n, c in zip(array.shape, array.chunks, strict=True))):
            readable(array, *first)


def readable(array: Any, *first: int) -> np.ndarray:
    """The chunk of an array that begins at these indices, those that are left out 0. Raises StoreError if it is missing
    or damaged."""
    start, end = first[0], min(first[0] + array.chunks[0], array.shape[0])
    try:
        if not chunk_file(array, *first).is_file():
            raise OSError("the file of the chunk is missing")
        return array[tuple(slice(i, i + c) for i, c in zip(first, array.chunks, strict=False))]
    except Exception as error:  # codecs raise what they like
        raise StoreError(f"`{array.path}` must be readable in rows {start} to {end}, but: {error}.") from None


def chunk_file(array: Any, *first: int) -> Path:
    """The file of the chunk that begins at these indices, those that are left out 0."""
    begins = [*first, *[0] * (array.ndim - len(first))]
    names = [str(i // c) for i, c in zip(begins, array.chunks, strict=True)]
    return array.store_path.store.root.joinpath(array.store_path.path, "c", *names)


def pieces(
    path: str | Path, group: str, names: list[str], rows: int = 1 << 18, first: int = 0, last: int | None = None
) -> Iterator[dict[str, np.ndarray]]:
    """The columns of a group from row `first` to before row `last`, a block at a time. Raises StoreError."""
    arrays = {name: array for name, array in read_member(path, group).items() if name in names}
    total = min((array.shape[0] for array in arrays.values()), default=0)
    total = total if last is None else min(total, last)
    for start in range(first, total, rows):
        end = min(start + rows, total)
        try:
            yield {name: _rows(array, start, end) for name, array in arrays.items()}
        except Exception as error:  # codecs raise what they like
            raise StoreError(f"`{path}` must be readable in rows {start} to {end}, but: {error}.") from None


def _rows(array: Any, start: int, end: int) -> np.ndarray:
    """Rows of an array. Raises OSError where a chunk is missing, which zarr would fill, and what codecs raise."""
    begins = start // array.chunks[0] * array.chunks[0]
    further = (range(0, n, c) for n, c in zip(array.shape[1:], array.chunks[1:], strict=True))
    for first in itertools.product(range(begins, end, array.chunks[0]), *further):
        if not chunk_file(array, *first).is_file():
            raise OSError(f"a chunk of `{array.basename}` is missing")
    return array[start:end]


def digest(
    path: str | Path, group: str, key: str | None = None, most: int = 400_000, window: Window = (None, None)
) -> dict[str, Column]:
    """A group as columns of at most about `most` rows: all rows if there are no more; else of every bin of rows the one
    where `key` is least and the one where it is largest, so that no peak is lost (without key, the first). With a
    window, the rows of these times and the first row of all."""
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
    times = np.concatenate([np.empty(0), *(piece["time"] for piece in pieces(path, group, ["time"], 1 << 20))])[:total]
    low, high = (-np.inf if window[0] is None else window[0]), (np.inf if window[1] is None else window[1])
    return int(np.searchsorted(times, low)), int(np.searchsorted(times, high, side="right"))


def for_figures(path: str | Path, attrs: dict[str, Any], window: Window = (None, None)) -> dict[str, dict[str, Column]]:
    """The groups of a run that figures are made of: rows and events (of a window of times) thinned by theta, phases and
    impacts whole."""
    groups = {name: digest(path, name, "theta", window=window) for name in ("trajectory", "events")}
    whole = [name for name in ("phases", "impacts") if name in groups_of(attrs)]
    return groups | {name: digest(path, name, most=2**62) for name in whole}


def _picked(key: np.ndarray | None, count: int, size: int) -> np.ndarray:
    """Indices of the rows that stand for bins of `size` rows; the last row is always among them."""
    if size == 1:
        return np.arange(count)
    return np.union1d(np.arange(0, count, size), [count - 1]) if key is None else extremes(key, size)

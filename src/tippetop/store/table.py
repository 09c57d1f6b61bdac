"""A table that grows row by row: its full chunks go to the ledger, and the rows that wait go to the
tail.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from . import zarr3
from .ledger import Ledger


LATE = "-late"  # ends the name of the table of those columns that may change until the end


class Table:
    """The rows of a table that no chunk holds yet.

    Late columns are kept whole, as they may change in any row until the end; their chunks are then
    written.
    """

    def __init__(self, ledger: Ledger, name: str):
        members, tables = ledger.state.header["members"], ledger.state.header["tables"]
        self.ledger, self.name = ledger, name
        self.documents = {
            path: members[path] for path in [*tables[name], *tables.get(name + LATE, [])]
        }
        self.late = set(tables.get(name + LATE, []))
        self.chunk = self.documents[tables[name][0]]["chunk_grid"]["configuration"]["chunk_shape"][
            0
        ]
        self.written, self.rows = 0, 0  # rows in chunks, and of all
        self.waiting: dict[str, list[np.ndarray]] = {
            path: [np.empty((0, *document["shape"][1:]), document["data_type"])]
            for path, document in self.documents.items()
        }

    def append(self, values: Mapping[str, np.ndarray]) -> None:
        """Take rows, by the names of their columns; write every chunk that they fill."""
        for path in self.documents:
            column = values[path.rpartition("/")[2]]
            self.waiting[path].append(
                np.array(column, order="C")
            )  # a copy: whoever made it uses its memory again
        self.rows += len(column)
        while self.rows - self.written >= self.chunk:
            self._put(self.chunk)

    def _put(self, count: int) -> None:
        chunk = {}
        for path in self.documents.keys() - self.late:
            values = self._joined(path)
            chunk[path.rpartition("/")[2]] = values[:count]
            self.waiting[path] = [values[count:]]
        self.ledger.put(f"{self.name}/{self.written // self.chunk}", chunk)
        self.written += count

    def _joined(self, path: str) -> np.ndarray:
        """The rows of a column that wait, as one array."""
        if len(self.waiting[path]) > 1:
            self.waiting[path] = [np.concatenate(self.waiting[path])]
        return self.waiting[path][0]

    def _file(self, path: str, first: int) -> str:
        return f"{path}/{zarr3.chunk_name(self.documents[path], first // self.chunk)}"

    def mark(self, column: str, rows: list[int], value: bool = True) -> None:
        """Set a late column of flags in some rows."""
        path = next(path for path in self.late if path.endswith(f"/{column}"))
        self._joined(path)[rows] = value

    def values(self, column: str) -> np.ndarray:
        """Return all rows of a column."""
        path = f"{self.name}/{column}"
        chunks = (
            []
            if path in self.late
            else [self._stored(path, k) for k in range(self.written // self.chunk)]
        )
        return np.concatenate([*chunks, self._joined(path)])

    def _stored(self, path: str, k: int) -> np.ndarray:
        document = self.documents[path]
        return zarr3.decode(self.ledger.folder.read(self._file(path, k * self.chunk)), document)

    def cut(self, rows: int) -> None:
        """Take the first rows of the table of a finished store: full chunks stay, the rest waits
        again.
        """
        self.rows, self.written = rows, rows // self.chunk * self.chunk
        for path in self.documents:
            first = 0 if path in self.late else self.written // self.chunk
            parts = [self._stored(path, k) for k in range(first, -(-rows // self.chunk))]
            self.waiting[path] = [
                np.concatenate([*self.waiting[path], *parts])[: rows - first * self.chunk]
            ]

    def chunks(self) -> list[str]:
        """Return the keys of the full chunks in the ledger."""
        return [f"{self.name}/{k}" for k in range(self.written // self.chunk)]

    def derived(self) -> dict[str, bytes]:
        """Return the files of chunks that are not acknowledged, for readers of an
        unfinished store.
        """
        return {
            self._file(path, first): zarr3.encode(part, self.documents[path])
            for path in self.documents
            for first, part in self._parts(path)
        }

    def _parts(self, path: str) -> Iterator[tuple[int, np.ndarray]]:
        values = self._joined(path)
        for start in range(0, len(values), self.chunk):
            yield self.rows - len(values) + start, values[start : start + self.chunk]

    def finish(self) -> None:
        """Write the chunks of all rows that wait."""
        if self.rows > self.written:
            self._put(self.rows - self.written)
        for first in range(0, self.rows if self.late else 0, self.chunk):
            rows = slice(first, first + self.chunk)
            flags = {path.rpartition("/")[2]: self._joined(path)[rows] for path in self.late}
            self.ledger.put(f"{self.name}{LATE}/{first // self.chunk}", flags)

    def counts(self) -> dict[str, int]:
        """Return the number of rows, by the names of tables that a ledger has."""
        return dict.fromkeys([self.name, *([self.name + LATE] if self.late else [])], self.rows)

    def tail(self) -> tuple[list[Any], bytes]:
        """Return the rows that wait as bytes, and what is needed to read them."""
        arrays = {path: self._joined(path) for path in self.documents}
        about = [self.written, [len(values) for values in arrays.values()]]
        return about, b"".join(values.tobytes() for values in arrays.values())

    def restore(self, about: list[Any], data: bytes) -> bytes:
        """Take back what `tail` returned; return the bytes that follow it."""
        self.written, counts = about
        for (path, document), count in zip(self.documents.items(), counts, strict=True):
            shape = (count, *document["shape"][1:])
            values = np.frombuffer(data, document["data_type"], int(np.prod(shape))).reshape(shape)
            self.waiting[path], data = [values.copy()], data[values.nbytes :]
        self.rows = self.written + counts[0]
        return data

"""Tables of a store that grow row by row.

Columns of rows go in; full chunks go to the `Ledger`, the rest is its tail.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from . import zarr3
from .ledger import Ledger


LATE = "-late"  # ends the name of a table of columns that may change until the end


class Table:
    """Gather rows until they fill a chunk, which goes to the ledger; the others form the tail.

    `runs.recording` makes one for each table of a run.

    A late table has columns that may change until the end: it writes no chunk before.
    """

    def __init__(self, ledger: Ledger, name: str):
        """Begin with no rows, and an empty list of waiting ones for each column."""
        self.ledger = ledger
        self.name = name
        self.group = name.removesuffix(LATE)
        self.documents = {
            path.rpartition("/")[2]: ledger.state.header["members"][path]
            for path in ledger.state.header["tables"][name]
        }
        self.chunk = zarr3.chunk_shape(next(iter(self.documents.values())))[0]
        self.written = self.rows = 0  # rows in chunks, and of all
        self.waiting: dict[str, list[np.ndarray]] = {
            column: [np.empty((0, *document["shape"][1:]), document["data_type"])]
            for column, document in self.documents.items()
        }

    def append(self, values: Mapping[str, np.ndarray]) -> None:
        """Append rows, (k, ...) by the names of their columns; write every chunk that they fill.

        Other names are ignored: a table and its late one get the same rows.
        """
        for column, waiting in self.waiting.items():
            # a copy: the caller uses its memory again
            waiting.append(np.array(values[column], order="C"))
        self.rows += len(waiting[-1])
        while self.name == self.group and self.rows - self.written >= self.chunk:
            self._put()

    def _put(self) -> None:
        """Write one chunk from the waiting rows.

        Only the last chunk of a finished table may be shorter.
        """
        chunk = {}
        for column in self.documents:
            values = self._joined(column)
            chunk[column], self.waiting[column] = values[: self.chunk], [values[self.chunk :]]
        self.ledger.put(f"{self.name}/{self.written // self.chunk}", chunk)
        self.written = min(self.written + self.chunk, self.rows)

    def _joined(self, column: str) -> np.ndarray:
        """Return the rows of a column that wait for a chunk, as one array, which may be changed."""
        if len(self.waiting[column]) > 1:
            self.waiting[column] = [np.concatenate(self.waiting[column])]
        return self.waiting[column][0]

    def _file(self, column: str, first: int) -> str:
        """Return the path of the file of a column with the chunk that begins at row `first`."""
        name = zarr3.chunk_name(self.documents[column], first // self.chunk)
        return f"{self.group}/{column}/{name}"

    def mark(self, column: str, rows: list[int], value: bool = True) -> None:
        """Set a late column of flags in the rows of these numbers, counted from the first one.

        Only a late table has all its rows here.
        """
        self._joined(column)[rows] = value

    def _stored(self, column: str, first: int, last: int) -> list[np.ndarray]:
        """Return the chunks of a column from row `first` to before row `last`, read from files."""
        read = self.ledger.folder.read
        document = self.documents[column]
        firsts = range(first, last, self.chunk)
        return [zarr3.decode(read(self._file(column, k)), document) for k in firsts]

    def cut(self, rows: int) -> None:
        """Shorten a finished table to its first rows; those that fill no chunk are read again."""
        full = rows // self.chunk * self.chunk if self.name == self.group else 0
        self.rows = rows
        self.written = full
        for column, waiting in self.waiting.items():
            parts = [*waiting, *self._stored(column, full, rows)]
            self.waiting[column] = [np.concatenate(parts)[: rows - full]]

    def chunks(self) -> list[str]:
        """Return the keys of the full chunks in the ledger."""
        return [f"{self.name}/{k}" for k in range(self.written // self.chunk)]

    def derived(self) -> Iterator[tuple[str, bytes]]:
        """Yield the files of chunks that are not acknowledged, for readers of the store."""
        for column, document in self.documents.items():
            values = self._joined(column)
            for start in range(0, len(values), self.chunk):
                data = zarr3.encode(values[start : start + self.chunk], document)
                yield self._file(column, self.written + start), data

    def finish(self) -> None:
        """Write all rows that are not in chunks yet; nothing may be appended afterwards."""
        while self.rows > self.written:
            self._put()

    def tail(self) -> bytes:
        """Return the rows that are not in chunks yet as bytes, column by column, for `restore`.

        Columns are in the order of the header, which the store keeps.
        """
        return b"".join(self._joined(column).tobytes() for column in self.documents)

    def restore(self, written: int, rows: int, data: bytes) -> bytes:
        """Load the rows of a tail into an empty table; return the bytes that follow them.

        `written` and `rows` are its numbers of rows in chunks and of all, `data` begins with what
        `tail` returned.
        """
        self.written = written
        self.rows = rows
        for column, document in self.documents.items():
            shape = (rows - written, *document["shape"][1:])
            values = np.frombuffer(data, document["data_type"], int(np.prod(shape))).reshape(shape)
            # a copy: `mark` changes values, and those of a buffer are read-only
            self.waiting[column], data = [values.copy()], data[values.nbytes :]
        return data

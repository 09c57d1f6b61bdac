"""Arrays and groups of a store, made, written and read without zarr: to import zarr takes longer than to integrate a
top. The files are those that zarr would write, byte for byte; whoever reads a store may do it with zarr."""

import contextlib
import itertools
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np
from numcodecs import blosc, zstd

from ..columns import Column
from .place import Place
from .seal import CHECKSUM, DOCUMENT


LZ4 = {"cname": "lz4", "clevel": 1, "shuffle": "shuffle", "blocksize": 0}
"""How a chunk becomes bytes: lz4 and shuffle, smaller and faster than zstd here; a checksum makes damage an error to
read."""


def document_of(column: Column, shape: list[int], chunk: list[int], fill: Any = None) -> dict[str, Any]:
    """The metadata of an array that is made for a column; its values are not looked at.

    Parameters
    ----------
    column
        Gives dimensions, type and attributes.
    shape, chunk
        Lengths of the array and of its chunks.
    fill
        What stands where nothing was written; otherwise NaN, or 0 where the type has none.
    """
    kind = column.values.dtype
    nothing: Any = False if kind.kind == "b" else "NaN" if kind.kind == "f" else 0
    if fill is not None and not (kind.kind == "f" and np.isnan(fill)):
        nothing = kind.type(fill).item()
    order = {"name": "bytes", "configuration": {"endian": "little"}} if kind.itemsize > 1 else {"name": "bytes"}
    return {
        "shape": shape,
        "data_type": kind.name,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
        "fill_value": nothing,
        "codecs": [
            order,
            {"name": "blosc", "configuration": {"typesize": kind.itemsize, **LZ4}},
            {"name": "crc32c"},
        ],
        "attributes": column.attrs,
        "dimension_names": list(column.dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }


class Node:
    """What has a metadata document in a store.

    Parameters
    ----------
    place
        The store.
    path
        Where in it; empty for its root.
    document
        The metadata.
    """

    def __init__(self, place: Place, path: str, document: dict[str, Any]):
        self.place, self.path, self.document = place, path, document

    @property
    def folder(self) -> Path:
        """Its folder."""
        return self.place.root / self.path

    @property
    def attrs(self) -> dict[str, Any]:
        """Its attributes."""
        return self.document["attributes"]

    def key(self, name: str) -> str:
        """The key of a file of it."""
        return f"{self.path}/{name}" if self.path else name

    def save(self) -> None:
        """Writes the metadata, whole or not at all."""
        self.place.write(self.key(DOCUMENT), json.dumps(self.document, indent=2).encode())


class Group(Node):
    """A group of arrays."""

    @classmethod
    def created(cls, place: Place, path: str, attributes: dict[str, Any]) -> "Group":
        """A new group."""
        group = cls(place, path, {"attributes": attributes, "zarr_format": 3, "node_type": "group"})
        group.save()
        return group

    def create_group(self, name: str) -> "Group":
        """A new group in it."""
        return Group.created(self.place, self.key(name), {})

    def update_attributes(self, more: dict[str, Any]) -> None:
        """Adds attributes, on the disk too."""
        self.attrs.update(more)
        self.save()

    def arrays(self) -> dict[str, "Array"]:
        """Its arrays, in the order of their names. Raises OSError, ValueError, KeyError."""
        folders = [entry.name for entry in self.folder.iterdir() if entry.is_dir() and entry.name[0] != "."]
        members = {name: opened(self.place, self.key(name)) for name in sorted(folders)}
        return {name: member for name, member in members.items() if isinstance(member, Array)}


def opened(place: Place, path: str) -> Any:
    """The array or the group that is at a place. Raises OSError, ValueError, KeyError."""
    document = json.loads((place.root / path / DOCUMENT).read_text(encoding="utf-8"))
    kinds = {"group": Group, "array": Array}
    return kinds[document["node_type"]](place, path, document)


class Array(Node):
    """An array in chunks; a chunk of nothing but the fill value is written too: then its absence is damage.

    It takes and gives what basic slices with step 1 name, and nothing else.
    """

    def __init__(self, place: Place, path: str, document: dict[str, Any]):
        super().__init__(place, path, document)
        self.shape = tuple(document["shape"])
        self.chunks = tuple(document["chunk_grid"]["configuration"]["chunk_shape"])
        self.dims = tuple(document["dimension_names"])
        self.dtype = np.dtype(document["data_type"]).newbyteorder("<")
        self.ndim = len(self.shape)
        fill = document["fill_value"]
        self.fill = np.nan if fill == "NaN" else fill

    @classmethod
    def created(cls, place: Place, path: str, document: dict[str, Any]) -> "Array":
        """A new array; nothing is written into it."""
        array = cls(place, path, document)
        array.save()
        return array

    def __len__(self) -> int:
        return self.shape[0]

    def resize(self, rows: int) -> None:
        """Makes the first axis longer or shorter; chunks stay as they are."""
        self.document = self.document | {"shape": [rows, *self.shape[1:]]}
        self.shape = (rows, *self.shape[1:])
        self.save()

    def cut(self, rows: int) -> None:
        """Cuts the array, its metadata first: a writer that is killed on the way leaves chunks too many, which the next
        cut removes, and never too few, which would be damage."""
        self.resize(rows)
        folder, needed = self.folder / "c", -(-rows // self.chunks[0])
        for entry in sorted(folder.iterdir()) if folder.is_dir() else ():
            if entry.name.isdigit() and int(entry.name) >= needed:
                self.place.delete(self.key(f"c/{entry.name}"))

    def chunk_file(self, *first: int) -> Path:
        """The file of the chunk that begins at these indices, those that are left out 0."""
        begins = [*first, *[0] * (self.ndim - len(first))]
        return self.folder.joinpath("c", *(str(i // c) for i, c in zip(begins, self.chunks, strict=True)))

    def __getitem__(self, key: Any) -> np.ndarray:
        whole, single = self._slices(key)
        values = np.empty([s.stop - s.start for s in whole], self.dtype)
        for number, inside, outside in self._pieces(whole):
            values[outside] = self._read(number)[inside]
        return values[tuple(0 if one else slice(None) for one in single)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self[:].astype(dtype or self.dtype, copy=False)

    def __setitem__(self, key: Any, values: Any) -> None:
        whole, single = self._slices(key)
        shape = [s.stop - s.start for s, one in zip(whole, single, strict=True) if not one]
        given = np.broadcast_to(np.asarray(values, self.dtype), shape).reshape([s.stop - s.start for s in whole])
        for number, inside, outside in self._pieces(whole):
            ends = (min(c, n - i * c) for i, c, n in zip(number, self.chunks, self.shape, strict=True))
            if given[outside].shape == self.chunks:
                chunk = np.ascontiguousarray(given[outside])
            else:
                covered = all(s.start == 0 and s.stop >= end for s, end in zip(inside, ends, strict=True))
                chunk = np.full(self.chunks, self.fill, self.dtype) if covered else self._read(number).copy()
                chunk[inside] = given[outside]
            self._write(number, chunk)

    def set(self, rows: list[int], value: Any) -> None:
        """Gives some rows, which exist, one value."""
        for row in rows:
            self[row] = value

    def _slices(self, key: Any) -> tuple[list[slice], list[bool]]:
        """For each axis a slice, and whether a number stood for it."""
        keys = [each for each in (key if isinstance(key, tuple) else (key,)) if each is not Ellipsis]
        keys += [slice(None)] * (self.ndim - len(keys))
        whole, single = [], []
        for each, n in zip(keys, self.shape, strict=True):
            if isinstance(each, slice):
                start, stop, _ = each.indices(n)
            else:
                start, stop = int(each), int(each) + 1
                if not 0 <= start < n:
                    raise IndexError(f"`{self.path}` has {n} rows, no row {start}")
            whole.append(slice(start, max(start, stop)))
            single.append(not isinstance(each, slice))
        return whole, single

    def _pieces(self, whole: list[slice]) -> Iterator[tuple[tuple[int, ...], tuple[slice, ...], tuple[slice, ...]]]:
        """The chunks that slices meet: number of a chunk, where in it, where in what is taken or given."""
        numbers = [
            range(s.start // c, -(-s.stop // c) if s.stop > s.start else s.start // c)
            for s, c in zip(whole, self.chunks, strict=True)
        ]
        for number in itertools.product(*numbers):
            begins = [max(s.start, i * c) for i, s, c in zip(number, whole, self.chunks, strict=True)]
            ends = [min(s.stop, i * c + c) for i, s, c in zip(number, whole, self.chunks, strict=True)]
            inside = tuple(
                slice(a - i * c, b - i * c) for i, a, b, c in zip(number, begins, ends, self.chunks, strict=True)
            )
            outside = (slice(a - s.start, b - s.start) for a, b, s in zip(begins, ends, whole, strict=True))
            yield number, inside, tuple(outside)

    def _write(self, number: tuple[int, ...], chunk: np.ndarray) -> None:
        with _one_thread():
            packed = blosc.compress(chunk, b"lz4", LZ4["clevel"], blosc.SHUFFLE, 0, self.dtype.itemsize)
        checksum = google_crc32c.value(packed).to_bytes(CHECKSUM, "little")
        self.place.write(self.key("/".join(["c", *map(str, number)])), packed + checksum)

    def _read(self, number: tuple[int, ...]) -> np.ndarray:
        """A chunk; where there is none, its fill value. Raises ValueError, RuntimeError, OSError."""
        try:
            content = self.folder.joinpath("c", *map(str, number)).read_bytes()
        except FileNotFoundError:
            return np.full(self.chunks, self.fill, self.dtype)
        if self.document["codecs"][1]["name"] == "zstd":
            plain = zstd.decompress(content)
        else:
            packed = content[:-CHECKSUM]
            if google_crc32c.value(packed).to_bytes(CHECKSUM, "little") != content[-CHECKSUM:]:
                raise ValueError("its checksum is another")
            with _one_thread():
                plain = blosc.decompress(packed)
        return np.frombuffer(plain, self.dtype).reshape(self.chunks)


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """A block in which blosc takes no threads: in the main thread, and nowhere else, it would start some."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before, blosc.use_threads = blosc.use_threads, False
    try:
        yield
    finally:
        blosc.use_threads = before

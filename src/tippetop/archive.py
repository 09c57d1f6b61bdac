"""Runs and tables of columns <-> zarr stores. A store appears whole or not at all."""

import contextlib
import json
import math
import os
import platform
import shutil
import uuid
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np


if TYPE_CHECKING:
    import xarray as xr

    from .trajectory import Column

FORMAT = "tippetop"
FORMAT_VERSION = 1


class StoreError(OSError):
    """The store or the disk: one sentence, exit code 5."""


@contextlib.contextmanager
def new_store(target: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Gives a scratch folder beside `target`, which becomes `target` when the block ends well and vanishes when not.

    Raises StoreError at once if `target` exists (and is not ours to overwrite) or cannot be written.
    """
    target = Path(target)
    _refuse_existing(target, overwrite)
    scratch = target.with_name(f".{target.name}.part-{uuid.uuid4().hex[:8]}")
    try:
        scratch.mkdir()
    except OSError as error:
        raise StoreError(f"`{target}` must be writable, but: {error.strerror or error}.") from None
    try:
        yield scratch
        if target.exists():
            old = scratch.with_suffix(".old")
            target.rename(old)
            scratch.rename(target)
            shutil.rmtree(old)
        else:
            scratch.rename(target)
    except OSError as error:
        raise StoreError(f"`{target}` must be written whole, but: {error.strerror or error}.") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _refuse_existing(target: Path, overwrite: bool) -> None:
    if not target.exists():
        return
    if not overwrite:
        raise StoreError(f"`{target}` must not exist yet, but does: remove it, or say --overwrite.")
    try:
        attributes(target)
    except StoreError:
        raise StoreError(f"`{target}` must be a store of tippetop to be overwritten, but is something else.") from None


class Appender:
    """Grows the arrays of a group row by row, in whole chunks; rows that do not fill a chunk wait in memory.

    A flush writes the waiting rows too, as a chunk that is written again when it is full: so the files of a finished
    store do not depend on when it was flushed.
    """

    def __init__(self, group: Any, chunk: int):
        self.arrays = dict(group.arrays())
        self.chunk, self.written, self.waiting = chunk, 0, 0  # rows in full chunks, rows in memory
        self.buffers = {name: np.empty((chunk, *array.shape[1:]), array.dtype) for name, array in self.arrays.items()}
        self.unflushed = False

    @classmethod
    def created(cls, root: Any, name: str, columns: dict[str, "Column"], chunk: int) -> "Appender":
        """A new group whose arrays have the columns' names, types and attributes, and no rows."""
        from zarr.codecs import Crc32cCodec, ZstdCodec

        group = root.create_group(name)
        for key, column in columns.items():
            group.create_array(
                key,
                shape=(0, *column.values.shape[1:]),
                dtype=column.values.dtype,
                chunks=(chunk, *column.values.shape[1:]),
                dimension_names=column.dims,
                attributes=column.attrs,
                fill_value=np.nan if column.values.dtype.kind == "f" else 0,
                compressors=[ZstdCodec(level=0), Crc32cCodec()],  # a truncated or damaged chunk is an error to read
            )
        return cls(group, chunk)

    @property
    def rows(self) -> int:
        """How many rows were appended."""
        return self.written + self.waiting

    def append(self, columns: dict[str, "Column"]) -> None:
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
        """Writes the rows that wait."""
        if self.unflushed and self.waiting:
            self._write(self.waiting)
        self.unflushed = False

    def _write(self, count: int) -> None:
        end = self.written + count
        for name, array in self.arrays.items():
            if array.shape[0] < end:
                array.resize((end, *array.shape[1:]))
            array[self.written : end] = self.buffers[name][:count]

    def mark(self, name: str, rows: list[int]) -> None:
        """Sets a column of flags to true in some rows, written or waiting."""
        waiting = [row - self.written for row in rows if row >= self.written]
        self.buffers[name][waiting] = True
        self.unflushed = self.unflushed or bool(waiting)
        older = [row for row in rows if row < self.written]
        if older:
            self.arrays[name].set_coordinate_selection(np.array(older), np.ones(len(older), dtype=bool))

    def cut(self, rows: int) -> None:
        """Cuts the arrays to the rows that a checkpoint acknowledges."""
        for name, array in self.arrays.items():
            if array.shape[0] < rows:
                raise StoreError(f"`{name}` must hold the {rows} acknowledged rows, but has {array.shape[0]}.")
            array.resize((rows, *array.shape[1:]))

    def reload(self, rows: int) -> None:
        """Takes the rows that do not fill a chunk back into memory."""
        self.written = rows // self.chunk * self.chunk
        self.waiting = rows - self.written
        for name, array in self.arrays.items():
            self.buffers[name][: self.waiting] = array[self.written : rows]
        self.unflushed = True


def verify(group: Any) -> None:
    """Reads every chunk of a group. Raises StoreError, which names the array and the rows that cannot be read."""
    for _, array in group.arrays():
        chunk = array.chunks[0]
        for start in range(0, array.shape[0], chunk):
            try:
                if not array.store_path.store.root.joinpath(array.store_path.path, _chunk_file(array, start)).is_file():
                    raise OSError("the file of the chunk is missing")
                array[start : start + chunk]
            except Exception as error:  # codecs raise what they like
                end = min(start + chunk, array.shape[0])
                raise StoreError(f"`{array.path}` must be readable in rows {start} to {end}, but: {error}.") from None


def _chunk_file(array: Any, start: int) -> str:
    """The name of the file of the chunk that begins at row `start`, below the array's folder."""
    return "/".join(["c", str(start // array.chunks[0]), *("0" for _ in array.shape[1:])])


def replace_text(path: Path, text: str) -> None:
    """Writes a file whole or not at all, also if the machine loses power."""
    scratch = path.with_name(f".{path.name}.part")
    with open(scratch, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(scratch, path)


def sweep(folder: Path) -> None:
    """Removes the scratch files that a killed writer leaves: zarr's and our own."""
    for pattern in ("*.partial", ".*.part"):
        for path in folder.rglob(pattern):
            path.unlink()


def finite(value: Any) -> Any:
    """The value as JSON can hold it: numbers that are not finite become None."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def attributes(path: str | Path) -> dict[str, Any]:
    """Root attributes of a store. Raises StoreError if there is none of ours."""
    place = Path(path)
    try:
        found = json.loads((place / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        if found["format"] != FORMAT:
            raise KeyError("format")
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = "does not exist" if not place.exists() else "is none" if not isinstance(error, OSError) else str(error)
        raise StoreError(f"`{path}` must be a store of tippetop, but {why}.") from None
    if found.get("format_version") != FORMAT_VERSION:
        raise StoreError(
            f"`{path}` must have format version {FORMAT_VERSION}, but has {found.get('format_version')}: "
            "use the release that wrote it."
        )
    return found


def open_group(path: str | Path, group: str) -> "xr.Dataset":
    """A group of a store as a labelled Dataset, read when needed. Raises StoreError."""
    import xarray as xr

    attrs = attributes(path)
    try:
        return xr.open_zarr(Path(path), group=group, consolidated=False, chunks=None).assign_attrs(attrs)
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


@lru_cache
def versions() -> dict[str, str]:
    """Versions of what a result depends on."""
    found = {"python": platform.python_version()}
    for name in ("tippetop", "heyoka", "numpy", "zarr"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


@lru_cache
def cpu() -> str:
    """The model of this machine's processor: results are bit-identical only on the same one."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def provenance() -> dict[str, Any]:
    """What every store says of its making."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "Conventions": "CF-1.11",
        "versions": versions(),
        "cpu": cpu(),
        "threads": 1,
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors",
    }

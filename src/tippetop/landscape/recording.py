"""Landscapes on disk. Surfaces beyond memory go to zarr chunk by chunk, resumable: the store knows what is done.

Until the last chunk is written the store is a hidden folder beside its place, `.NAME.part`; a second call with the same
body and axes continues where the first stopped. A chunk is done when the digest of its files is there: it is written
last, in the folder `digests`, which goes when the surface is whole.
"""

import hashlib
import itertools
import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..store import chunks, files, seal, skeleton, tables, zarr3
from ..store.chunks import Appender, chunk_file, readable
from ..store.lock import LOCK, Lock
from ..store.provenance import provenance
from ..store.root import finish, new_store
from ..store.seal import DOCUMENT
from . import body as bodies
from . import labels, surface


CHUNK = 1024  # rows and columns: 8 MB a variable
GROUP = "surface"
OVER_AXES = ("F", "z", "status")
DIGESTS = "digests"  # the folder of an unfinished store: a file for each chunk that is done


@dataclass(frozen=True)
class Surface:
    """A minimal surface F [J] over x times y, the momenta of a body, in chunks of so many rows and columns."""

    top: bodies.Top
    x: np.ndarray
    y: np.ndarray
    chunk: int = CHUNK

    @classmethod
    def over(
        cls, parameters: Mapping[str, float], x: Any, y: Any, system: str = "tippe-top", *, chunk: int = CHUNK
    ) -> "Surface":
        """The surface of a body. Raises ValueError for axes that are empty or do not ascend."""
        top = bodies.top(parameters, system)
        return cls(top, labels.axis(top.momenta[0], x), labels.axis(top.momenta[1], y), chunk)

    def axes(self) -> dict[str, Column]:
        """The axes as columns."""
        return {
            m.symbol: Column((m.symbol,), values, {"units": m.unit.symbol, "long_name": m.long_name})
            for m, values in zip(self.top.landscape.momenta, (self.x, self.y), strict=True)
        }

    def blocks(self) -> Iterator[tuple[int, int]]:
        """The first row and column of every chunk."""
        return itertools.product(range(0, self.x.size, self.chunk), range(0, self.y.size, self.chunk))

    def attributes(self) -> dict[str, Any]:
        """The root attributes of the store."""
        return {
            "content": GROUP,
            "title": "minimal surface F = inf V",
            "system": self.top.system.name,
            "parameters": self.top.parameters,
            "axes": {
                name: [float(v.values[0]), float(v.values[-1]), int(v.values.size)] for name, v in self.axes().items()
            },
            "chunk": self.chunk,
            **provenance(),
        }


def write(
    path: str | Path,
    wanted: Surface,
    *,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Writes F [J], z and status of a surface into the group `surface` of a new store at `path`.

    Parameters
    ----------
    path
        The store.
    wanted
        The surface.
    threads
        How many compute; all cores if None.
    progress
        Called as progress(done, of), which count chunks.

    Returns
    -------
    Path
        Of the store.

    Raises
    ------
    StoreError
        If `path` exists or cannot be written, or an unfinished store beside it is another surface.

    Notes
    -----
    17 bytes a point before compression; memory: some 40 bytes a point of one chunk. progress(done, of) is called after
    every chunk. Raises StoreError if `path` exists, or cannot be written, or an unfinished store beside it is another
    surface.
    """
    path = Path(path)
    files.refuse_inside(path)
    if os.path.lexists(path):
        raise StoreError(f"`{path}` must not exist yet, but does.")
    scratch = path.with_name(f".{path.name}.part")  # the same name in every process: what one began, another continues
    with files.writing(path):
        fresh = not files.own_folder(scratch).exists()
        scratch.mkdir(parents=True, exist_ok=True)
        if scratch.lstat().st_uid != os.geteuid():  # its name can be guessed
            raise StoreError(f"`{scratch}` must be yours, but another user made it.")
        with Lock(scratch) as lock:
            arrays = _created(scratch, wanted) if fresh else _opened(scratch, wanted)
            blocks, whole = list(wanted.blocks()), not fresh and _is_whole(scratch)
            (scratch / DIGESTS).mkdir(exist_ok=True)
            for done, (i, j) in enumerate(blocks, 1):
                if fresh or not (whole or _sound(scratch, arrays, i, j)):
                    _fill(arrays, wanted, slice(i, i + wanted.chunk), slice(j, j + wanted.chunk), threads)
                    arrays["F"].store_path.store.sync()  # before it is acknowledged
                    files.replace_text(_record(scratch, i, j), _digest(arrays, i, j))
                if progress is not None:
                    progress(done, len(blocks))
            files.remove_stale(path)
            lock.check()
            finish(scratch, {})
            shutil.rmtree(scratch / DIGESTS)
            lock.remove()
            files.synced(scratch)
            files.rename_new(scratch, path)
    return path


def write_potential(path: str | Path, V: Any, attrs: dict[str, Any]) -> None:
    """Writes the Dataset V of `potential` along z into the group `potential` of a new store. Raises StoreError."""
    columns = {
        str(name): Column(("z",), np.asarray(v), dict(v.attrs)) for name, v in V.variables.items() if v.dims == ("z",)
    }
    with new_store(path) as scratch:
        folder = chunks.create(scratch, {"content": "potential", **attrs, **provenance()})
        table = Appender.created(folder, "potential", columns, chunk=65536)
        table.append(columns)
        table.flush()
        folder.sync()
        finish(scratch, {})


def _sound(scratch: Path, arrays: dict[str, Any], i: int, j: int) -> bool:
    """Whether a chunk is done: it can be read, and its files are those of its digest."""
    try:
        if _record(scratch, i, j).read_text(encoding="utf-8") != _digest(arrays, i, j):
            return False
        for name in OVER_AXES:
            readable(arrays[name], i, j)
    except (OSError, ValueError, StoreError):
        return False
    return True


def _record(scratch: Path, i: int, j: int) -> Path:
    """Where the digest of a chunk is kept."""
    return scratch / DIGESTS / f"{i}-{j}"


def _digest(arrays: dict[str, Any], i: int, j: int) -> str:
    """A digest of what of a chunk is on the disk, and of its place. Raises OSError."""
    whole = hashlib.sha256(f"{i} {j}".encode())
    for name in OVER_AXES:
        whole.update(name.encode() + seal.checksum(chunk_file(arrays[name], i, j)))
    return whole.hexdigest()


def _is_whole(scratch: Path) -> bool:
    """Whether all was done when it was stopped: it has its seal, and what the seal says."""
    try:
        return seal.SEAL in skeleton.read(scratch)
    except StoreError:
        return False


def _created(scratch: Path, wanted: Surface) -> dict[str, Any]:
    """The arrays of an empty store: the axes, and arrays without a chunk. All that was there goes, but the lock."""
    for old in scratch.iterdir():
        if old.is_dir() and not old.is_symlink():
            shutil.rmtree(old)
        elif old.name != LOCK:
            old.unlink()
    with tables.every_chunk():
        group = tables.create_root(scratch, wanted.attributes()).create_group(GROUP)
        arrays: dict[str, Any] = {}
        for columns, sizes, fill in _tables(wanted):
            arrays |= tables.create_table(group, columns, sizes, fill=fill)
        for name, axis in wanted.axes().items():
            arrays[name][...] = axis.values
    return arrays


def _tables(wanted: Surface) -> list[tuple[dict[str, Column], dict[str, Any], dict[str, Any]]]:
    """Columns, sizes and fill values of the axes, and of what stands over them; `status` is made last."""
    from tippetop_kernels.minimise import Status

    axes, dims, none = wanted.axes(), wanted.top.momenta, np.zeros((0, 0))
    flags = {
        k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in labels.flags(Status, "how F is taken").items()
    }
    columns = {
        "F": Column(dims, none, dict(zip(("units", "long_name"), labels.NAMES["F"], strict=True))),
        "z": Column(dims, none, {"units": "1", "long_name": "z = cos(theta) where V is least"}),
        "status": Column(dims, none.astype(np.int8), flags),
    }
    sizes = {dim: (n, min(wanted.chunk, n)) for dim, n in zip(dims, (wanted.x.size, wanted.y.size), strict=True)}
    return [(axes, {}, dict.fromkeys(axes, 0)), (columns, sizes, {"status": -1})]


def _opened(scratch: Path, wanted: Surface) -> dict[str, Any]:
    """The arrays of an unfinished store of the same surface; what is no whole store of it is made anew."""
    try:
        skeleton.refuse_pipes(scratch)
        stored = json.loads((scratch / DOCUMENT).read_text(encoding="utf-8"))["attributes"]
        attributes = wanted.attributes()
        if any(stored[k] != attributes[k] for k in ("system", "parameters", "axes", "chunk", "format_version")):
            raise _Another
        expected: dict[str, Any] = {}
        for columns, sizes, fill in _tables(wanted):
            expected |= {name: zarr3.array(column, sizes, fill.get(name)) for name, column in columns.items()}
        skeleton.compare(scratch, GROUP, expected, rows=True)
        files.remove_scratch(scratch)
        arrays = tables.open_root(scratch, GROUP)[1][0]
        for name, axis in wanted.axes().items():
            if not np.array_equal(readable(arrays[name], 0), axis.values):
                raise _Another
        if {**stored, **attributes} != stored:  # words of it were changed, or versions: it is begun again
            return _created(scratch, wanted)
    except _Another:
        raise StoreError(f"`{scratch}` must be the same surface, unfinished, but is another: remove it.") from None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return _created(scratch, wanted)  # damaged, or killed before it held anything
    return arrays


class _Another(Exception):
    """What is there is another surface."""


def _fill(arrays: dict[str, Any], wanted: Surface, rows: slice, columns: slice, threads: int | None) -> None:
    """Computes and writes one chunk, the status last."""
    for name, values in _values(wanted, rows, columns, threads=threads).items():
        arrays[name][rows, columns] = values


def _values(wanted: Surface, rows: Any, columns: Any, *, threads: int | None) -> dict[str, np.ndarray]:
    """F, z and status at some rows and columns, in the order in which they are written."""
    F, q, status = surface.minima(wanted.top, wanted.x[rows], wanted.y[columns], threads)
    return {"F": F, "z": surface.argmin(q, status, wanted.top.upright)[0], "status": status}

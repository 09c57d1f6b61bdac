"""Landscapes on disk. Surfaces beyond memory go to zarr chunk by chunk, resumable: the store knows what is done.

Until the last chunk is written the store is a hidden folder beside its place, `.NAME.part`; a second call with the same
body and axes goes on where the first stopped. A chunk is done when its `status` is there: it is written last.
"""

import itertools
import json
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from ..store.chunks import Appender
from ..store.files import LOCK, locked, sweep
from ..store.provenance import provenance
from ..store.root import new_store
from . import body as bodies
from . import labels, surface


CHUNK = 1024  # rows and columns: 8 MB a variable


def write(
    path: str | Path,
    parameters: Mapping[str, float],
    first: Any,
    second: Any,
    system: str = "tippe-top",
    *,
    chunk: int = CHUNK,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Writes F [J], z and status over first x second into the group `surface` of a new store at `path`.

    17 bytes a point before compression; memory: some 40 bytes a point of one chunk. progress(done, of) is called after
    every chunk. Raises StoreError if `path` exists, or cannot be written, or an unfinished store beside it is another
    surface; ValueError for axes that are empty or do not ascend.
    """
    import zarr

    t, path = bodies.top(parameters, system), Path(path)
    x, y = labels.axis(t.momenta[0], first), labels.axis(t.momenta[1], second)
    if path.exists():
        raise StoreError(f"`{path}` must not exist yet, but does.")
    scratch = path.with_name(f".{path.name}.part")
    lock = -1
    try:
        fresh = not scratch.exists()
        scratch.mkdir(parents=True, exist_ok=True)
        lock = locked(scratch)
        group = _created(scratch, t, x, y, chunk) if fresh else _opened(scratch, t, x, y, chunk)
        blocks = list(itertools.product(range(0, x.size, chunk), range(0, y.size, chunk)))
        for done, (i, j) in enumerate(blocks, 1):
            if not (scratch / "surface" / "status" / "c" / str(i // chunk) / str(j // chunk)).exists():
                _fill(group, t, x, y, slice(i, i + chunk), slice(j, j + chunk), threads)
            if progress is not None:
                progress(done, len(blocks))
        (scratch / LOCK).unlink()
        os.replace(scratch, path)
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        raise StoreError(f"`{path}` must be writable, but: {error.strerror or error}.") from error
    except zarr.errors.BaseZarrError as error:
        raise StoreError(f"`{scratch}` must be readable, but: {error}: remove it.") from error
    finally:
        if lock >= 0:
            os.close(lock)
    return path


def write_potential(path: str | Path, V: Any, attrs: dict[str, Any]) -> None:
    """Writes the Dataset V of `potential` along z into the group `potential` of a new store. Raises StoreError."""
    import zarr

    columns = {
        str(name): Column(("z",), np.asarray(v), dict(v.attrs)) for name, v in V.variables.items() if v.dims == ("z",)
    }
    with new_store(path) as scratch:
        root = zarr.open_group(
            store=str(scratch), mode="w", zarr_format=3, attributes={"content": "potential", **attrs, **provenance()}
        )
        table = Appender.created(root, "potential", columns, chunk=65536)
        table.append(columns)
        table.flush()


def _attributes(t: bodies.Top, x: np.ndarray, y: np.ndarray, chunk: int) -> dict[str, Any]:
    return {
        "content": "surface",
        "title": "minimal surface F = inf V",
        "system": t.system.name,
        "parameters": t.parameters,
        "axes": {n: [float(v[0]), float(v[-1]), int(v.size)] for n, v in zip(t.momenta, (x, y), strict=True)},
        "chunk": chunk,
        **provenance(),
    }


def _created(scratch: Path, t: bodies.Top, x: np.ndarray, y: np.ndarray, chunk: int) -> Any:
    """An empty store: the axes, and arrays without a chunk. All that was there goes, but the lock."""
    import zarr

    from tippetop_kernels.minimise import Status

    for old in scratch.iterdir():
        if old.is_dir():
            shutil.rmtree(old)
        elif old.name != LOCK:
            old.unlink()
    root = zarr.open_group(store=str(scratch), mode="a", zarr_format=3, attributes=_attributes(t, x, y, chunk))
    group = root.create_group("surface")
    for m, values in zip(t.landscape.momenta, (x, y), strict=True):
        axis = group.create_array(
            m.symbol,
            shape=values.shape,
            dtype=values.dtype,
            chunks=values.shape,
            dimension_names=(m.symbol,),
            attributes={"units": m.unit.symbol, "long_name": m.long_name},
        )
        axis[...] = values
    flags = {
        k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in labels.flags(Status, "how F is taken").items()
    }
    described = {
        "F": ("f8", np.nan, dict(zip(("units", "long_name"), labels.NAMES["F"], strict=True))),
        "z": ("f8", np.nan, {"units": "1", "long_name": "z = cos(theta) where V is least"}),
        "status": ("i1", -1, flags),
    }
    for name, (kind, fill, attributes) in described.items():
        group.create_array(
            name,
            shape=(x.size, y.size),
            dtype=kind,
            chunks=(min(chunk, x.size), min(chunk, y.size)),
            dimension_names=t.momenta,
            attributes=attributes,
            fill_value=fill,
        )
    return group


def _opened(scratch: Path, t: bodies.Top, x: np.ndarray, y: np.ndarray, chunk: int) -> Any:
    """An unfinished store of the same surface."""
    import zarr

    try:
        found = json.loads((scratch / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        group: Any = zarr.open_group(store=str(scratch), mode="r+")["surface"]
        wanted = _attributes(t, x, y, chunk)
        sweep(scratch)
        same = all(found[k] == wanted[k] for k in ("system", "parameters", "axes", "chunk", "format_version"))
        same = same and all(np.array_equal(np.asarray(group[n]), v) for n, v in zip(t.momenta, (x, y), strict=True))
        group["status"]
    except (OSError, ValueError, KeyError):
        return _created(scratch, t, x, y, chunk)  # killed before it held anything
    if not same:
        raise StoreError(f"`{scratch}` must be the same surface, unfinished, but is another: remove it.")
    return group


def _fill(
    group: Any, t: bodies.Top, x: np.ndarray, y: np.ndarray, rows: slice, columns: slice, threads: int | None
) -> None:
    """Computes and writes one chunk, the status last."""
    F, q, status = surface.minima(t, x[rows], y[columns], threads)
    group["F"][rows, columns] = F
    group["z"][rows, columns] = surface.argmin(q, status, t.upright)[0]
    group["status"][rows, columns] = status

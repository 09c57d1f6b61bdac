"""A store in the formats of others: netCDF, CSV, Parquet; a block of rows at a time, whole or not
at all.
"""

import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, StoreError, missing_extra
from . import chunks, files, root


DIMENSIONS = {
    "trajectory": "time",
    "events": "event",
    "phases": "interval",
    "impacts": "impact",
    "sweep": "top",
    "sensitivities": "time",
    "event_sensitivities": "event",
}


def export(
    store: Path, to: str, out: Path, group: str | None = None, *, overwrite: bool = False
) -> None:
    """Writes a store as one file.

    The group that is named; without one netCDF takes all, CSV and Parquet the first. What is there
    already is replaced if it may be overwritten.

    Raises InputError for an unknown format, StoreError for what cannot be read, written, or lacks
    its library.
    """
    if to not in FORMATS:
        raise InputError(
            [f"--to must be one of {', '.join(FORMATS)}, or for a body mjcf, urdf, but is `{to}`."]
        )
    attrs = root.attributes(store)
    groups = [name for name in root.groups_of(store) if name != "keyframes"]
    if not DIMENSIONS.keys() >= set(groups):
        raise StoreError(
            f"`{store}` must be a run or a sweep to be exported, but is a {groups[0]}."
        )
    if group not in (None, *groups):
        raise InputError([f"--group must be {' or '.join(groups)}, but is `{group}`."])
    if to != "netcdf" and group is None and groups[0] == "trajectory" and not _has_rows(store):
        others = " or ".join(groups[1:])
        raise InputError(
            [
                f"`{store}` must have rows to be exported, but has none: say --group {others}, "
                "or replay it."
            ]
        )
    if attrs["status"] == "running":
        warnings.warn(
            f"`{store}` is not finished: what is written is what there is of it so far.",
            stacklevel=2,
        )
    try:
        with files.writing(out), files.replacing(out, overwrite=overwrite) as scratch:
            writer = _netcdf_apart if to == "netcdf" else FORMATS[to]
            writer(
                store,
                groups if group is None and to == "netcdf" else [group or groups[0]],
                attrs,
                scratch,
            )
    except ImportError as error:
        if (sentence := missing_extra(error)) is None:
            raise
        raise InputError([sentence]) from None


def _has_rows(store: Path) -> bool:
    """Whether the trajectory of a run has any."""
    return all(array.shape[0] for array in chunks.read_member(store, "trajectory").values())


def _netcdf_apart(store: Path, groups: list[str], attrs: dict[str, Any], path: Path) -> None:
    """As `_netcdf`, in a process of its own: HDF5 ends its process by a segmentation fault when the
    disk is full. Raises OSError.
    """
    import h5netcdf  # noqa: F401 - missing is a sentence here

    given = json.dumps([sys.path, str(store), groups, attrs, str(path)])
    child = subprocess.run(
        [sys.executable, "-c", APART], input=given, capture_output=True, text=True, check=False
    )
    if child.returncode < 0:
        raise OSError(
            f"HDF5 failed there (signal {-child.returncode}), as it does when the disk is full"
        )
    if child.returncode > 0:
        raise OSError(child.stderr.strip().rpartition("\n")[2] or "HDF5 failed there")


APART = """import json, os, pathlib, sys
sys.path[:], store, groups, attrs, path = json.load(sys.stdin)
from tippetop.store.export import _netcdf
try:
    _netcdf(pathlib.Path(store), groups, attrs, pathlib.Path(path))
except OSError as error:  # the words of h5py take some lines
    sys.exit(os.strerror(error.errno) if error.errno else str(error))"""


def _netcdf(store: Path, groups: list[str], attrs: dict[str, Any], path: Path) -> None:
    import h5netcdf

    with h5netcdf.File(path, "w") as file:
        file.attrs.update(
            {name: _plain(value) for name, value in attrs.items() if value is not None}
        )
        for name in groups:
            arrays = chunks.read_member(store, name)
            group, dim = file.create_group(name), DIMENSIONS[name]
            group.dimensions[dim] = min(array.shape[0] for array in arrays.values())
            for array in arrays.values():
                metadata: Any = array.metadata
                for extra, size in zip(metadata.dimension_names[1:], array.shape[1:], strict=True):
                    if extra not in group.dimensions:
                        group.dimensions[extra] = size
            for key, array in arrays.items():
                kind = "i1" if array.dtype == bool else array.dtype
                metadata = array.metadata
                variable = group.create_variable(
                    key, metadata.dimension_names, kind, compression="gzip"
                )
                variable.attrs.update({k: _plain(v) for k, v in array.attrs.items()})
            start = 0
            for piece in chunks.pieces(store, name, list(arrays)):
                count = len(next(iter(piece.values())))
                for key, values in piece.items():
                    group.variables[key][start : start + count] = values
                start += count


def _csv(store: Path, groups: list[str], attrs: dict[str, Any], path: Path) -> None:
    arrays = chunks.read_member(store, groups[0])
    heads = {part: head for name, array in arrays.items() for part, head in _heads(name, array)}
    for i, table in enumerate(_tables(store, groups[0], attrs)):
        header = False if i else [heads[name] for name in table]
        table.to_csv(path, mode="a" if i else "w", header=header, index=False, float_format="%.17g")


def _heads(name: str, array: Any) -> Iterator[tuple[str, str]]:
    """Yield each component of a column and its header: name and unit, as `exchange` reads them."""
    unit = str(array.attrs.get("units", "1"))
    bare = (
        unit in ("", "1") or "parameters" in array.attrs
    )  # derivatives: by each parameter another unit
    for part in _parts(name, array):
        yield part, part if bare else f"{part} [{unit}]"


def _parquet(store: Path, groups: list[str], attrs: dict[str, Any], path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    try:
        for table in _tables(store, groups[0], attrs):
            arrow = pa.Table.from_pandas(table, preserve_index=False)
            if writer is None:
                meta = {
                    name: str(_plain(value)) for name, value in attrs.items() if value is not None
                }
                writer = pq.ParquetWriter(path, arrow.schema.with_metadata(meta))
            writer.write_table(arrow.replace_schema_metadata(writer.schema.metadata))
    finally:
        if writer is not None:
            writer.close()


def _tables(store: Path, group: str, attrs: dict[str, Any]) -> Iterator[Any]:
    """The rows as pandas tables, vectors by their components, flags by their meanings; at least one
    table.
    """
    import pandas as pd

    arrays = chunks.read_member(store, group)
    parts = {name: _parts(name, array) for name, array in arrays.items() if array.ndim > 1}
    meanings = {
        name: str(array.attrs.get("flag_meanings", "")).split() for name, array in arrays.items()
    }
    first = (
        attrs["coordinates"] + attrs["columns"] if group == "sweep" else ["time", "start", "end"]
    )
    names = sorted(
        arrays, key=lambda name: (first.index(name) if name in first else len(first), name)
    )
    empty = True
    for piece in chunks.pieces(store, group, names):
        columns: dict[str, Any] = {}
        for name in names:
            values = piece[name]
            if values.ndim > 1:
                columns |= dict(zip(parts[name], values.reshape(len(values), -1).T, strict=True))
            else:
                columns[name] = np.array(meanings[name])[values] if meanings[name] else values
        empty = False
        yield pd.DataFrame(columns)
    if empty:
        yield pd.DataFrame({column: [] for name in names for column in parts.get(name, [name])})


def _parts(name: str, array: Any) -> list[str]:
    """The names of the components of a column: of a vector by its letters, of a derivative by its
    numbers too.
    """
    letters = [
        f"{name}_{axis}"
        for dim in array.metadata.dimension_names[1:]
        if dim != "parameter"
        for axis in dim
    ] or [name]
    by = str(array.attrs.get("parameters", "")).split()
    return [f"d_{letter}/d_{number}" for number in by for letter in letters] if by else letters


def _plain(value: Any) -> Any:
    """An attribute as netCDF and Parquet can hold it."""
    return (
        value
        if isinstance(value, int | float | str) and not isinstance(value, bool)
        else json.dumps(value)
    )


FORMATS: dict[str, Callable[[Path, list[str], dict[str, Any], Path], None]] = {
    "netcdf": _netcdf,
    "csv": _csv,
    "parquet": _parquet,
}

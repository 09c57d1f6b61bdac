"""A store in the formats of others: netCDF, CSV, Parquet; a stretch of rows at a time, whole or not at all."""

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from . import archive, chunks
from .archive import StoreError
from .scenario import ScenarioError


def export(store: Path, to: str, out: Path, group: str = "trajectory") -> None:
    """Writes a store as one file. netCDF takes both groups; CSV and Parquet take the one that is named.

    Raises ScenarioError for an unknown format, StoreError for what cannot be read, written, or lacks its library.
    """
    if to not in FORMATS:
        raise ScenarioError([f"--to must be one of {', '.join(FORMATS)}, but is `{to}`."])
    if group not in ("trajectory", "events"):
        raise ScenarioError([f"--group must be trajectory or events, but is `{group}`."])
    attrs = archive.attributes(store)
    if out.exists():
        raise StoreError(f"`{out}` must not exist yet, but does.")
    scratch = out.with_name(f".{out.name}.part")
    try:
        FORMATS[to](store, group, attrs, scratch)
        os.replace(scratch, out)
    except ImportError as error:
        raise StoreError(
            f"the export to {to} must find its library, but: {error} (install tippetop[export])."
        ) from None
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        raise StoreError(f"`{out}` must be writable, but: {error.strerror or error}.") from None
    finally:
        with contextlib.suppress(OSError):
            scratch.unlink()


def _netcdf(store: Path, _: str, attrs: dict[str, Any], path: Path) -> None:
    import h5netcdf
    import zarr

    with h5netcdf.File(path, "w") as file:
        file.attrs.update({name: _plain(value) for name, value in attrs.items() if value is not None})
        for name in ("trajectory", "events"):
            arrays = dict(zarr.open_group(store=str(store), mode="r", path=name).arrays())
            group, dim = file.create_group(name), "time" if name == "trajectory" else "event"
            group.dimensions[dim] = min(array.shape[0] for array in arrays.values())
            if name == "trajectory":
                group.dimensions["xyz"] = 3
            for key, array in arrays.items():
                kind = "i1" if array.dtype == bool else array.dtype
                metadata: Any = array.metadata
                variable = group.create_variable(key, metadata.dimension_names, kind, compression="gzip")
                variable.attrs.update({k: _plain(v) for k, v in array.attrs.items()})
            start = 0
            for piece in chunks.pieces(store, name, list(arrays)):
                count = len(next(iter(piece.values())))
                for key, values in piece.items():
                    group.variables[key][start : start + count] = values
                start += count


def _csv(store: Path, group: str, _: dict[str, Any], path: Path) -> None:
    for i, table in enumerate(_tables(store, group)):
        table.to_csv(path, mode="a" if i else "w", header=not i, index=False, float_format="%.17g")


def _parquet(store: Path, group: str, attrs: dict[str, Any], path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    try:
        for table in _tables(store, group):
            arrow = pa.Table.from_pandas(table, preserve_index=False)
            if writer is None:
                meta = {name: str(_plain(value)) for name, value in attrs.items() if value is not None}
                writer = pq.ParquetWriter(path, arrow.schema.with_metadata(meta))
            writer.write_table(arrow.replace_schema_metadata(writer.schema.metadata))
    finally:
        if writer is not None:
            writer.close()


def _tables(store: Path, group: str) -> Iterator[Any]:
    """The rows as pandas tables, vectors as three columns, kinds of events by name; at least one table."""
    import pandas as pd
    import zarr

    from .events import KINDS

    names = sorted(
        dict(zarr.open_group(store=str(store), mode="r", path=group).arrays()), key=lambda n: (n != "time", n)
    )
    empty = True
    for piece in chunks.pieces(store, group, names):
        columns: dict[str, Any] = {}
        for name in names:
            values = piece[name]
            if values.ndim == 2:
                columns |= {f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")}
            else:
                columns[name] = np.array(KINDS)[values] if name == "kind" else values
        empty = False
        yield pd.DataFrame(columns)
    if empty:
        yield pd.DataFrame({name: [] for name in names})


def _plain(value: Any) -> Any:
    """An attribute as netCDF and Parquet can hold it."""
    import json

    return value if isinstance(value, int | float | str) and not isinstance(value, bool) else json.dumps(value)


FORMATS: dict[str, Callable[[Path, str, dict[str, Any], Path], None]] = {
    "netcdf": _netcdf,
    "csv": _csv,
    "parquet": _parquet,
}

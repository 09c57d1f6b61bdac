"""Write a store as one netCDF, CSV or Parquet file, whole or not at all."""

import contextlib
import json
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, StoreError
from . import chunks, files, root


FORMATS = "netcdf", "csv", "parquet"


def export(
    store: Path, to: str, out: Path, group: str | None = None, *, overwrite: bool = False
) -> None:
    """Write a store as one file. Without `group`, netCDF contains all, other formats the first.

    Raises InputError for an unknown format or group, StoreError where reading or writing fails.
    """
    if to not in FORMATS:
        raise InputError(
            f"--to must be one of {', '.join(FORMATS)}, or for a body mjcf, urdf, but is `{to}`."
        )
    attrs = root.attributes(store)
    groups = [name for name in root.groups_of(store) if name != "keyframes"]
    if attrs.get("content") in ("surface", "potential"):
        raise StoreError(
            f"`{store}` must be a run or a sweep to be exported, but is a {groups[0]}."
        )
    if group not in (None, *groups):
        raise InputError(f"--group must be {' or '.join(groups)}, but is `{group}`.")
    tables = {name: root.open_group(store, name) for name in ([group] if group else groups)}
    first = next(iter(tables))
    if to != "netcdf" and group is None and first == "trajectory" and not tables[first].time.size:
        raise InputError(
            f"`{store}` must have rows to be exported, but has none: use --group "
            f"{' or '.join(groups[1:])}, or replay it."
        )
    if attrs["status"] == "running":
        warnings.warn(
            f"`{store}` is not finished: only the rows up to its last commit are written.",
            stacklevel=2,
        )
    attrs = {name: _plain(value) for name, value in attrs.items() if value is not None}
    with files.writing(out), files.replacing(out, overwrite=overwrite) as scratch:
        if to == "netcdf":
            scratch.write_bytes(_netcdf(tables, attrs, store))
        else:
            table = tables[first]
            if to == "csv":
                _csv(_frames(table, store), scratch, table)
            else:
                _parquet(_frames(table, store), scratch, attrs)


def _netcdf(tables: dict[str, Any], attrs: dict[str, str], store: Path) -> Any:
    """Return the bytes of a netCDF file: HDF5 crashes where it writes to a full disk itself."""
    import h5netcdf  # noqa: F401 - a missing one is reported by name
    import xarray as xr

    tree = {"/": xr.Dataset(attrs=attrs)}
    for name, table in tables.items():
        tree[name] = root.loaded(table.drop_attrs(deep=False), store)
        for variable in tree[name].variables.values():
            variable.attrs = {key: _plain(value) for key, value in variable.attrs.items()}
            variable.encoding = {"zlib": True} if variable.dtype.kind != "U" else {}
    return xr.DataTree.from_dict(tree).to_netcdf(engine="h5netcdf")


def _csv(frames: Iterator[Any], path: Path, table: Any) -> None:
    heads: dict[str, str] = {}
    for name, variable in table.variables.items():
        units = variable.attrs.get("units", "1")
        bare = units in ("", "1")
        heads |= {part: part if bare else f"{part} [{units}]" for part in _parts(name, variable)}
    with path.open("w") as file:
        for i, frame in enumerate(frames):
            named = frame.rename(columns=heads)
            named.to_csv(file, header=not i, index=False, float_format="%.17g")


def _parquet(frames: Iterator[Any], path: Path, attrs: dict[str, str]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    about = {name: str(value) for name, value in attrs.items()}
    with contextlib.ExitStack() as stack:
        writer: Any = None
        for frame in frames:
            arrow = pa.Table.from_pandas(frame, preserve_index=False).replace_schema_metadata(about)
            writer = writer or stack.enter_context(pq.ParquetWriter(path, arrow.schema))
            writer.write_table(arrow)


def _frames(table: Any, store: Path) -> Iterator[Any]:
    """Yield the rows as pandas tables: components of vectors, and names of flags."""
    import pandas as pd

    first = [*table.attrs.get("coordinates", ()), *table.attrs.get("columns", ())]
    order = dict.fromkeys([*first, "time", "start", "end", *sorted(table.variables)])
    dim = chunks.row_dimension(table)
    names = [name for name in order if name in table and table[name].dims[0] == dim]
    for piece in chunks.blocks(table, store):
        columns: dict[str, Any] = {}
        for name in names:
            values, meanings = piece[name].values, piece[name].attrs.get("flag_meanings", "")
            if meanings:
                values = np.array(meanings.split())[values]
            parts = values.reshape(len(values), int(np.prod(values.shape[1:])))
            columns |= dict(zip(_parts(name, piece[name]), parts.T, strict=True))
        yield pd.DataFrame(columns)


def _parts(name: Any, variable: Any) -> list[str]:
    """Return the names of the components of a column: letters of a vector, or numbers."""
    return [f"{name}_{axis}" for dim in variable.dims[1:] for axis in dim] or [name]


def _plain(value: Any) -> Any:
    """Return an attribute in a form that netCDF and Parquet can hold."""
    plain = isinstance(value, int | float | str) and not isinstance(value, bool)
    return value if plain else json.dumps(value)

"""Write tables as one netCDF, CSV or Parquet file, whole or not at all.

Lazy Datasets of a run or a store go in; a file comes out.
"""

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..arguments import PlainData
from ..columns import dataframe, plain_attributes
from ..errors import InputError
from . import chunks, files, root


ENDINGS = {".nc": "netcdf", ".csv": "csv", ".parquet": "parquet", ".pq": "parquet"}


def export(
    tables: dict[str, Any],
    attrs: PlainData,
    of: str,
    to: str,
    out: Path,
    group: str | None = None,
    *,
    overwrite: bool = False,
) -> None:
    """Write tables as one file. Without `group`, netCDF contains all, other formats the first.

    Parameters
    ----------
    tables
        Datasets by name, in memory or read when needed.
    attrs
        The attributes of the file, those of the root of a store.
    of
        The source of the tables in messages: a store, or the run.
    to
        netcdf, csv or parquet.
    out
        The file.
    group
        The only table to write.
    overwrite
        Whether an existing file is replaced.

    Raises
    ------
    InputError
        For an unknown format or group.
    StoreError
        If reading or writing fails.
    """
    if to not in ENDINGS.values():
        raise InputError(
            "--to must be one of netcdf, csv, parquet, or for a body mjcf, urdf, sdf, but is "
            f"`{to}`."
        )
    if group not in (None, *tables):
        raise InputError(f"--group must be {' or '.join(tables)}, but is `{group}`.")
    first, *others = tables
    if to != "netcdf" and group is None and first == "trajectory" and not tables[first].time.size:
        raise InputError(
            f"{of} must have rows to be exported, but has none: use --group "
            f"{' or '.join(others)}, or replay it."
        )
    if attrs["status"] == "running":
        warnings.warn(
            f"{of} is not finished: only the rows up to its last commit are written.",
            stacklevel=3,
        )
    tables = {group: tables[group]} if group else tables
    attrs = plain_attributes(attrs)
    with files.replacing(out, overwrite=overwrite) as scratch:
        if to == "netcdf":
            scratch.write_bytes(_netcdf(tables, attrs, of))
        elif to == "csv":
            _csv(tables[group or first], scratch, of)
        else:
            _parquet(tables[group or first], scratch, of, attrs)


def _netcdf(tables: dict[str, Any], attrs: dict[str, Any], of: str) -> Any:
    """Return the bytes of a netCDF file: HDF5 crashes where it writes to a full disk itself.

    A single table is its root group.
    """
    import h5netcdf  # noqa: F401 - a missing one is reported by name
    import xarray as xr

    tree = {"/": xr.Dataset()}
    for name, table in tables.items():
        table = root.loaded(table.drop_attrs(deep=False), of).drop_encoding()
        for variable in table.variables.values():
            variable.encoding = {"zlib": True} if variable.dtype.kind != "U" else {}
        tree[name if len(tables) > 1 else "/"] = table
    tree["/"].attrs = attrs
    return xr.DataTree.from_dict(tree).to_netcdf(engine="h5netcdf")


def _csv(table: Any, path: Path, of: str) -> None:
    """Write a Dataset as CSV, with units in its header; `of` names its source in messages."""

    def head(column: str) -> str:
        """Return the name of a column of the file with its unit: "theta [rad]".

        Columns with parts, such as axis_x, have the unit of the variable `axis`.
        """
        name = column if column in table else column.rpartition("_")[0]
        units = table[name].attrs.get("units", "1")
        return column if units in ("", "1") else f"{column} [{units}]"

    with path.open("w") as file:
        for i, frame in enumerate(_frames(table, of)):
            named = frame.rename(columns=head)
            named.to_csv(file, header=not i, index=False, float_format="%.17g")


def _parquet(table: Any, path: Path, of: str, attrs: PlainData) -> None:
    """Write a Dataset as Parquet, with `attrs` as its metadata; `of` names it in messages."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    about = {name: str(value) for name, value in attrs.items()}
    with contextlib.ExitStack() as stack:
        writer: Any = None
        for frame in _frames(table, of):
            arrow = pa.Table.from_pandas(frame, preserve_index=False).replace_schema_metadata(about)
            writer = writer or stack.enter_context(pq.ParquetWriter(path, arrow.schema))
            writer.write_table(arrow)


def _frames(table: Any, of: str) -> Iterator[Any]:
    """Yield the rows of a Dataset as pandas tables, a block at a time; times come first.

    Then columns are sorted by name, as a run in memory has them in another order than its store.
    `of` names the source in messages. Raises StoreError.
    """
    first = [name for name in ("top", "time", "start", "end") if name in table.variables]
    names = [*first, *sorted(table.variables.keys() - {*first})] if first else [*table.variables]
    for piece in chunks.blocks(table[names], of):
        frame = dataframe(piece)
        yield frame.reset_index(drop=frame.index.names[0] not in names)

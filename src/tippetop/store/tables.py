"""Groups and tables of a zarr store: how they are opened, and the one way in which a table is made."""

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..columns import Column
from ..errors import StoreError
from . import files


def codecs() -> list[Any]:
    """How a chunk becomes bytes: lz4 and shuffle, smaller and faster than zstd here; a checksum makes damage an error
    to read."""
    from zarr.codecs import BloscCodec, Crc32cCodec

    return [BloscCodec(cname="lz4", clevel=1, shuffle="shuffle"), Crc32cCodec()]


def create_root(folder: Path, attributes: dict[str, Any]) -> Any:
    """The root group of a new store."""
    import zarr

    from .own import OwnStore

    return zarr.open_group(store=OwnStore(folder), mode="a", zarr_format=3, attributes=attributes)


def every_chunk() -> Any:
    """A block in which arrays are made or opened so that a chunk of nothing but the fill value is written too: then its
    absence is damage."""
    import zarr

    return zarr.config.set({"array.write_empty_chunks": True})


def open_root(folder: Path, *members: str, write_empty: bool = True) -> tuple[Any, list[Any]]:
    """The root group of a store that is written, and members of it: arrays, or groups as dicts of arrays; see
    `every_chunk`. Raises StoreError if there is a link in it."""
    import zarr

    from .own import OwnStore

    files.refuse_links(folder)
    with every_chunk() if write_empty else contextlib.nullcontext():
        root: Any = zarr.open_group(store=OwnStore(folder), mode="r+", zarr_format=3)
        return root, [_opened(root[name]) for name in members]


def read_member(path: str | Path, name: str) -> Any:
    """An array of a store, or a group as a dict of arrays, to be read. Raises StoreError."""
    import zarr  # a run is written without

    try:
        return _opened(zarr.open(store=str(path), mode="r", path=name))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{name}`, but: {error}.") from None


def _opened(member: Any) -> Any:
    """An array, or the arrays of a group: in the order of their names, whatever order the disk lists them in."""
    return dict(sorted(member.arrays())) if hasattr(member, "arrays") else member


def create_table(
    group: Any,
    columns: Mapping[str, Column],
    sizes: Mapping[str, tuple[int, int]],
    *,
    fill: Mapping[str, Any] | None = None,
    compressors: Any = None,
) -> dict[str, Any]:
    """Makes an array for each column in a group; nothing is written into them.

    Parameters
    ----------
    group
        An open zarr group.
    columns
        Name -> column, which gives dimensions, type and attributes; its values are not written.
    sizes
        Dimension -> (length, length of a chunk). Any other dimension is as long as the column's values, in one chunk.
    fill
        Name -> what stands where nothing was written; otherwise NaN, or 0 where the type has none.
    compressors
        As zarr takes them; otherwise `codecs()`.

    Returns
    -------
    dict
        Name -> array.
    """
    fill = fill or {}
    arrays = {}
    for name, column in columns.items():
        own = [(n, max(n, 1)) for n in column.values.shape]
        each = [sizes.get(dim, size) for dim, size in zip(column.dims, own, strict=True)]
        arrays[name] = group.create_array(
            name,
            shape=tuple(length for length, _ in each),
            dtype=column.values.dtype,
            chunks=tuple(chunk for _, chunk in each),
            dimension_names=column.dims,
            attributes=column.attrs,
            fill_value=fill.get(name, np.nan if column.values.dtype.kind == "f" else 0),
            compressors=compressors or codecs(),
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    return arrays

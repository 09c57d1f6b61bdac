"""Groups and tables of a zarr store: how they are opened, and the one way in which a table is made."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..columns import Column
from ..errors import StoreError
from . import files
from .array import Array, Group, document_of, opened
from .place import Place


def create_root(folder: Path, attributes: dict[str, Any]) -> Group:
    """The root group of a new store."""
    return Group.created(Place(folder), "", attributes)


def open_root(folder: Path, *members: str) -> tuple[Group, list[Any]]:
    """The root group of a store that is written, and members of it: arrays, or groups as dicts of arrays. Raises
    StoreError if there is a link in it."""
    files.refuse_links(folder)
    place = Place(folder)
    return opened(place, ""), [_member(place, name) for name in members]


def read_member(path: str | Path, name: str) -> Any:
    """An array of a store, or a group as a dict of arrays, to be read. Raises StoreError."""
    try:
        return _member(Place(Path(path)), name)
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{name}`, but: {error}.") from None


def _member(place: Place, name: str) -> Any:
    member = opened(place, name)
    return member.arrays() if isinstance(member, Group) else member


def create_table(
    group: Group,
    columns: Mapping[str, Column],
    sizes: Mapping[str, tuple[int, int]],
    *,
    fill: Mapping[str, Any] | None = None,
) -> dict[str, Array]:
    """Makes an array for each column in a group, see `metadata`; nothing is written into them."""
    return {
        name: Array.created(group.place, group.key(name), document)
        for name, document in metadata(columns, sizes, fill).items()
    }


def metadata(
    columns: Mapping[str, Column], sizes: Mapping[str, tuple[int, int]], fill: Mapping[str, Any] | None = None
) -> dict[str, dict[str, Any]]:
    """Name -> metadata of the arrays of a table.

    Parameters
    ----------
    columns
        Name -> column, which gives dimensions, type and attributes; its values are not written.
    sizes
        Dimension -> (length, length of a chunk). Any other dimension is as long as the column's values, in one chunk.
    fill
        Name -> what stands where nothing was written; otherwise NaN, or 0 where the type has none.
    """
    documents = {}
    for name, column in columns.items():
        own = [(n, max(n, 1)) for n in column.values.shape]
        each = [sizes.get(dim, size) for dim, size in zip(column.dims, own, strict=True)]
        documents[name] = document_of(
            column, [length for length, _ in each], [chunk for _, chunk in each], (fill or {}).get(name)
        )
    return documents

"""The root attributes of a store: what it holds, and whether tippetop wrote it."""

import contextlib
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import path_of
from ..columns import with_coordinates
from ..errors import StoreError
from . import checkpoint, files, skeleton


if TYPE_CHECKING:
    import xarray as xr


def finite(value: Any) -> Any:
    """The value as JSON can hold it: numbers that are not finite become None."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def attributes(path: str | Path, *, whole: bool = True) -> dict[str, Any]:
    """Root attributes of a store whose skeleton is sound; of a run that is not finished, with what its checkpoint says
    of its end. Raises StoreError; see `skeleton.read`."""
    stored = skeleton.read(path, whole=whole)
    if "content" in stored or stored["status"] != "running":
        return stored
    try:
        record = checkpoint.read(Path(path), stored)
    except FileNotFoundError:  # it just finished, or never began: the root attributes stand
        return stored
    return stored | {"report": record["report"], "reason": record["reason"]}


def annotate(path: str | Path, more: dict[str, Any]) -> None:
    """Adds root attributes to a finished store."""
    _replace(path, lambda attrs: attrs | finite(more))


def replace_attributes(path: str | Path, attrs: dict[str, Any]) -> None:
    """Gives a store other root attributes, in one step."""
    _replace(path, lambda _: finite(attrs))


def _replace(path: str | Path, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    place = Path(path) / "zarr.json"
    content = json.loads(place.read_text(encoding="utf-8"))
    content["attributes"] = change(content["attributes"])
    with files.writing(place):
        files.replace_text(place, json.dumps(content, indent=2, allow_nan=False))


def open_group(path: str | Path, group: str) -> "xr.Dataset":
    """A group of a store as a labelled Dataset, read when needed; `tippetop.open` opens stores whole.

    Parameters
    ----------
    path : path-like
        The store.
    group : str
        trajectory or events, of a run; sweep; surface; potential.

    Returns
    -------
    xarray.Dataset
        In SI units, with the root attributes of the store.

    Raises
    ------
    StoreError
        If there is no such store or group.
    """
    import xarray as xr

    attrs = attributes(path_of("path", path))
    try:
        table = xr.open_zarr(Path(path), group=group, consolidated=False, chunks=None).assign_attrs(attrs)
        return with_coordinates(table)
    except (OSError, ValueError, KeyError, TypeError, MemoryError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


def loaded(dataset: Any, path: str | Path) -> Any:
    """A Dataset or DataArray of a store in memory. Raises StoreError where it cannot be read."""
    try:
        return dataset.load()
    except Exception as error:  # codecs raise what they like
        raise StoreError(f"`{path}` must be readable, but: {error}.") from None


@contextlib.contextmanager
def new_store(target: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Gives a scratch folder beside `target`, which becomes `target` when the block ends well and vanishes when not.

    Raises StoreError at once if `target` exists (and is not ours to overwrite, or is being written) or cannot be
    written; at the end if something else has come to stand there.
    """
    target = Path(target)
    if target.exists() and not target.is_symlink():
        if not overwrite:
            raise StoreError(f"`{target}` must not exist yet, but does: remove it, or say --overwrite.")
        try:
            skeleton.root_of(target)  # a damaged one may be overwritten
        except StoreError:
            sentence = f"`{target}` must be a store of tippetop to be overwritten, but is something else."
            raise StoreError(sentence) from None
    with files.writing(target), files.replacing_folder(target, overwrite=overwrite) as scratch:
        yield scratch

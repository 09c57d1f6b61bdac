"""The root attributes of a store: what it holds, and whether tippetop wrote it."""

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import flag, path_of
from ..columns import with_coordinates
from ..errors import StoreError
from . import checkpoint, files, seal, skeleton


if TYPE_CHECKING:
    import xarray as xr


RUNS = "runs"  # the group of a sweep whose members are stores of runs


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
    """Root attributes of a store whose skeleton is sound, without what only a longer run needs; of a run that is not
    finished, with what its checkpoint says of its end. Raises StoreError; see `skeleton.read`."""
    stored = skeleton.read(path, whole=whole)
    if "content" in stored or stored["status"] != "running":
        return {name: value for name, value in stored.items() if name != checkpoint.END}
    try:
        record = checkpoint.read(Path(path), stored)
    except FileNotFoundError:  # it just finished, or never began: the root attributes stand
        return stored
    return stored | {"report": record["report"], "reason": record["reason"]}


def refuse_other_rows(path: str | Path, attrs: dict[str, Any]) -> None:
    """Raises StoreError if rows that the checkpoint of an unfinished run acknowledges are others; a finished store has
    its seal."""
    if "content" in attrs or attrs["status"] != "running":
        return
    try:
        record = checkpoint.read(Path(path), skeleton.root_of(path))
    except FileNotFoundError:  # it just finished, or never began
        return
    for group, digest in record["digests"].items():
        rows = record[checkpoint.ROWS[group]]
        if digest_of_rows(path, group, rows) != digest:
            raise StoreError(f"`{path}` must hold the {rows} acknowledged rows of `{group}`, but some are others.")


def digest_of_rows(path: str | Path, group: str, rows: int) -> str:
    """The digest of so many rows of a group, as a checkpoint keeps it. Raises StoreError."""
    from . import chunks, tables  # zarr: a run that is not stored does without

    try:
        return chunks.digest_of_rows(tables.read_member(path, group), rows)
    except Exception as error:  # codecs raise what they like
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


def annotate(path: str | Path, more: dict[str, Any]) -> None:
    """Adds root attributes to a finished store, whose seal then is another one. Raises StoreError."""
    skeleton.read(path)
    with files.writing(Path(path) / seal.DOCUMENT):
        finish(path, more)


def finish(path: str | Path, more: dict[str, Any]) -> None:
    """Gives a store that is whole its last root attributes, and its seal, in one step. Raises OSError."""
    seal.put(Path(path), skeleton.sealed_members(skeleton.root_of(path)), finite(more))


def replace_attributes(path: str | Path, attrs: dict[str, Any]) -> None:
    """Gives a store other root attributes, in one step; a seal goes with those that it had. Raises StoreError."""
    with files.writing(Path(path) / seal.DOCUMENT):
        seal.replace_attributes(Path(path), finite(attrs))


@contextlib.contextmanager
def unsealed(path: str | Path) -> Iterator[None]:
    """A block that may change the chunks of a finished store: it has no seal until the block ends, however it ends.
    A process that is killed in it leaves a whole store without one. Raises StoreError."""
    attrs = skeleton.root_of(path)
    if seal.SEAL not in attrs:
        yield
        return
    place = Path(path) / seal.DOCUMENT
    with files.writing(place):
        seal.remove(Path(path))
    try:
        yield
    finally:
        with files.writing(place):
            finish(path, {})


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
        If there is no such store or group; or, when data are read, if a part of a finished store is gone by then.
    """
    import xarray as xr

    attrs = attributes(path_of("path", path))
    refuse_other_rows(path, attrs)
    place: Any = _sealed(path) if seal.SEAL in attrs else Path(path)
    attrs = {name: value for name, value in attrs.items() if name != seal.SEAL}  # it says nothing of the data
    try:
        table = xr.open_zarr(place, group=group, consolidated=False, chunks=None).assign_attrs(attrs)
        return with_coordinates(table)
    except (OSError, ValueError, KeyError, TypeError, MemoryError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


def _sealed(path: str | Path) -> Any:
    """A finished store for zarr, which is read when data are asked for: of one that is gone by then, an error."""
    from .sealed import SealedStore  # zarr: a run that is not stored does without

    return SealedStore(Path(path).absolute(), read_only=True)


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
    flag("overwrite", overwrite)
    target = Path(target)
    if not (target.parent.name == RUNS and target.name.isdigit()):  # a sweep's own
        files.refuse_inside(target)
    if target.exists() and not target.is_symlink():
        if not overwrite:
            raise StoreError(f"`{target}` must not exist yet, but does: remove it, or say --overwrite.")
        skeleton.refuse_foreign(target)  # a damaged one may be overwritten
    with files.writing(target), files.replacing_folder(target, overwrite=overwrite) as scratch:
        yield scratch

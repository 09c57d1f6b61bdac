"""The root attributes of a store: what it holds, and whether tippetop wrote it."""

import contextlib
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..columns import with_coordinates
from ..errors import StoreError
from . import files
from .provenance import FORMAT, FORMAT_VERSION


if TYPE_CHECKING:
    import xarray as xr


CHECKPOINT = "checkpoint.json"


def finite(value: Any) -> Any:
    """The value as JSON can hold it: numbers that are not finite become None."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def attributes(path: str | Path) -> dict[str, Any]:
    """Root attributes of a store. Raises StoreError if there is none of ours."""
    place = Path(path)
    try:
        stored = json.loads((place / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        if stored["format"] != FORMAT:
            raise KeyError("format")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StoreError(f"`{path}` {_no_store(place, error)}.") from None
    if stored.get("format_version") != FORMAT_VERSION:
        raise StoreError(
            f"`{path}` must have format version {FORMAT_VERSION}, but has {stored.get('format_version')}: "
            "use the release that wrote it."
        )
    if stored.get("status") == "running":
        try:
            record = json.loads((place / CHECKPOINT).read_text(encoding="utf-8"))
            stored |= {"report": record["report"], "reason": record["reason"]}
        except (OSError, ValueError, KeyError):
            pass  # it just finished, or never began: the root attributes stand
    return stored


def _no_store(place: Path, error: Exception) -> str:
    """Why a path is not a store of ours."""
    if not place.exists():
        return "does not exist"
    if not place.is_dir():
        return "is a file, not a store: a store is a folder that `tippetop run --out` writes"
    if isinstance(error, OSError) and not isinstance(error, FileNotFoundError):
        return f"must be a store of tippetop, but cannot be read: {error.strerror or error}"
    return "must be a store of tippetop, but is another folder"


def annotate(path: str | Path, more: dict[str, Any]) -> None:
    """Adds root attributes to a finished store."""
    place = Path(path) / "zarr.json"
    content = json.loads(place.read_text(encoding="utf-8"))
    content["attributes"] |= finite(more)
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

    attrs = attributes(path)
    try:
        table = xr.open_zarr(Path(path), group=group, consolidated=False, chunks=None).assign_attrs(attrs)
        return with_coordinates(table)
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


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
            attributes(target)
        except StoreError:
            sentence = f"`{target}` must be a store of tippetop to be overwritten, but is something else."
            raise StoreError(sentence) from None
    with files.writing(target), files.replacing_folder(target, overwrite=overwrite) as scratch:
        yield scratch

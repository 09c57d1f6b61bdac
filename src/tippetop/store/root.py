"""The root attributes of a store: what it holds, and whether tippetop wrote it."""

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import flag, path_of
from ..columns import with_coordinates
from ..errors import StoreError
from . import files, ledger
from .ledger import Ledger
from .provenance import FORMAT
from .zarr3 import DOCUMENT


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
    """Return the root attributes of a store that is what its ledger acknowledges.

    With `whole=False` only the ledger is read. Raises StoreError; see `ledger.read`.
    """
    place = Path(path)
    if ledger.is_ledger(place):
        return ledger.read(place, chunks=whole).attributes
    if _is_preview(place):
        raise StoreError(
            f"`{path}` was written by a preview of tippetop (format 1): make it again, or read "
            "its numbers "
            "with xarray.open_zarr."
        )
    raise StoreError(f"`{path}` {_no_store(place)}.")


def root_of(path: str | Path) -> dict[str, Any]:
    """Return the root attributes as the ledger has them. Raises StoreError."""
    return attributes(path, whole=False)


def refuse_foreign(path: Path) -> None:
    """Raise StoreError if tippetop did not write what is there; what is damaged is not refused."""
    if not ledger.is_ledger(path) and not _is_preview(path):
        attributes(path)


def _is_preview(place: Path) -> bool:
    """Whether a folder is a store from before there was a ledger."""
    try:
        return (
            json.loads((place / DOCUMENT).read_text(encoding="utf-8"))["attributes"]["format"]
            == FORMAT
        )
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def _no_store(place: Path) -> str:
    """Why a path is not a store of ours."""
    try:
        (place / DOCUMENT).stat()
    except FileNotFoundError:
        if not place.exists():
            return "does not exist"
    except NotADirectoryError:
        return "is a file, not a store: a store is a folder that `tippetop run --out` writes"
    except OSError as error:
        return f"must be a store of tippetop, but cannot be read: {error.strerror or error}"
    return "must be a store of tippetop, but is another folder"


def has_keyframes(attrs: Mapping[str, Any]) -> bool:
    """Whether a store with these root attributes is that of a run with keyframes; the rows of a
    replay are none.
    """
    return (
        "content" not in attrs
        and attrs["run"].get("output") == "keyframes"
        and "replay" not in attrs
    )


def groups_of(path: str | Path) -> list[str]:
    """Return the groups of a store, as its ledger lists them. Raises StoreError."""
    members = ledger.read(Path(path), chunks=False).header["members"]
    return [name for name in members if "/" not in name and name != RUNS]


def annotate(path: str | Path, more: dict[str, Any]) -> None:
    """Adds root attributes to a finished store. Raises StoreError."""
    place = Path(path)
    with files.writing(place), Ledger.opened(place) as store:
        store.finish(store.state.changed | finite(more))


def open_group(path: str | Path, group: str) -> "xr.Dataset":
    """A group of a store as a labelled Dataset, read when needed; `tippetop.open` opens stores
    whole.

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
        table = xr.open_zarr(Path(path), group=group, chunks=None).assign_attrs(attrs)
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
    """Gives a scratch folder beside `target`, which becomes `target` when the block ends well and
    vanishes when not.

    Raises StoreError at once if `target` exists (and is not ours to overwrite, or is being written)
    or cannot be written; at the end if something else has come to stand there.
    """
    flag("overwrite", overwrite)
    target = Path(target)
    if not (target.parent.name == RUNS and target.name.isdigit()):  # a sweep's own
        files.refuse_inside(target)
    if target.exists() and not target.is_symlink():
        if not overwrite:
            raise StoreError(
                f"`{target}` must not exist yet, but does: remove it, or say --overwrite."
            )
        refuse_foreign(target)  # a damaged one may be overwritten
    with files.writing(target), files.replacing_folder(target, overwrite=overwrite) as scratch:
        yield scratch

"""Read the root attributes and the groups of a store, and create new stores.

A path goes in; attributes as plain data and groups as Datasets come out. `new_store` makes room for
a new one.
"""

import contextlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import PlainData, flag, path_of
from ..columns import plain_attributes, with_coordinates
from ..errors import StoreError
from . import files, ledger
from .ledger import Ledger
from .zarr3 import DOCUMENT


if TYPE_CHECKING:
    import xarray as xr


RUNS = "runs"  # the group of a sweep whose members are stores of runs


def finite(value: Any) -> Any:
    """Return a value as JSON can contain it: numbers that are not finite become None.

    Tuples become lists, so that attributes compare equal with those that were read.
    """

    def of_numpy(number: Any) -> Any:
        """Return a scalar of NumPy as a number of Python, for `json.dumps`."""
        return float(number) if isinstance(number, np.floating) else number.item()

    return json.loads(json.dumps(value, default=of_numpy), parse_constant=lambda _: None)


def attributes(path: str | Path, *, whole: bool = True) -> PlainData:
    """Return the root attributes of a store after comparing it with its ledger.

    With `whole=False` only the ledger is read. Raises StoreError; see `ledger.read`.
    """
    place = Path(path)
    if not os.path.lexists(place / ledger.LEDGER):
        raise StoreError(f"`{place}` {_no_store(place)}.")
    return ledger.read(place, chunks=whole).attributes


def root_of(path: str | Path) -> PlainData:
    """Return the root attributes in the ledger. Raises StoreError."""
    return attributes(path, whole=False)


def _no_store(place: Path) -> str:
    """Return why a path is not a store of tippetop, a clause that follows its name."""
    try:
        (place / DOCUMENT).stat()
        return (
            "must be a store of tippetop, but is another zarr folder or of a preview (format 1): "
            "make it again, or read its numbers with xarray.open_zarr"
        )
    except FileNotFoundError:
        if not place.exists():
            return "does not exist: `tippetop run SCENARIO --out STORE` makes a store"
    except NotADirectoryError:
        return "is a file, not a store: a store is a folder that `tippetop run --out` writes"
    except OSError as error:
        return f"must be a store of tippetop, but cannot be read: {error.strerror or error}"
    return "must be a store of tippetop, but is another folder"


def has_keyframes(attrs: Mapping[str, Any]) -> bool:
    """Return whether a store with these root attributes is that of a run with keyframes.

    These attributes are a stored format. Only stores of other kinds than runs have `content`; a
    `replay` copies all attributes of its run, and thus `run.output`, but contains no keyframes.
    """
    run = "content" not in attrs and "replay" not in attrs
    return run and attrs["run"].get("output") == "keyframes"


def groups_of(path: str | Path) -> list[str]:
    """Return the groups of a store, as its ledger lists them. Raises StoreError."""
    members = ledger.read(Path(path), chunks=False).header["members"]
    return [name for name in members if "/" not in name and name != RUNS]


def annotate(path: str | Path, more: PlainData) -> None:
    """Add or replace root attributes of a finished store, which stays sealed. Raises StoreError.

    `Ledger.finish` replaces all changed attributes, so the former ones are passed again.
    """
    place = Path(path)
    with files.writing(place), Ledger.opened(place) as store:
        store.finish(store.state.changed | finite(more))


def open_group(path: str | Path, group: str) -> "xr.Dataset":
    """Open a group of a store as a labelled Dataset, read when needed.

    Parameters
    ----------
    path : path-like
        The store.
    group : str
        trajectory, events, ..., of a run; sweep or events of a sweep; surface; potential.

    Returns
    -------
    xarray.Dataset
        In SI units, with the root attributes of the store; tables among them are JSON texts.

    Raises
    ------
    StoreError
        If there is no such store or group.
    """
    import xarray as xr

    attrs = attributes(path_of("path", path))
    # as attributes of a netCDF file these would have another meaning
    shape = [attrs.pop(key, []) for key in ("coordinates", "columns", "dimensions", "shape")]
    coordinates, columns, *_ = shape
    try:
        table = xr.open_zarr(Path(path), group=group, chunks=None)
        if "row" in table.dims:
            table = _joined(loaded(table, path))
        elif coordinates:
            table = table[[*coordinates, *columns]].set_coords(coordinates)
        return with_coordinates(table.assign_attrs(plain_attributes(attrs)))
    except StoreError:
        raise
    except Exception as error:  # codecs raise errors of any type
        raise StoreError(f"`{path}` must hold a readable group `{group}`, but: {error}.") from None


def _joined(table: "xr.Dataset") -> "xr.Dataset":
    """Return the events of a sweep in one piece, along `event`: the parts one after another.

    In the store they are (row, part), with NaN as time of the rows that a part lacks.
    """
    import xarray as xr

    is_row = np.isfinite(table["time"].values.T)
    columns = {
        name: (("event", *column.dims[2:]), column.values.swapaxes(0, 1)[is_row], column.attrs)
        for name, column in table.variables.items()
    }
    return xr.Dataset(columns)


def loaded(table: Any, path: str | Path) -> Any:
    """Load a Dataset of a store into memory, in place, and return it.

    Raises StoreError for a damaged column; `path` is for its message.
    """
    for name, variable in table.variables.items():
        try:
            variable.load()
        except Exception as error:  # codecs raise errors of any type
            what = str(error).partition(". Stored:")[0]
            raise StoreError(
                f"`{path}` must hold a readable column `{name}`, but: {what}."
            ) from None
    return table


def column(path: str | Path, table: Any, name: str) -> np.ndarray:
    """Return a column of a table of a store. Raises StoreError if it is damaged."""
    return loaded(table[[name]], path)[name].values


@contextlib.contextmanager
def new_store(
    target: str | Path, *, overwrite: bool = False, in_sweep: bool = False
) -> Iterator[Path]:
    """Yield a scratch folder, which becomes `target` when the block ends well.

    A store that is replaced is locked first, moved aside whole, and removed last. Only with
    `in_sweep` may the target lie inside another store, that of its sweep.

    Raises StoreError immediately if `target` exists (and may not be overwritten, or is being
    written) or cannot be written; at the end if something else was made there.
    """
    flag("overwrite", overwrite)
    path = Path(target)
    if not path.name:
        raise StoreError(f"`{path}` must be the name of a new store, such as run.zarr.")
    if not in_sweep:
        files.refuse_inside(path)
    files.own_folder(path)
    with files.writing(path), contextlib.ExitStack() as stack:
        files.put_back(path)
        lock = None
        if path.exists():
            files.refuse_existing(path, overwrite)
            if not ledger.has_ledger(path):
                raise StoreError(f"`{path}` {_no_store(path)}.")
            lock = stack.enter_context(Ledger.locked(path))
        files.remove_stale(path)
        scratch = stack.enter_context(files.scratch_folder(path))
        yield scratch
        if lock is None:
            files.rename_new(scratch, path)
            return
        lock.check()
        old = files.name_aside(path)
        path.rename(old)
        try:
            files.rename_new(scratch, path)
        except BaseException:
            if not path.exists():
                old.rename(path)
            raise
        files.rename_new(old, scratch)  # `scratch_folder` removes the folder of this name

"""Create files and folders that appear whole or not at all.

No link is followed where something is written: scratch names cannot be guessed, and a rename
replaces a link rather than its target.
"""

import contextlib
import glob
import os
import shutil
import uuid
import warnings
from collections.abc import Iterator
from pathlib import Path

from ..arguments import flag
from ..errors import StoreError
from .folder import Folder, NoLocks
from .ledger import Ledger, has_ledger


SCRATCH = "[0-9a-f]" * 32  # ends the name of a scratch folder: `uuid4().hex`


@contextlib.contextmanager
def writing(path: str | Path, remedy: str = "") -> Iterator[None]:
    """Convert an OSError of the block to a StoreError about `path`, followed by the remedy."""
    try:
        yield
    except StoreError:
        raise
    except OSError as error:
        sentence = f"`{path}` must be writable, but: {error.strerror or error}."
        raise StoreError(f"{sentence} {remedy}".rstrip()) from error


@contextlib.contextmanager
def replacing(path: str | Path, *, overwrite: bool = True) -> Iterator[Path]:
    """Yield an empty scratch file, which becomes `path`, synced, when the block ends well.

    It has the name of `path`, because some writers (ffmpeg for `film`) choose the format by its
    ending. Leftovers of killed processes go even if `path` is then refused.
    Raises StoreError if `path` exists and may not be overwritten, or cannot be written.
    """
    path = Path(path)
    if not path.name or (path.exists() and not path.is_file()):
        raise StoreError(f"`{path}` must be the name of a file, but is a folder or a device.")
    refuse_inside(path)
    flag("overwrite", overwrite)
    with writing(path):
        remove_stale(path)
        refuse_existing(path, overwrite)
        with scratch_folder(path) as folder:
            scratch = folder / path.name
            scratch.touch()
            yield scratch
            synced(folder, path.name)
            refuse_existing(path, overwrite)  # another process may have made it meanwhile
            os.replace(scratch, path)
            synced(path.parent)


def refuse_inside(path: Path) -> None:
    """Raise StoreError if a path that a user names lies in a store, which it would damage."""
    for folder in Path(os.path.realpath(path)).parents:
        if os.path.lexists(folder / "zarr.json"):
            raise StoreError(
                f"`{path}` must lie outside of every store, but `{folder}` is one: it would be "
                "damaged."
            )


@contextlib.contextmanager
def scratch_folder(path: Path) -> Iterator[Path]:
    """Make a hidden folder next to `path`; remove it when the block ends. Raises OSError.

    `remove_stale` finds those of killed writers by this name, and by their lock, which is free.
    """
    scratch = path.with_name(f".{path.name}.part-{uuid.uuid4().hex}")  # cannot be guessed
    scratch.mkdir()
    with contextlib.ExitStack() as stack:
        stack.callback(shutil.rmtree, scratch, ignore_errors=True)
        with contextlib.suppress(NoLocks):  # only a store, which locks its ledger, needs them
            # the end of a killed writer releases it
            stack.callback(os.close, Folder(scratch).lock())
        yield scratch


def put_back(path: Path) -> None:
    """Undo or complete a replacement that a killed writer of `path` left.

    The old store, which was moved aside, is renamed back, or removed if the new one is there.
    """
    old = name_aside(path)
    if not has_ledger(old):
        return
    if has_ledger(path):
        _removed(old)
    if path.exists():  # also of another program
        return
    # the lock is held while a writer is at work
    with contextlib.suppress(OSError, StoreError), Ledger.locked(old):
        old.rename(path)
        synced(path.parent)
        warnings.warn(f"`{path}` is put back: a killed run had not replaced it yet.", stacklevel=2)


def remove_stale(path: Path) -> None:
    """Remove, with a warning, the scratch folders that killed writers of `path` left.

    Only folders with a name by `scratch_folder` that no process has locked.
    """
    for old in sorted(path.parent.glob(f".{glob.escape(path.name)}.part-{SCRATCH}")):
        if _removed(old):
            warnings.warn(f"`{old}` is removed: a killed run left it.", stacklevel=2)


def _removed(old: Path) -> bool:
    """Remove a folder, unless a process has locked it; return whether it was removed.

    It stays where there are no locks (`NoLocks`), as its writer may be at work.
    """
    try:
        with contextlib.ExitStack() as stack:
            stack.callback(os.close, Folder(old).lock())
            shutil.rmtree(old)
    except OSError:
        return False
    return True


def rename_new(scratch: Path, path: Path) -> None:
    """Rename a folder to a name that only an empty folder may have. Raises StoreError, OSError."""
    try:
        scratch.rename(path)
    except OSError:
        if os.path.lexists(path):
            raise StoreError(
                f"`{path}` must have one writer, but another process has made it meanwhile."
            ) from None
        raise
    synced(path.parent)


def write_text(path: Path, text: str, *, overwrite: bool) -> None:
    """Write a file of the user whole or not at all. Raises StoreError."""
    with replacing(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Raise StoreError if a path exists, unless it may be overwritten."""
    if not overwrite and os.path.lexists(path):
        raise StoreError(f"`{path}` must not exist yet, but does: use --overwrite to replace it.")


def name_aside(path: Path) -> Path:
    """Return the hidden name that a store has while another takes its place."""
    return path.with_name(f".{path.name}.replaced")


def synced(folder: Path, name: str = "") -> None:
    """Wait until a file in a folder, or the list of its files, is on the disk."""
    # resolved, as `Folder` opens no link
    Folder(folder.resolve()).sync_one(name)


def own_folder(path: str | Path) -> Path:
    """Return a path that may not exist. Raises StoreError if it is a link.

    A store is written in place, so a link would write into another folder.
    """
    if os.path.islink(path):
        raise StoreError(f"`{path}` must be a folder, but is a link.")
    return Path(path)


def refuse_links(folder: Path) -> None:
    """Raise StoreError if a store that is to be written contains links, pipes or devices."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                refuse_links(Path(entry.path))
            elif not entry.is_file(follow_symlinks=False):
                raise StoreError(
                    f"`{entry.path}` must be a file or a folder, but is a link, a pipe or a "
                    "device: in a store, these are neither followed nor written."
                )

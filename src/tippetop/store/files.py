"""Files and folders that appear whole or not at all.

No link is followed where something is written: scratch names cannot be guessed and are made
exclusively, and what takes its place does so by a rename, which replaces a link rather than what it
points to.
"""

import contextlib
import errno
import fcntl
import os
import re
import shutil
import stat
import uuid
import warnings
from collections.abc import Iterator
from pathlib import Path

from ..arguments import flag
from ..errors import StoreError
from .ledger import Ledger, is_ledger


@contextlib.contextmanager
def writing(path: str | Path, remedy: str = "") -> Iterator[None]:
    """A block in which what goes wrong with the disk becomes a StoreError about `path`, followed by
    the remedy.
    """
    try:
        yield
    except StoreError:
        raise
    except OSError as error:
        sentence = f"`{path}` must be writable, but: {error.strerror or error}."
        raise StoreError(f"{sentence} {remedy}".rstrip()) from error


@contextlib.contextmanager
def replacing(path: str | Path, *, overwrite: bool = True) -> Iterator[Path]:
    """Gives an empty scratch file near `path`, which becomes `path` when the block ends well, on
    the disk itself, and vanishes when not.

    Raises
    ------
    StoreError
        `path` exists, unless it may be overwritten.
    OSError
        The disk; see `writing`.
    """
    path = Path(path)
    if not path.name or path.is_dir():
        raise StoreError(f"`{path}` must be the name of a file, but is a folder.")
    refuse_inside(path)
    flag("overwrite", overwrite)
    remove_stale(path)
    if os.path.lexists(path):
        if not overwrite:
            raise _exists(path)
        if not path.is_symlink() and not path.is_file():
            raise StoreError(
                f"`{path}` must be a file to be overwritten, but is a device, a pipe or a socket."
            )
    with _scratch_folder(path) as folder:
        scratch = folder / path.name
        os.close(os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
        yield scratch
        synced(scratch)
        if overwrite:
            os.replace(scratch, path)
        else:
            _rename_new_file(scratch, path)
        synced(path.parent)


def refuse_inside(path: Path) -> None:
    """Raises StoreError if a path that a user names lies in a store: what is added there, or
    replaced, damages it.
    """
    for place in (Path(os.path.abspath(path)), Path(os.path.realpath(path))):
        for folder in place.parents:
            if os.path.lexists(folder / "zarr.json"):
                raise StoreError(
                    f"`{path}` must lie outside of every store, but `{folder}` is one: it would "
                    "be damaged."
                )


@contextlib.contextmanager
def replacing_folder(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Gives an empty scratch folder beside `path`, which becomes `path` when the block ends well
    and vanishes when not.

    What is there already is a store whose lock is taken first: it is moved aside whole, and goes at
    last.

    Raises
    ------
    StoreError
        `path` exists, unless it may be overwritten; it is a link; another process writes it.
    OSError
        The disk; see `writing`.
    """
    path = own_folder(path)
    put_back(path)
    replaced = path.exists()
    if replaced and not overwrite:
        raise _exists(path)
    with contextlib.ExitStack() as stack:
        lock = stack.enter_context(lock_of(path)) if replaced else None
        remove_stale(path)
        scratch = stack.enter_context(_scratch_folder(path))
        yield scratch
        if not replaced:
            rename_new(scratch, path)
            return
        if lock is not None:
            lock.check()
        old = _name_aside(path)
        path.rename(old)
        try:
            rename_new(scratch, path)
        except BaseException:
            old.rename(path)
            raise
        shutil.rmtree(old, ignore_errors=True)


def lock_of(path: Path) -> contextlib.AbstractContextManager[Ledger | None]:
    """The lock of a store. Raises StoreError: another process writes it."""
    return Ledger.locked(path) if is_ledger(path) else contextlib.nullcontext()


@contextlib.contextmanager
def _scratch_folder(path: Path) -> Iterator[Path]:
    """An empty folder beside `path`, held until the block ends, when it goes with all that is in
    it. Raises OSError.
    """
    while True:
        scratch = scratch_name(path)
        scratch.mkdir()
        try:
            descriptor = _held(
                scratch
            )  # until it is gone or this process is: a killed writer leaves it free
            break
        except (FileNotFoundError, BlockingIOError):  # in between another process took it for stale
            continue
    try:
        yield scratch
    finally:
        os.close(descriptor)
        shutil.rmtree(scratch, ignore_errors=True)


def _held(folder: Path) -> int:
    """A descriptor that locks a folder itself until it is closed or the process ends.

    Raises OSError: it is held.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def put_back(path: Path) -> None:
    """Put back a store that a killed writer moved aside, and warn; remove it if its successor took
    its place.
    """
    old = _name_aside(path)
    if not old.exists():
        return
    if path.exists():
        _removed(old)
        return
    with (
        contextlib.suppress(OSError, StoreError),
        lock_of(old),
    ):  # the lock is held while a writer is at work
        old.rename(path)
        synced(path.parent)
        warnings.warn(f"`{path}` is put back: a killed run had not replaced it yet.", stacklevel=2)


def remove_stale(path: Path) -> None:
    """Removes the scratch folders that killed writers of `path` left beside it, and warns, naming
    them.

    Only what is ours beyond doubt: a folder of this user whose name `scratch_name` made, and which
    no process holds.
    """
    pattern = re.compile(re.escape(f".{path.name}.part-") + "[0-9a-f]{32}")
    with contextlib.suppress(OSError):
        for name in sorted(os.listdir(path.parent)):
            old = path.with_name(name)
            if pattern.fullmatch(name) and _removed(old):
                warnings.warn(f"`{old}` is removed: a killed run left it.", stacklevel=2)


def _removed(old: Path) -> bool:
    """Removes a folder of this user that nobody holds; whether it did."""
    try:
        status = os.lstat(old)
        if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.geteuid():
            return False
        with contextlib.ExitStack() as stack:
            stack.callback(os.close, _held(old))
            stack.enter_context(lock_of(old))
            shutil.rmtree(old)
    except (OSError, StoreError):
        return False
    return True


def rename_new(scratch: Path, path: Path) -> None:
    """Renames a folder to a name that nothing but an empty folder may have.

    Raises StoreError, OSError.
    """
    try:
        scratch.rename(path)
    except OSError as error:
        if error.errno in (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR):
            raise _exists(path) from None
        raise
    synced(path.parent)


def _rename_new_file(scratch: Path, path: Path) -> None:
    try:
        os.link(scratch, path)
    except FileExistsError:
        raise _exists(path) from None
    except OSError:  # a file system without hard links
        if os.path.lexists(path):
            raise _exists(path) from None
        os.rename(scratch, path)


def write_text(path: Path, text: str, *, overwrite: bool) -> None:
    """Write a file of the user whole or not at all. Raises StoreError."""
    with writing(path), replacing(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def _exists(path: Path) -> StoreError:
    return StoreError(f"`{path}` must not exist yet, but does.")


def _name_aside(path: Path) -> Path:
    """Return the hidden name that a store has while another takes its place."""
    return path.with_name(f".{path.name}.replaced")


def scratch_name(path: Path) -> Path:
    """A hidden name beside `path` that nobody can guess."""
    return path.with_name(f".{path.name}.part-{uuid.uuid4().hex}")


def synced(path: Path) -> None:
    """Waits until the disk itself has a file, or what a folder says of its files."""
    descriptor = os.open(
        path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC
    )  # not to wait where a pipe came to be
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL or not path.is_dir():  # some file systems sync no folders
            raise
    finally:
        os.close(descriptor)


def own_folder(path: str | Path) -> Path:
    """A path that is no link, so that what is written there is written there. Raises StoreError."""
    if os.path.islink(path):
        raise StoreError(f"`{path}` must be a folder of its own, but is a link.")
    return Path(path)


def refuse_links(folder: Path) -> None:
    """Raises StoreError if anything inside a folder is neither a folder nor a plain file: zarr,
    which writes there, would follow a link out of it. For who opens a store to write in it, whoever
    made the store.
    """
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                refuse_links(Path(entry.path))
            elif not entry.is_file(follow_symlinks=False):
                kind = "a link" if entry.is_symlink() else "no plain file"
                raise StoreError(
                    f"`{entry.path}` is {kind}: in a store, such a thing is neither followed "
                    "nor written."
                )

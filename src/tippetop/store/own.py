"""A folder on disk for zarr, of which no link is followed when something is written, whenever it came to be there."""

import contextlib
import errno
import os
import shutil
import stat
import uuid
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from zarr.storage import LocalStore

from ..errors import StoreError
from .files import synced


METADATA = "zarr.json"
# Files that are synced at the same time share a commit of the journal.
SYNC_THREADS = 16
FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


class OwnStore(LocalStore):
    """As zarr's, but every folder on the way to a file is opened by itself, below the one before.

    Files are small: what is written or is metadata does not wait for a thread of its own, of which a run would start
    some 300, each to wait for its turn.
    """

    def __init__(self, root: Path | str, *, read_only: bool = False):
        super().__init__(root, read_only=read_only)
        # new files, and folders with new entries, since the last `sync`
        self.unsynced: set[str] = set()

    def sync(self) -> None:
        """Wait until the disk has all that was written: a power failure cannot undo it."""
        with ThreadPoolExecutor(SYNC_THREADS) as pool:
            list(pool.map(synced, map(self.root.joinpath, sorted(self.unsynced))))
        self.unsynced.clear()

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """The content of a file, or None."""
        if key.endswith(METADATA):
            return self.get_sync(key, prototype=prototype, byte_range=byte_range)
        return await super().get(key, prototype, byte_range)

    def set_sync(self, key: str, value: Any) -> None:
        """Writes a file whole or not at all."""
        self._check_writable()
        self._write(key, value, exclusive=False)

    async def _set(self, key: str, value: Any, exclusive: bool = False) -> None:
        if not self._is_open:
            await self._open()
        self._check_writable()
        self._write(key, value, exclusive=exclusive)

    def _write(self, key: str, value: Any, *, exclusive: bool) -> None:
        with self._folder_of(key, make=True) as (folder, name):
            scratch = f"{name}.{uuid.uuid4().hex}.partial"
            there = os.access(name, os.F_OK, dir_fd=folder, follow_symlinks=False)
            replaced = there and key not in self.unsynced
            with os.fdopen(os.open(scratch, FILE, 0o666, dir_fd=folder), "wb") as file:
                try:
                    file.write(value.as_buffer_like())
                    file.flush()
                    if replaced:  # its content may be acknowledged
                        os.fsync(file.fileno())
                    if exclusive:
                        os.link(scratch, name, src_dir_fd=folder, dst_dir_fd=folder, follow_symlinks=False)
                    else:
                        os.replace(scratch, name, src_dir_fd=folder, dst_dir_fd=folder)
                except Exception:
                    os.unlink(scratch, dir_fd=folder)
                    raise
            if exclusive:
                os.unlink(scratch, dir_fd=folder)
        parent = key.rpartition("/")[0]
        self.unsynced |= {parent} if replaced else {key, parent}

    def delete_sync(self, key: str) -> None:
        """Removes a file or a folder, if it is there."""
        self._check_writable()
        with contextlib.suppress(FileNotFoundError), self._folder_of(key, make=False) as (folder, name):
            if stat.S_ISDIR(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
                shutil.rmtree(name, dir_fd=folder)
            else:
                os.unlink(name, dir_fd=folder)

    async def delete(self, key: str) -> None:
        """Removes a file or a folder, if it is there."""
        if not self._is_open:
            await self._open()
        self.delete_sync(key)

    @contextlib.contextmanager
    def _folder_of(self, key: str, *, make: bool) -> Iterator[tuple[int, str]]:
        """A descriptor of the folder of a file, made where it is missing, and the file's name there."""
        *parts, name = key.split("/")
        with contextlib.ExitStack() as held:
            folder = os.open(self.root, FOLDER)
            held.callback(os.close, folder)
            for i, part in enumerate(parts):
                folder = self._below(folder, parts[: i + 1], part, make=make)
                held.callback(os.close, folder)
            yield folder, name

    def _below(self, folder: int, place: list[str], name: str, *, make: bool) -> int:
        try:
            if make:
                with contextlib.suppress(FileExistsError):
                    os.mkdir(name, dir_fd=folder)
                    self.unsynced.add("/".join(place[:-1]))
            return os.open(name, FOLDER, dir_fd=folder)
        except OSError as error:
            if error.errno not in (errno.ENOTDIR, errno.ELOOP):
                raise
            sentence = "is no folder of the store: such a thing is neither followed nor written."
            raise StoreError(f"`{self.root.joinpath(*place)}` {sentence}") from None

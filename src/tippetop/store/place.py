"""A folder on disk, of which no link is followed when something is written, whenever it came to be there."""

import contextlib
import os
import shutil
import stat
import uuid
from collections.abc import Iterator
from pathlib import Path

from ..errors import StoreError


FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


class Place:
    """A folder that is written: every folder on the way to a file is opened by itself, below the one before.

    Parameters
    ----------
    root
        The folder.
    """

    def __init__(self, root: Path):
        self.root = root

    def write(self, key: str, content: bytes) -> None:
        """Writes a file whole or not at all."""
        with self._folder_of(key, make=True) as (folder, name):
            scratch = f"{name}.{uuid.uuid4().hex}.partial"
            with os.fdopen(os.open(scratch, FILE, 0o666, dir_fd=folder), "wb") as file:
                try:
                    file.write(content)
                    file.flush()
                    os.replace(scratch, name, src_dir_fd=folder, dst_dir_fd=folder)
                except Exception:
                    os.unlink(scratch, dir_fd=folder)
                    raise

    def delete(self, key: str) -> None:
        """Removes a file or a folder, if it is there."""
        with contextlib.suppress(FileNotFoundError), self._folder_of(key, make=False) as (folder, name):
            if stat.S_ISDIR(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
                shutil.rmtree(name, dir_fd=folder)
            else:
                os.unlink(name, dir_fd=folder)

    @contextlib.contextmanager
    def _folder_of(self, key: str, *, make: bool) -> Iterator[tuple[int, str]]:
        """A descriptor of the folder of a file, made where it is missing, and the file's name there."""
        *parts, name = key.split("/")
        if make:
            self.root.mkdir(exist_ok=True)
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
            return os.open(name, FOLDER, dir_fd=folder)
        except OSError as error:
            if isinstance(error, FileNotFoundError) or stat.S_ISDIR(
                os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode
            ):
                raise
            sentence = "is no folder of the store: such a thing is neither followed nor written."
            raise StoreError(f"`{self.root.joinpath(*place)}` {sentence}") from None

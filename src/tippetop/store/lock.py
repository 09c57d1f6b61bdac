"""The lock of a store: one writer at a time, whom the kernel releases however it ends."""

import contextlib
import fcntl
import os
import stat
import weakref
from collections.abc import Iterator
from pathlib import Path

from ..errors import StoreError


LOCK = "run.lock"


class Lock:
    """The lock of a store, from here on until it is released or the process ends, however it ends: the kernel keeps it.

    The file names the holder, who is named to those that are refused. Not filelock: it empties the file of a lock that
    it then fails to take, and the holder could not be named. A context that releases.

    Raises
    ------
    StoreError
        Another process holds it.
    OSError
        The disk; see `writing`.
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        while True:
            self._open()
            self._plain()
            self._take()
            if self._in_place():
                break
            self.release()  # its last holder removed the file while we waited: there is another one, or none
        os.ftruncate(self.descriptor, 0)
        os.write(self.descriptor, f"process {os.getpid()} on {os.uname().nodename}".encode())

    def _open(self) -> None:
        flags, place = os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC, self.folder / LOCK
        try:
            self.descriptor = os.open(place, flags | os.O_CREAT | os.O_EXCL, 0o644)
            self.made = True
        except FileExistsError:
            self.descriptor = os.open(place, flags | os.O_CREAT, 0o644)
            self.made = False
        self._close = weakref.finalize(
            self, os.close, self.descriptor
        )  # should an exception leave nobody to release it

    def _plain(self) -> None:
        """Refuses a pipe, or a file that has another name elsewhere: the holder's name would be written there."""
        status = os.fstat(self.descriptor)
        if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
            self.release()
            raise StoreError(f"`{self.folder / LOCK}` must be a file of its own: remove it.")

    def _take(self) -> None:
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.read(self.descriptor, 200).decode(errors="replace").strip() or "another process"
            self.release()
            raise StoreError(f"`{self.folder}` must have one writer, but {holder} is writing it.") from None

    def _in_place(self) -> bool:
        try:
            return os.path.samestat(os.lstat(self.folder / LOCK), os.fstat(self.descriptor))
        except FileNotFoundError:
            return False

    def check(self) -> None:
        """Raises StoreError if the folder is no longer the one that was locked."""
        if not self._in_place():
            raise StoreError(
                f"`{self.folder}` must stay in its place while it is written, but was moved, removed or replaced: "
                "what was there is gone from here, and nothing more is written."
            )

    @contextlib.contextmanager
    def guarded(self) -> Iterator[None]:
        """A block in which whatever cannot be read or written is the fault of the folder, if that is gone: then
        StoreError says so."""
        try:
            yield
        except (OSError, LookupError, ValueError):
            self.check()
            raise

    def remove(self) -> None:
        """Takes the file away: what is finished has no writer. The lock is still to be released."""
        if self._in_place():
            (self.folder / LOCK).unlink()

    def release(self) -> None:
        """Lets others write."""
        self._close()

    def __enter__(self) -> "Lock":
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

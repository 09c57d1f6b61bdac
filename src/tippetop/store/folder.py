"""Operations on the files of a store, by paths relative to one descriptor of its folder.

So nothing is ever written into another folder that took its place. Files are written without
waiting for the disk; `sync` then waits for all of them together.
"""

import contextlib
import errno
import fcntl
import os
import stat
import weakref
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


NEW = ".new"  # ends the name of a file that is being written
# O_NONBLOCK: not to wait for the writer of a pipe
READ = os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK
WRITE = os.O_WRONLY | os.O_NOFOLLOW | os.O_CLOEXEC


# a file system without locks: Lustre without the option flock, NFS without lockd
NO_LOCKS = errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK


class NoLocks(OSError):
    """Raised if the file system has no locks."""


class Folder:
    """An open folder, and the files in it that are not synced. Every operation raises OSError.

    `Ledger` has one; names are paths relative to it.
    """

    # files that are synced together share a commit of the journal
    threads = 8

    def __init__(self, path: str | Path):
        self.descriptor = os.open(path, READ | os.O_DIRECTORY)
        weakref.finalize(self, os.close, self.descriptor)
        self.unsynced: set[str] = set()  # files, and folders with new names

    def mkdir(self, name: str) -> None:
        """Make a folder, unless it exists; `sync` puts its name on the disk."""
        with contextlib.suppress(FileExistsError):
            os.mkdir(name, dir_fd=self.descriptor)
        # also of a folder that exists: another process may not have synced its name
        self.unsynced.add(name.rpartition("/")[0])

    def write(self, name: str, data: bytes, *, derived: bool = False) -> None:
        """Write a file, whole or not at all.

        A `derived` file can be made again, and is not synced.
        """
        self.put(name + NEW, data)
        self.rename(name + NEW, name)
        self.unsynced |= set() if derived else {name, name.rpartition("/")[0]}

    def put(self, name: str, data: bytes, how: int = os.O_CREAT | os.O_TRUNC) -> None:
        """Write a file in place, not synced; by default it becomes `data`.

        `how` are the flags of `os.open` in addition: with `os.O_APPEND` data are appended.
        """
        with self._open(name, WRITE | how) as descriptor:
            rest = memoryview(data)
            while rest:
                rest = rest[os.write(descriptor, rest) :]

    @contextlib.contextmanager
    def _open(self, name: str, how: int = READ) -> Iterator[int]:
        """Provide a descriptor of a file, or of this folder."""
        descriptor = os.open(name or ".", how, 0o666, dir_fd=self.descriptor)
        try:
            yield descriptor
        finally:
            os.close(descriptor)

    def rename(self, old: str, new: str) -> None:
        """Rename a file; an existing file of the new name is replaced. Nothing is synced."""
        os.rename(old, new, src_dir_fd=self.descriptor, dst_dir_fd=self.descriptor)

    def remove(self, name: str) -> None:
        """Remove a file, if it exists."""
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name, dir_fd=self.descriptor)

    def read(self, name: str) -> bytes:
        """Return the content of a file."""
        with open(os.open(name, READ, dir_fd=self.descriptor), "rb") as file:
            return file.read()

    def tip(self, name: str) -> tuple[int, bytes]:
        """Return the size of a file and its last four bytes: the checksum of a chunk.

        They are as many as `zarr3.CHECKSUM`, which `ledger.mark_of` takes: a change of one is a
        change of both.
        """
        with self._open(name) as descriptor:
            size = os.fstat(descriptor).st_size
            return size, os.pread(descriptor, 4, max(0, size - 4))

    def names(self, name: str) -> list[str]:
        """Return the names of the files in a folder of the store, sorted."""
        with self._open(name, READ | os.O_DIRECTORY) as descriptor:
            return sorted(os.listdir(descriptor))

    def lock(self, name: str = "") -> int:
        """Lock a file, or the folder, until the descriptor that is returned is closed.

        Raises BlockingIOError if another process has the lock, and `NoLocks`.
        """
        how = os.O_RDWR if name else os.O_DIRECTORY
        descriptor = os.open(name or ".", READ | how, dir_fd=self.descriptor)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BaseException as error:
            os.close(descriptor)
            if isinstance(error, OSError) and error.errno in NO_LOCKS:
                why = "its file system has no locks (flock), which stores need: use a local disk"
                raise NoLocks(error.errno, why) from None
            raise
        return descriptor

    def is_at(self, place: Path, held: int) -> bool:
        """Return whether the file at a path is the locked one."""
        try:
            return os.path.samestat(os.lstat(place), os.fstat(held))
        except (FileNotFoundError, NotADirectoryError):
            return False

    def sync(self) -> None:
        """Wait until all written files are on the disk, where a power failure cannot undo them."""
        names = sorted(self.unsynced)

        def work(first: int) -> None:
            """Sync every `threads`-th file, from that of number `first` on."""
            for name in names[first :: self.threads]:
                self.sync_one(name)

        with ThreadPoolExecutor(self.threads) as pool:
            list(pool.map(work, range(self.threads)))
        self.unsynced = set()

    def sync_one(self, name: str) -> None:
        """Wait until the content of a file, or the list of files in a folder, is on the disk."""
        with self._open(name) as descriptor:
            try:
                os.fsync(descriptor)
            except OSError as error:
                is_folder = stat.S_ISDIR(os.fstat(descriptor).st_mode)
                # some file systems sync no folders
                if error.errno != errno.EINVAL or not is_folder:
                    raise

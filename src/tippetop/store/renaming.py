"""Renames of folders that replace nothing, or swap two in one step: what Linux offers and Python does not."""

import ctypes
import errno
import os
from pathlib import Path


AT_FDCWD, NOREPLACE, EXCHANGE = -100, 1, 2  # of linux/fcntl.h and linux/fs.h
ABSENT = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)  # the kernel or the file system has it not


def rename_new(old: Path, new: Path) -> None:
    """Renames where nothing stands, not even an empty folder. Raises OSError.

    Without renameat2 (a file system that has it not) a plain rename after a look: it refuses all but an empty folder.
    """
    if _renameat2(old, new, NOREPLACE):
        return
    if os.path.lexists(new):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(new))
    old.rename(new)


def exchange(one: Path, other: Path) -> bool:
    """Swaps two folders in one step; False where the system cannot. Raises OSError."""
    return _renameat2(one, other, EXCHANGE)


def _renameat2(old: Path, new: Path, flags: int) -> bool:
    try:
        call = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    if call(AT_FDCWD, os.fsencode(old), AT_FDCWD, os.fsencode(new), flags) == 0:
        return True
    number = ctypes.get_errno()
    if number in ABSENT:
        return False
    raise OSError(number, os.strerror(number), str(old), None, str(new))

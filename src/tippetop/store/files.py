"""Files and folders that appear whole or not at all, and the lock of a store."""

import errno
import fcntl
import os
from pathlib import Path

from ..errors import StoreError


LOCK = "run.lock"


def locked(folder: Path) -> int:
    """Takes the lock of a store; the system frees it when the process ends, however it ends. Raises StoreError."""
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        holder = os.read(descriptor, 200).decode(errors="replace").strip() or "another process"
        os.close(descriptor)
        raise StoreError(f"`{folder}` must have one writer, but {holder} is writing it.") from None
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"process {os.getpid()} on {os.uname().nodename}".encode())
    return descriptor


def replace_text(path: Path, text: str) -> None:
    """Writes a file whole or not at all, also if the machine loses power."""
    scratch = path.with_name(f".{path.name}.part")
    with open(scratch, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(scratch, path)
    synced(path.parent)


def synced(path: Path) -> None:
    """Waits until the disk itself has a file, or what a folder says of its files."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL or not path.is_dir():  # some file systems sync no folders
            raise
    finally:
        os.close(descriptor)


def sweep(folder: Path) -> None:
    """Removes the scratch files that a killed writer leaves: zarr's and our own."""
    for pattern in ("*.partial", ".*.part"):
        for path in folder.rglob(pattern):
            path.unlink()

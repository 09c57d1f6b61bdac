"""Integrators and functions of heyoka on disk: their machine code is loaded only if its checksum is right.

heyoka's own cache is one database without checksums, readable and writable as the umask of the process allows. A
damaged object in it gives wrong numbers or ends the process, so nothing is compiled through it here.

Whoever can write a file of machine code can run code as its user. So the folder and the file must be writable by the
user only, and no link is followed. If anything is wrong with them, the code is compiled again.
"""

import hashlib
import os
import pickle
import secrets
import stat
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import heyoka as hy

from tippetop_kernels.compilation import cache_folder, is_private


LARGEST = 256 * 2**20
"""Bytes of all files together; those not used for longest are removed first."""

MAGIC = b"tippetop kernel 2\n"


def compiled_once(kind: Callable, *arguments: Any, **options: Any) -> Any:
    """Return `kind(*arguments, **options)`, from disk if an earlier process has compiled it.

    Parameters
    ----------
    kind
        A function of heyoka that compiles: `taylor_adaptive`, `taylor_adaptive_batch` or `cfunc`.
    *arguments, **options
        Its arguments.

    Returns
    -------
    object
        What `kind` returns.
    """
    made_from = (hy.__version__, _processor(), kind.__name__, arguments, options)
    key = hashlib.sha256(pickle.dumps(made_from)).digest()
    name = f"{kind.__name__}-{key.hex()}"
    with suppress(OSError), _directory(create=False) as directory:
        if (known := _read(directory, name, key)) is not None:
            return pickle.loads(zlib.decompress(known))
    with without_heyokas_cache():
        result = kind(*arguments, **options)
    with suppress(OSError), _directory(create=True) as directory:
        _write(directory, name, key, zlib.compress(pickle.dumps(result), level=1))
        _remove_oldest(directory)
    return result


# --- files ------------------------------------------------------------------------------------------------------------


@contextmanager
def _directory(*, create: bool) -> Iterator[int]:
    """Open the folder, check it, and yield its descriptor, relative to which files are used. Raises OSError."""
    path = cache_folder()
    if path is None:
        raise FileNotFoundError
    if create:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        if not is_private(os.fstat(handle)):
            raise PermissionError
        yield handle
    finally:
        os.close(handle)


def _read(directory: int, name: str, key: bytes) -> bytes | None:
    """Return the content of a file, or None if it is damaged or not private."""
    handle = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=directory)
    with open(handle, "rb") as file:
        status = os.fstat(handle)
        if not (stat.S_ISREG(status.st_mode) and is_private(status)):
            return None
        text = file.read()
    head, check, payload = text[: len(MAGIC) + 32], text[len(MAGIC) + 32 : len(MAGIC) + 64], text[len(MAGIC) + 64 :]
    if head != MAGIC + key or check != hashlib.sha256(payload).digest():
        return None
    with suppress(OSError):
        os.utime(name, dir_fd=directory)
    return payload


def _write(directory: int, name: str, key: bytes, payload: bytes) -> None:
    """Write a file and rename it: another process reads the old one or the new one."""
    scratch = f".{name}.{secrets.token_hex(8)}"
    handle = os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600, dir_fd=directory)
    try:
        with open(handle, "wb") as file:
            file.write(MAGIC + key + hashlib.sha256(payload).digest() + payload)
        os.replace(scratch, name, src_dir_fd=directory, dst_dir_fd=directory)
    except BaseException:
        with suppress(OSError):
            os.unlink(scratch, dir_fd=directory)
        raise


def _remove_oldest(directory: int) -> None:
    """Remove the files that were not used for longest, until the others are small enough together."""
    files = []
    for name in os.listdir(directory):
        with suppress(OSError):
            status = os.stat(name, dir_fd=directory, follow_symlinks=False)
            files.append((status.st_mtime_ns, status.st_size, name))
    total = sum(size for _, size, _ in files)
    for _, size, name in sorted(files):
        if total <= LARGEST:
            break
        with suppress(OSError):
            os.unlink(name, dir_fd=directory)
        total -= size


# --- heyoka's own cache -----------------------------------------------------------------------------------------------


class _Switch:
    """heyoka's cache on disk, which is off while any thread is within `without_heyokas_cache`."""

    def __init__(self) -> None:
        self.lock, self.threads, self.enabled = threading.Lock(), 0, True

    def change(self, threads: int) -> None:
        """Count threads that enter or leave; the first one switches the cache off, the last one restores it."""
        with self.lock:
            if self.threads == 0:
                self.enabled = hy.llvm_state.get_diskcache_enabled()
            self.threads += threads
            hy.llvm_state.set_diskcache_enabled(self.enabled and self.threads == 0)


_switch = _Switch()


@contextmanager
def without_heyokas_cache() -> Iterator[None]:
    """Switch heyoka's cache on disk off within the block: the host of this package may use it."""
    _switch.change(+1)
    try:
        yield
    finally:
        _switch.change(-1)


@cache
def _processor() -> str:
    """Return the description of the first processor, for machine code is made for its instructions."""
    try:
        first, _, _ = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").partition("\n\n")
    except OSError:  # not Linux
        return ""
    return "\n".join(line for line in first.splitlines() if line.startswith(("model name", "flags", "Features")))

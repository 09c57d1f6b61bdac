"""Integrators and functions of heyoka on disk: their machine code is loaded only if its checksum is
right.

heyoka's own cache is one database without checksums, readable and writable as the umask of the
process allows. A damaged object in it gives wrong numbers or ends the process, so nothing is
compiled through it here.

To write machine code is to run it, so the folder must be writable by its user only. If a file is
damaged, the code is compiled again.
"""

import hashlib
import os
import pickle
import secrets
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import heyoka as hy

from tippetop_kernels.compilation import cache_folder, private_folder


LARGEST = 256 * 2**20
"""Bytes of all files together; those not used for longest are removed first."""

MAGIC = b"tippetop kernel 2\n"
HEAD = len(MAGIC) + 64


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
    folder = private_folder(cache_folder())
    file = folder and folder / f"{kind.__name__}-{key.hex()}"
    if file and (known := _read(file, key)):
        return pickle.loads(zlib.decompress(known))
    with without_heyokas_cache():
        result = kind(*arguments, **options)
    if file:
        with suppress(OSError):
            _write(file, key, zlib.compress(pickle.dumps(result), level=1))
            _remove_oldest(file.parent)
    return result


# --- files --------------------------------------------------------------------------------------


def _read(file: Path, key: bytes) -> bytes | None:
    """Return the content of a file, or None if it is missing or damaged."""
    with suppress(OSError):
        content = file.read_bytes()
        payload = content[HEAD:]
        if content[:HEAD] == _head(key, payload):
            os.utime(file)
            return payload
    return None


def _head(key: bytes, payload: bytes) -> bytes:
    return MAGIC + key + hashlib.sha256(payload).digest()


def _write(file: Path, key: bytes, payload: bytes) -> None:
    """Write a file and rename it: another process reads the old one or the new one."""
    scratch = file.with_name(f".{file.name}.{secrets.token_hex(8)}")
    try:
        scratch.write_bytes(_head(key, payload) + payload)
        scratch.replace(file)
    finally:
        scratch.unlink(missing_ok=True)


def _remove_oldest(folder: Path) -> None:
    """Remove the files that were not used for longest, until the others are small
    enough together.
    """
    files = sorted(
        (path for path in folder.iterdir() if path.is_file()),
        key=lambda path: path.stat().st_mtime_ns,
    )
    total = sum(path.stat().st_size for path in files)
    while files and total > LARGEST:
        oldest = files.pop(0)
        total -= oldest.stat().st_size
        oldest.unlink()


# --- heyoka's own cache -------------------------------------------------------------------------


class _Switch:
    """heyoka's cache on disk, which is off while any thread is within `without_heyokas_cache`."""

    def __init__(self) -> None:
        self.lock, self.threads, self.enabled = threading.Lock(), 0, True

    def change(self, threads: int) -> None:
        """Count threads that enter or leave; the first one switches the cache off, the last one
        restores it.
        """
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
    """Return the description of the first processor, for machine code is made for its
    instructions.
    """
    try:
        first, _, _ = (
            Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").partition("\n\n")
        )
    except OSError:  # not Linux
        return ""
    return "\n".join(
        line for line in first.splitlines() if line.startswith(("model name", "flags", "Features"))
    )

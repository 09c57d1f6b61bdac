"""Integrators and functions of heyoka on disk: their machine code is loaded only if its checksum is right.

heyoka's own cache is one database without checksums, readable and writable as the umask of the process allows. A
damaged object in it gives wrong numbers or ends the process, so nothing is compiled through it here.
"""

import hashlib
import pickle
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import heyoka as hy

from tippetop_kernels import disk


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
    known = disk.read(kind.__name__, key)
    if known is not None:
        return pickle.loads(zlib.decompress(known))
    with without_heyokas_cache():
        result = kind(*arguments, **options)
    disk.write(kind.__name__, key, zlib.compress(pickle.dumps(result), level=1))
    return result


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

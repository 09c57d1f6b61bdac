"""Cache integrators and functions that heyoka has compiled on disk.

Machine code is loaded only from a file that belongs to this user alone, and only if its SHA-256
digest is right.

heyoka's own cache is one database without checksums, readable and writable as the umask of the
process allows. A damaged object in it gives wrong numbers or ends the process, so nothing is
compiled through it here.

To write machine code is to run it, so the folder must be writable by its user only. If a file is
damaged, under another name, or being written by another process, the code is compiled again.
"""

import hashlib
import os
import pickle
import threading
import zlib
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import heyoka as hy
import llvmlite.binding as llvm

from tippetop_kernels.compilation import cache_folder, is_private


KEPT = 1000
"""Files, of some 0.2 MB each; the most recently used are kept."""

DIGEST = 32
"""Bytes in front of a file: the SHA-256 digest of its key and of the rest."""

_compiling = threading.Lock()


def compiled_once(kind: Callable, *arguments: Any, **options: Any) -> Any:
    """Return `kind(*arguments, **options)`, from disk if an earlier process has compiled it.

    Parameters
    ----------
    kind
        A function of heyoka that compiles: `taylor_adaptive`, `taylor_adaptive_batch` or `cfunc`.
    *arguments, **options
        Its arguments. Their pickle is the key, so equal ones must have equal pickles.

    Returns
    -------
    object
        What `kind` returns.
    """
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    made_from = (hy.__version__, processor, kind.__name__, arguments, options)
    key = hashlib.sha256(pickle.dumps(made_from)).hexdigest()
    folder = cache_folder()
    file = folder and folder / f"{kind.__name__}-{key}.z"
    if file:
        with suppress(OSError), file.open("rb") as stored:
            digest = stored.read(DIGEST)
            code = stored.read()
            if is_private(os.fstat(stored.fileno())) and digest == _digest(key, code):
                os.utime(file)
                return pickle.loads(zlib.decompress(code))
    with _compiling:  # heyoka's switch is one for all threads, and its setting the host's
        enabled = hy.llvm_state.get_diskcache_enabled()
        hy.llvm_state.set_diskcache_enabled(False)
        try:
            result = kind(*arguments, **options)
        finally:
            hy.llvm_state.set_diskcache_enabled(enabled)
    if file:
        with suppress(OSError):
            code = zlib.compress(pickle.dumps(result), level=1)
            file.unlink(missing_ok=True)  # it may belong to another user
            file.touch(0o600)
            file.write_bytes(_digest(key, code) + code)
            for old in sorted(file.parent.glob("*.z"), key=os.path.getmtime)[:-KEPT]:
                old.unlink()
    return result


def _digest(key: str, code: bytes) -> bytes:
    """Return the checksum of a cached file, DIGEST bytes: of its key and its content.

    With the key, a file under another name is rejected.
    """
    return hashlib.sha256(key.encode() + code).digest()

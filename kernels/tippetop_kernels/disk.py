"""Compiled kernels kept on disk, so that the next process need not compile: found by their digest, or not at all.

A file holds a pickle and machine code: whoever can write it can run code as us. So the folder and the file must be our
own and nobody else's to write, and nothing is read through links. A checksum makes of a damaged file a missing one.
Whatever goes wrong here, the kernel is compiled, as it would be without: numba's own cache forgets formulas in other
files (numba#1833), and knows no functions as arguments.
"""

import contextlib
import hashlib
import io
import logging
import os
import pickle
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import NumbaPickler

from .origin import Foreign, digest, dispatchers


LARGEST = 256 * 2**20  # [B] of all files together; those not used for longest go first
MAGIC = b"tippetop kernel 1\n"
log = logging.getLogger("tippetop.kernels")


def folder() -> Path | None:
    """Where machine code is kept: TIPPETOP_CACHE_DIR, or tippetop in the user's folder of caches; None: nowhere.

    Returns
    -------
    Path or None
        None where TIPPETOP_CACHE_DIR is empty, or there is no home.
    """
    given = os.environ.get("TIPPETOP_CACHE_DIR")
    if given is not None:
        return Path(given).absolute() if given else None
    caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(caches) / "tippetop" / "kernels" if os.path.isabs(caches) else None


class DiskCache(_Cache):
    """The cache of one kernel, as numba asks for it."""

    def __init__(self, dispatcher: Dispatcher):
        self._dispatcher = dispatcher
        self._enabled = True

    @property
    def cache_path(self) -> str | None:
        """Where it is."""
        path = folder()
        return None if path is None else str(path)

    def enable(self) -> None:
        """Use it."""
        self._enabled = True

    def disable(self) -> None:
        """Use it no more."""
        self._enabled = False

    def flush(self) -> None:
        """Nothing is ever stale."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for the types `sig`, or None."""
        target_context.refresh()
        with _unharmed("load"), _directory(create=False) as directory:
            key = digest(self._dispatcher, sig, target_context.codegen())
            payload = _read(directory, _name(self._dispatcher, key), key)
            if payload is not None:
                return CompileResult._rebuild(target_context, *_loads(payload, dispatchers(sig)))
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keeps the compiled kernel `data` for the types `sig`."""
        if data.objectmode or data.lifted or data.library.has_dynamic_globals:  # addresses of this process
            return
        with _unharmed("save"), _directory(create=True) as directory:
            key = digest(self._dispatcher, sig, data.codegen)
            payload = _dumps(data._reduce(), dispatchers(sig))
            _write(directory, _name(self._dispatcher, key), key, payload)
            _shrink(directory)


class _Unusable(Exception):
    """A folder or file that is not ours alone, is damaged, or is switched off."""


@contextlib.contextmanager
def _unharmed(what: str) -> Iterator[None]:
    try:
        yield
    except (FileNotFoundError, Foreign, _Unusable) as reason:
        log.debug("no %s of machine code: %s", what, reason)
    except Exception as fault:  # private parts of numba may change: it then compiles
        log.info("no %s of machine code: %r", what, fault)


# --- pickles in which functions are numbers ---------------------------------------------------------------------------


class _Pickler(NumbaPickler):
    """Functions that a kernel was given become their numbers: they are others in each process."""

    def __init__(self, file: Any, given: list):
        super().__init__(file, protocol=5)
        self._numbers = {id(function): i for i, function in enumerate(given)}

    def persistent_id(self, thing: Any) -> int | None:
        """The number of a function; None: pickle it."""
        if isinstance(thing, Dispatcher) and id(thing) not in self._numbers:
            raise Foreign(repr(thing))
        return self._numbers.get(id(thing))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: Any, given: list):
        super().__init__(file)
        self._given = given

    def persistent_load(self, number: int) -> Any:
        """The function of a number."""
        return self._given[number]


def _dumps(data: Any, given: list) -> bytes:
    with io.BytesIO() as buffer:
        _Pickler(buffer, given).dump(data)
        return buffer.getvalue()


def _loads(payload: bytes, given: list) -> Any:
    return _Unpickler(io.BytesIO(payload), given).load()


# --- files ------------------------------------------------------------------------------------------------------------


def _name(dispatcher: Dispatcher, key: bytes) -> str:
    return f"{dispatcher.py_func.__name__}-{key.hex()}"


@contextlib.contextmanager
def _directory(*, create: bool) -> Iterator[int]:
    """The folder, open: what is checked is what is used."""
    path = folder()
    if path is None:
        raise _Unusable("switched off")
    if create:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        _only_ours(os.fstat(handle), path)
        yield handle
    finally:
        os.close(handle)


def _only_ours(status: os.stat_result, path: Any) -> None:
    if status.st_uid != os.geteuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise _Unusable(f"{path} can be written by others")


def _read(directory: int, name: str, key: bytes) -> bytes | None:
    """The payload of a file; None if it is damaged."""
    handle = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=directory)
    with open(handle, "rb") as file:
        status = os.fstat(handle)
        _only_ours(status, name)
        if not stat.S_ISREG(status.st_mode):
            raise _Unusable(f"{name} is no file")
        text = file.read()
    head, check, payload = text[: len(MAGIC) + 32], text[len(MAGIC) + 32 : len(MAGIC) + 64], text[len(MAGIC) + 64 :]
    if head != MAGIC + key or check != hashlib.sha256(payload).digest():
        return None
    with contextlib.suppress(OSError):
        os.utime(name, dir_fd=directory)  # it was used
    return payload


def _write(directory: int, name: str, key: bytes, payload: bytes) -> None:
    """Replaces a file at once: who reads it meanwhile has the old one or the new one."""
    scratch = f".{name}.{secrets.token_hex(8)}"
    handle = os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600, dir_fd=directory)
    try:
        with open(handle, "wb") as file:
            file.write(MAGIC + key + hashlib.sha256(payload).digest() + payload)
        os.replace(scratch, name, src_dir_fd=directory, dst_dir_fd=directory)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(scratch, dir_fd=directory)
        raise


def _shrink(directory: int) -> None:
    """Removes the files that were not used for longest, until the others are small enough together."""
    files = []
    for name in os.listdir(directory):
        with contextlib.suppress(OSError):
            status = os.stat(name, dir_fd=directory, follow_symlinks=False)
            files.append((status.st_mtime_ns, status.st_size, name))
    total = sum(size for _, size, _ in files)
    for _, size, name in sorted(files):
        if total <= LARGEST:
            break
        with contextlib.suppress(OSError):
            os.unlink(name, dir_fd=directory)
        total -= size

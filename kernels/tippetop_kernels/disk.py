"""The machine code of kernels on disk, so that the next process need not compile: found by its digest, or not at all.

Whoever can write a file of machine code can run code as us. So the folder and the file must be our own and nobody
else's to write, and nothing is read through links. A checksum makes of a damaged file a missing one. Whatever goes
wrong here, the kernel is compiled, as it would be without: numba's own cache forgets formulas in other files
(numba#1833), and knows no functions as arguments.
"""

import contextlib
import hashlib
import logging
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any


LARGEST = 256 * 2**20  # [B] of all files together; those not used for longest go first
MAGIC = b"tippetop kernel 2\n"
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


def read(name: str, key: bytes) -> bytes | None:
    """The machine code of a kernel.

    Parameters
    ----------
    name
        Of the kernel.
    key
        The digest of what it is made from.

    Returns
    -------
    bytes or None
        None where there is none, or none that is ours alone and whole.
    """
    code = None
    with _unharmed("load"), _directory(create=False) as directory:
        code = _read(directory, _name(name, key), key)
    return code  # noqa: RET504  # a block that may end before its end


def write(name: str, key: bytes, code: bytes) -> None:
    """Keeps the machine code of a kernel, if it can be kept.

    Parameters
    ----------
    name, key
        As for `read`.
    code
        The object file.
    """
    with _unharmed("save"), _directory(create=True) as directory:
        _write(directory, _name(name, key), key, code)
        _shrink(directory)


class _Unusable(Exception):
    """A folder or file that is not ours alone, is damaged, or is switched off."""


@contextlib.contextmanager
def _unharmed(what: str) -> Iterator[None]:
    try:
        yield
    except (FileNotFoundError, _Unusable) as reason:
        log.debug("no %s of machine code: %s", what, reason)
    except OSError as fault:
        log.info("no %s of machine code: %r", what, fault)


def _name(name: str, key: bytes) -> str:
    return f"{name}-{key.hex()}"


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

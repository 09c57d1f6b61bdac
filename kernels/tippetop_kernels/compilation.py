"""Compile kernels with numba, and keep their machine code in a folder named after our sources.

numba's own check reads the file of a function, but not those of the formulas that it calls
(numba#1833).
"""

import contextlib
import functools
import hashlib
import importlib.resources
import inspect
import os
import shutil
import stat
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np


PACKAGES = ("tippetop", "tippetop_kernels")

KEPT = 40
"""Folders of machine code, some five for each state of the sources; the most recently used are
kept.
"""

SIGNATURE = "sha256"
"""Name of the file with the digest of the machine code in a folder."""

IMPORTED = time.time()
"""Time at which this process began to import our sources, in seconds since 1970."""


# --- kernels ------------------------------------------------------------------------------------


def kernel(function: Callable, **options: Any) -> Callable:
    """Register a function that compiled code may call, and return it unchanged.

    With error_model="numpy" a division does not test for zero: 3.1 ns per potential instead of 5.7.
    """
    from numba.extending import register_jitable

    registered: Callable = register_jitable(error_model="numpy", **options)(function)
    return registered


inlined = functools.partial(kernel, forceinline=True)


class Entry:
    """A function that Python calls, compiled by numba for the types of its arguments.

    Its machine code is kept on disk if the function, and those that it encloses, are ours.

    Parameters
    ----------
    function
        A function of numbers, arrays and named tuples of them.
    """

    def __init__(self, function: Callable):
        self.function = function
        self.signed = 0  # compilations

    def __call__(self, *arguments: Any) -> Any:
        """Call the compiled function, and sign its machine code if it is new.

        Code in its folder that is not signed is removed by the next process (`code_folder`).
        """
        try:
            result = self.compiled(*arguments)
        except OSError:  # numba has compiled it, but cannot keep the code: the disk is full
            result = self.compiled(*arguments)
        made = len(self.compiled.stats.cache_misses)
        if made > self.signed and self.folder is not None:
            self.signed = made
            with contextlib.suppress(OSError):
                (self.folder / SIGNATURE).write_text(signature(self.folder, new=True))
        return result

    @functools.cached_property
    def folder(self) -> Any:
        """Return the folder of its machine code, or None if it is not kept."""
        return code_folder(self.function)

    @functools.cached_property
    def compiled(self) -> Any:
        """Return numba's dispatcher, which compiles the function for each new kind of arguments."""
        import numba

        jit = functools.partial(numba.njit, self.function, error_model="numpy", nogil=True)
        if self.folder is not None:
            # within the block, because numba chooses the folder in this call; a RuntimeError: the
            # folder is read-only
            with _numba_cache(self.folder), contextlib.suppress(RuntimeError):
                return jit(cache=True)
        return jit()


entry = Entry


# --- machine code on disk -----------------------------------------------------------------------


def cache_folder() -> Path | None:
    """Return the folder of compiled code, or None without a safe one.

    It is TIPPETOP_CACHE_DIR (none if empty), or `tippetop/kernels` in the user's folder of caches.
    """
    given = os.environ.get("TIPPETOP_CACHE_DIR")
    if given is not None:
        return private_folder(Path(given).absolute()) if given else None
    caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return private_folder(Path(caches) / "tippetop" / "kernels") if os.path.isabs(caches) else None


def is_private(status: os.stat_result) -> bool:
    """Return whether a file or folder belongs to this user and no other user can write to it."""
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def private_folder(path: Path) -> Path | None:
    """Create a folder.

    Return it, or None if another user can write to it: to write machine code is to run it.
    """
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = path.lstat()  # not `stat`: a link, whose target may change, is refused
    except OSError:
        return None
    return path if is_private(status) and stat.S_ISDIR(status.st_mode) else None


def code_folder(function: Callable) -> Path | None:
    """Make the folder of a function's machine code; return None if it must not be kept.

    There is one folder for each function with those that it encloses: two processes that write one
    index of numba at the same time can exchange the code of two functions. The folder is emptied if
    its content is not signed; of all folders the `KEPT` ones that were used last remain.
    """
    functions = function, *inspect.getclosurevars(function).nonlocals.values()
    base = cache_folder()
    digest = sources_digest()
    ours = all(f.__module__.partition(".")[0] in PACKAGES for f in functions)
    if base is None or digest is None or not ours:
        return None
    key = repr((digest, [f"{f.__module__}.{f.__qualname__}" for f in functions]))
    folder = private_folder(base / f"numba-{hashlib.sha256(key.encode()).hexdigest()[:16]}")
    if folder is not None:
        with contextlib.suppress(OSError):  # another process may remove them too
            os.utime(folder)  # its last use, by which folders are sorted
            for old in sorted(base.glob("numba-*"), key=os.path.getmtime)[:-KEPT]:
                shutil.rmtree(old, ignore_errors=True)
        with contextlib.suppress(OSError, ValueError):
            if (folder / SIGNATURE).read_text() == signature(folder):
                return folder
        shutil.rmtree(folder, ignore_errors=True)
        folder = private_folder(folder)
    return folder


def signature(folder: Path, *, new: bool = False) -> str:
    """Return a digest of the files of numba in a folder, which are made private if they are new.

    Raises OSError if another user owns or can write one of them, which `code_folder` takes for a
    wrong digest.
    """
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.nb?")):
        with path.open("rb") as file:
            if new:
                os.fchmod(file.fileno(), 0o600)
            if not is_private(os.fstat(file.fileno())):
                raise PermissionError(path)
            digest.update(file.read())
    return digest.hexdigest()


@functools.cache
def sources_digest() -> str | None:
    """Return a digest of our source files and of the versions of the compiler.

    None if a file was changed after this process imported it.
    """
    import llvmlite
    import numba

    sources = [numba.__version__, llvmlite.__version__, np.__version__]
    for package in PACKAGES:
        for path in sorted(Path(str(importlib.resources.files(package))).rglob("*.py")):
            if path.stat().st_ctime > IMPORTED:
                return None
            sources += [str(path), path.read_text()]
    return hashlib.sha256("\0".join(sources).encode()).hexdigest()


_settings = threading.Lock()


@contextlib.contextmanager
def _numba_cache(folder: Path) -> Iterator[None]:
    """Let numba keep machine code in a folder within the block; its settings belong to the host."""
    from numba import config

    ours = {"CACHE_DIR": str(folder), "CACHE_LOCATOR_CLASSES": ""}
    with _settings:  # for the whole block: the settings are those of all threads
        before = {name: getattr(config, name, "") for name in ours}
        vars(config).update(ours)
        try:
            yield
        finally:
            vars(config).update(before)

"""Compile kernels with numba, and keep their machine code in a folder named after our sources.

numba's own check reads the file of a function, but not those of the formulas that it calls
(numba#1833).
"""

import contextlib
import functools
import hashlib
import importlib.util
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

KEPT = 8
"""Folders of machine code, one for each state of the sources; the most recently used are kept."""

IMPORTED = time.time()
"""When this process began to import our sources, in seconds since 1970."""


# --- kernels ------------------------------------------------------------------------------------


def kernel(function: Callable, **options: Any) -> Callable:
    """Register a function that compiled code may call, and return it.

    With error_model="numpy" a division does not test for zero: 3.1 ns per potential instead of 5.7.
    """
    from numba.extending import register_jitable

    registered: Callable = register_jitable(error_model="numpy", **options)(function)
    return registered


inlined = functools.partial(kernel, forceinline=True)


class Entry:
    """A function that Python calls, compiled for each combination of types of its arguments.

    Compiled code is kept on disk if all functions and records that it depends on are ours.

    Parameters
    ----------
    function
        A function of numbers, arrays and named tuples of them; it may enclose functions.
    """

    def __init__(self, function: Callable):
        functools.update_wrapper(self, function)
        self.function = function
        self._variants: dict[tuple, Callable] = {}
        self._compiling = threading.Lock()

    def __call__(self, *arguments: Any) -> Any:
        """Call the function."""
        return self.variant(*arguments)(*arguments)

    def variant(self, *arguments: Any) -> Callable:
        """Return the function compiled for the types of these arguments."""
        kinds = tuple(map(_kind, arguments))
        with self._compiling:
            if kinds not in self._variants:
                self._variants[kinds] = self._compiled(arguments)
        return self._variants[kinds]

    def _compiled(self, arguments: tuple) -> Callable:
        import numba

        types = tuple(map(numba.typeof, arguments))
        compiled = functools.partial(numba.njit, types, error_model="numpy", nogil=True)
        if (folder := self._folder(arguments, types)) is not None:
            try:
                with _numba_cache(folder):
                    return compiled(cache=True)(self.function)
            except Exception:  # the disk is full, or two processes compile at the same time
                shutil.rmtree(folder, ignore_errors=True)
        return compiled()(self.function)

    def _folder(self, arguments: tuple, types: tuple) -> Path | None:
        """Return the folder of this machine code, or None if it must not be kept.

        Each combination of types has its own: two processes that write one index of numba at the
        same time can exchange the code of two combinations.
        """
        enclosed = inspect.getclosurevars(self.function).nonlocals.values()
        if not all(map(_is_ours, (self.function, *enclosed, *_records(arguments)))):
            return None
        names = [f"{f.__module__}.{f.__qualname__}" for f in (self.function, *enclosed)]
        key = hashlib.sha256(repr((names, types)).encode()).hexdigest()
        folder = code_folder()
        return folder and folder / key[:16]


entry = Entry


def _kind(argument: Any) -> Any:
    """Return what determines numba's type of an argument, ten times as fast as `numba.typeof`."""
    if isinstance(argument, np.ndarray):
        flags = argument.flags
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return argument.dtype, argument.ndim, layout, flags.writeable
    if isinstance(argument, tuple):
        return type(argument), *map(_kind, argument)
    return type(argument)


def _records(arguments: tuple) -> Iterator[type]:
    """Yield the classes of the named tuples among the arguments and their fields."""
    for argument in arguments:
        if isinstance(argument, tuple):
            yield type(argument)
            yield from _records(argument)


def _is_ours(thing: Any) -> bool:
    """Return whether a class or function belongs to our packages, or is built in."""
    return thing.__module__.partition(".")[0] in (*PACKAGES, "builtins")


# --- machine code on disk -----------------------------------------------------------------------


def cache_folder() -> Path | None:
    """Return the folder of compiled code, or None without one.

    It is TIPPETOP_CACHE_DIR (none if empty), or `tippetop/kernels` in the user's folder of caches.
    """
    given = os.environ.get("TIPPETOP_CACHE_DIR")
    if given is not None:
        return Path(given).absolute() if given else None
    caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(caches) / "tippetop" / "kernels" if os.path.isabs(caches) else None


def private_folder(path: Path | None) -> Path | None:
    """Create a folder.

    Return it, or None if another user can write to it: to write machine code is to run it.
    """
    if path is None:
        return None
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = path.lstat()
    except OSError:
        return None
    private = status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return path if private and stat.S_ISDIR(status.st_mode) else None


@functools.cache
def code_folder() -> Path | None:
    """Return the folder of numba's machine code for the present sources, or None if none is safe.

    Folders of other sources are removed, except for those that were used last.
    """
    base, digest = private_folder(cache_folder()), sources_digest()
    if base is None or digest is None:
        return None
    folder = private_folder(base / f"numba-{digest}")
    if folder is not None:
        os.utime(folder)
        for old in sorted(base.glob("numba-*"), key=lambda path: path.stat().st_mtime)[:-KEPT]:
            shutil.rmtree(old, ignore_errors=True)
    return folder


def sources_digest() -> str | None:
    """Return a digest of our source files and of the versions of the compiler.

    None if a file was changed after this process imported it.
    """
    import llvmlite
    import numba

    versions = numba.__version__, llvmlite.__version__, np.__version__
    total = hashlib.sha256(repr(versions).encode())
    for package in PACKAGES:
        spec = importlib.util.find_spec(package)
        for root in spec.submodule_search_locations or () if spec else ():
            for path in sorted(Path(root).rglob("*.py")):
                if path.stat().st_ctime > IMPORTED:
                    return None
                text = path.read_bytes()
                name = f"\0{package}/{path.relative_to(root)} {len(text)}\0"
                total.update(name.encode() + text)
    return total.hexdigest()[:16]


@contextlib.contextmanager
def _numba_cache(folder: Path) -> Iterator[None]:
    """Let numba keep machine code in a folder within the block; its settings belong to the host."""
    from numba import config

    ours = {"CACHE_DIR": str(folder), "CACHE_LOCATOR_CLASSES": ""}
    before = {name: getattr(config, name, "") for name in ours}
    vars(config).update(ours)
    try:
        yield
    finally:
        vars(config).update(before)

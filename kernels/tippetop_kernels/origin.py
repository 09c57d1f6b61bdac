"""What the machine code of a kernel is made from, as one digest: two that agree stand for the same code.

In it are every source file of our packages, none of them edited since this process began; the functions and constants
that are loaded of the modules that the kernel and its formulas come from (byte code may be older than its file, and
names may be bound anew); the types of the arguments; numba, LLVM, numpy, Python and their settings; the processor.
What comes from elsewhere has no digest: `Foreign` is raised.
"""

import contextlib
import enum
import functools
import hashlib
import importlib.util
import inspect
import math
import os
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np


PACKAGES = ("tippetop", "tippetop_kernels")  # whose sources are in every digest
TRUSTED = {"heyoka", "llvmlite", "numba", "numpy"}  # whose versions, and the standard library's, stand for their code
IDLE = {"NUMBA_CACHE_DIR", "NUMBA_CACHE_LOCATOR_CLASSES", "NUMBA_NUM_THREADS"}  # no bit depends on them


MAKERS = ("compiling", "disk", "jit", "machine", "origin", "words")  # they make kernels: their files count
EDIT_MARGIN = 0.05  # [s] by which the clocks of files and processes may differ


class Foreign(Exception):
    """A function or a class whose sources are not in the digest, or not for certain."""


def _began() -> float:
    """When this process began, in seconds since 1970; Linux only, elsewhere nothing is certain."""
    try:
        ticks = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
        return time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError):
        return -math.inf


BEGAN = _began()  # kept: a fork has the modules of its parent


def digest(kernel: Any, kinds: Iterable[Any]) -> bytes:
    """The digest of a kernel for arguments of some kinds.

    Parameters
    ----------
    kernel
        Of `jit`.
    kinds
        Of its arguments (see `words`).

    Raises
    ------
    Foreign
        If a formula or a record among the arguments is not a public name of our packages.
    """
    modules: set[str] = set()
    parts = [_described(kernel, modules), *(_described(kind, modules) for kind in kinds)]
    parts += [*_software(), *_processor(), files().hex(), *loaded(modules)]
    return hashlib.sha256("\0".join(parts).encode("utf-8", "surrogatepass")).digest()


# --- what a kernel is given -------------------------------------------------------------------------------------------


def _described(kind: Any, modules: set[str]) -> str:
    """The kind of an argument in words that mean the same in every process; adds the modules that it comes from."""
    if isinstance(kind, tuple) and kind[0] == "array":
        return repr(kind)
    if isinstance(kind, tuple):
        _, record, fields = kind
        name = _public(record, modules) if record is not tuple else ""
        return f"{name}({', '.join(_described(field, modules) for field in fields)})"
    if isinstance(kind, type):
        return kind.__name__
    name = _public(kind.py_func, modules)
    stages = ", ".join(_described(stage, modules) for stage in kind.stages)
    return f"{name} {kind.apart} {sorted(kind.options.items())} [{stages}]"


def _public(thing: Any, modules: set[str]) -> str:
    """The name by which a function or class of our packages is found; adds its module."""
    module, name = thing.__module__, thing.__qualname__
    owner: Any = sys.modules.get(module) if module.partition(".")[0] in PACKAGES else None
    for part in name.split("."):
        owner = getattr(owner, part, None)
    if getattr(owner, "py_func", owner) is not thing:
        raise Foreign(f"{module}.{name}")
    modules.add(module)
    return f"{module}.{name}"


# --- sources and versions ---------------------------------------------------------------------------------------------


@functools.cache
def files() -> bytes:
    """The digest of every source file of our packages. Raises Foreign if one was changed since this process began."""
    total, latest = hashlib.sha256(), BEGAN - EDIT_MARGIN
    for package in PACKAGES:
        spec = importlib.util.find_spec(package)
        roots = list(spec.submodule_search_locations or ()) if spec else []
        places = (os.path.join(folder, name) for root in roots for folder, _, names in os.walk(root) for name in names)
        paths = sorted(place for place in places if place.endswith(".py"))
        if not paths:
            raise Foreign(package)
        for path in paths:
            with open(path, "rb") as file:
                if os.fstat(file.fileno()).st_ctime > latest:
                    raise Foreign(f"{path}, changed since this process began")
                text = file.read()
            name = next(path[len(root) :] for root in roots if path.startswith(os.path.join(root, "")))
            total.update(f"\0{package}{name} {len(text)}\0".encode() + text)
    return total.digest()


@functools.cache
def _software() -> tuple[str, ...]:
    """Versions and settings."""
    from llvmlite import __version__ as llvmlite_version

    given = Path(".numba_config.yaml")
    written = given.read_text() if given.is_file() else ""
    settings = {name: value for name, value in os.environ.items() if name.startswith("NUMBA_") and name not in IDLE}
    libc = os.confstr("CS_GNU_LIBC_VERSION") if "CS_GNU_LIBC_VERSION" in os.confstr_names else None
    system = os.uname()  # `platform` would start a process to ask for the processor
    versions = (*_installed(), llvmlite_version, np.__version__, sys.version, system.sysname, system.release)
    versions += (system.machine, str(libc))
    return (*versions, repr(sorted(settings.items())), written)


def _installed() -> list[str]:
    """Names and versions of numba and of what teaches it more (`importlib.metadata` takes ten times as long)."""
    there: set[str] = set()  # an environment may have what the one below it has
    for place in sys.path:
        with contextlib.suppress(OSError):
            names = [name for name in os.listdir(place or ".") if name.endswith((".dist-info", ".egg-info"))]
            there |= {name for name in names if name.startswith("numba-") or _teaches(os.path.join(place, name))}
    return sorted(there)


def _teaches(folder: str) -> bool:
    """Whether a distribution has an extension of numba."""
    try:
        with open(os.path.join(folder, "entry_points.txt"), "rb") as file:
            return b"numba_extensions" in file.read()
    except OSError:
        return False


@functools.cache
def _processor() -> tuple[str, ...]:
    import llvmlite.binding as llvm

    return llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


# --- what is loaded ---------------------------------------------------------------------------------------------------


def loaded(modules: Iterable[str]) -> Iterator[str]:
    """The functions and constants of modules, and of those of our packages that they know, as they are in memory."""
    todo, known = sorted(modules), {*modules, *(f"{__package__}.{name}" for name in MAKERS)}
    while todo:
        name = todo.pop(0)
        others: set[str] = set()
        yield name
        for key, value in sorted(vars(sys.modules[name]).items()):
            if not (key.startswith("__") and key.endswith("__")):
                yield f"{key} = {_in_memory(value, others)}"
        todo += sorted(others - known)
        known |= others


def _in_memory(value: Any, modules: set[str]) -> str:
    """A value of a module; adds the modules of our packages that it comes from."""
    if isinstance(value, ModuleType):
        if _ours(value.__name__) and not hasattr(value, "__path__"):
            modules.add(value.__name__)
        return value.__name__
    if hasattr(value, "py_func") and not isinstance(value, type):
        stages = [_in_memory(stage, modules) for stage in value.stages]
        return f"{_in_memory(value.py_func, modules)} {value.apart} {sorted(value.options.items())} {stages}"
    for inner in ("_defn", "__wrapped__"):  # intrinsics; what functools wraps
        if isinstance(function := getattr(value, inner, None), FunctionType):
            return _in_memory(function, modules)
    if isinstance(value, FunctionType):
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        defaults = (value.__defaults__, value.__kwdefaults__, cells)
        return f"{_origin(value, modules)} {_code(value.__code__)} {[_plain(given) for given in defaults]}"
    if isinstance(value, type) and _ours(value.__module__):
        inside = [f"{key} = {_in_memory_of_class(v, modules) or _plain(v)}" for key, v in sorted(vars(value).items())]
        return f"{_origin(value, modules)} {{{', '.join(inside)}}}"
    return _plain(value)


def _in_memory_of_class(value: Any, modules: set[str]) -> str:
    return _in_memory(value, modules) if isinstance(value, FunctionType) else ""


def _origin(thing: Any, modules: set[str]) -> str:
    """The name of a function or class; adds its module if it is ours, refuses it if nothing stands for its code."""
    module = thing.__module__ or ""
    if _ours(module):
        modules.add(module)
    elif (root := module.partition(".")[0]) not in TRUSTED and root not in sys.stdlib_module_names:
        raise Foreign(f"{module}.{thing.__qualname__}")
    return f"{module}.{thing.__qualname__}"


def _ours(module: str) -> bool:
    return module.partition(".")[0] in PACKAGES and module in sys.modules


def _code(code: CodeType) -> str:
    """Byte code, names and constants, those of inner functions too; no places in files."""
    constants = [_code(c) if isinstance(c, CodeType) else _plain(c) for c in code.co_consts]
    flags = code.co_flags & ~inspect.CO_OPTIMIZED  # seen to differ between processes with the same sources
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, flags)
    return f"{code.co_name} {code.co_code.hex()} {names} [{', '.join(constants)}]"


def _plain(value: Any) -> str:
    """Numbers, texts and collections of them; of anything else its type."""
    if isinstance(value, enum.Enum):
        return f"{value!r} {value.value!r}"
    if isinstance(value, int | float | complex | str | bytes | np.generic | None):
        return repr(value)
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}" if value.dtype != object else "objects"
    if isinstance(value, tuple | list):
        return f"{type(value).__name__} {[_plain(v) for v in value]}"
    if isinstance(value, dict):
        return f"{sorted((_plain(k), _plain(v)) for k, v in value.items())}"
    if isinstance(value, set | frozenset):
        return f"{sorted(_plain(v) for v in value)}"
    return type(value).__name__

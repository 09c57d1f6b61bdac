"""The decorators that compile: nobody waits for numba before something must be compiled, and every flag is set here.

error_model="numpy": a division does not test for zero; 3.1 ns per potential instead of 5.7. No fastmath: it gained
nothing, and the compensated sums of the potential would not survive it. Arrays are lent, references to them are not
counted (`_nrt`): a loop that passes twenty arrays on spends more time with counting than with a Taylor step.
"""

import ctypes
import functools
import threading
import warnings
from array import array
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from . import disk, machine, words
from .origin import Foreign, digest


HAS_NUMBA = find_spec("numba") is not None
"""Without numba kernels are Python: the same numbers, some twenty times slower."""

Words = array  # of int64: a result, then the words of arguments
Code = Callable[[Words], int]


class Kernel:
    """A function that numba compiles when something calls it.

    Parameters
    ----------
    function
        What it is in Python.
    apart
        Whether its arrays share no memory: LLVM then fills vectors without looking, a third of the time of short loops.
    options
        Of numba.
    """

    plainly = False  # for all: numba has other private parts than `compiling` knows, and compiles as it always did

    def __init__(self, function: Callable, apart: bool = False, **options: Any):
        self.__name__: str
        self.py_func, self.stages, self.apart = function, (), apart
        self.options: dict[str, Any] = {"error_model": "numpy", "nogil": True, "_nrt": False, **options}
        functools.update_wrapper(self, function)

    @functools.cached_property
    def dispatcher(self) -> Any:
        """It as numba knows it: to be compiled into what calls it."""
        from .compiling import part

        return part(self)

    @property
    def _numba_type_(self) -> Any:
        """What numba takes it for, in the code of a kernel and among the arguments of one."""
        return (self.alone if Kernel.plainly else self.dispatcher)._numba_type_

    @functools.cached_property
    def alone(self) -> Any:
        """It as a function of numba, with all that calling it from Python takes."""
        from numba import njit

        return njit(**{**self.options, "_nrt": True})(self.py_func)

    def __call__(self, *arguments: Any) -> Any:
        """Calls it from Python."""
        return self.alone(*arguments) if HAS_NUMBA else self.py_func(*arguments)


class Entry(Kernel):
    """A kernel that Python calls by its address: its machine code, with all that is compiled into it, is kept on disk.

    Not for kernels that kernels call: those are in the code of their callers. It takes numbers, arrays, named tuples of
    them and kernels, and gives nothing or an integer. Addresses must come as arguments, not as constants of a module:
    another process has others.
    """

    def __init__(self, function: Callable, **options: Any):
        super().__init__(function, **options)
        self._codes: dict[tuple, Code | None] = {}
        self._compiling = threading.RLock()
        self.found = 0  # how often its machine code was on disk

    def __call__(self, *arguments: Any) -> int:
        """Calls it."""
        return self.on()(*arguments)

    def on(self, *first: Any) -> "Bound":
        """It with its first arguments given, which are kept alive."""
        if not HAS_NUMBA:
            _warn()
        return Bound(self, (), (), Words("q", (0,))).on(*first)

    def code(self, kinds: tuple) -> Code | None:
        """What calls its code for such arguments; None: numba does."""
        try:
            return self._codes[kinds]
        except KeyError:
            with self._compiling:
                if kinds not in self._codes:
                    self._codes[kinds] = self._found(kinds) or self._made(kinds)
            return self._codes[kinds]

    def _found(self, kinds: tuple) -> Code | None:
        """Its code from the disk."""
        key = self._key(kinds)
        kept = disk.read(self.__name__, key) if key else None
        if kept is None:
            return None
        try:
            code = _callable(self.__name__, kept)
        except ValueError as fault:
            disk.log.info("no load of machine code: %s", fault)
            return None
        self.found += 1
        return code

    def _made(self, kinds: tuple) -> Code | None:
        """Its code from numba, which is kept."""
        try:
            from .compiling import object_code

            code, lasts = object_code(self, kinds)
            called = _callable(self.__name__, code)
        except Exception as fault:  # if it is the kernel's own fault, numba says so again
            disk.log.info("numba compiles as it always did: %r", fault)
            Kernel.plainly = True
            return None
        key = self._key(kinds)
        if key and lasts:
            disk.write(self.__name__, key, code)
        return called

    def _key(self, kinds: tuple) -> bytes | None:
        try:
            return digest(self, kinds)
        except Foreign as reason:
            disk.log.debug("no machine code is kept: %s", reason)
            return None


class Bound:
    """A kernel whose first arguments are given: their arrays are looked at once.

    Parameters
    ----------
    kernel
        The kernel.
    given
        Its first arguments.
    kinds, row
        Of these arguments: their kinds, and a place for the result and their words.
    """

    def __init__(self, kernel: Entry, given: tuple, kinds: tuple, row: Words):
        self.kernel, self.given, self.kinds, self.row = kernel, given, kinds, row
        self.codes: dict[tuple, Code | None] = {}

    def on(self, *more: Any) -> "Bound":
        """It with more arguments given."""
        if not HAS_NUMBA:
            return Bound(self.kernel, self.given + tuple(map(_as_records, more)), (), self.row)
        kinds, numbers = words.of(more)
        return Bound(self.kernel, self.given + more, self.kinds + kinds, self.row + Words("q", numbers))

    def __call__(self, *others: Any) -> int:
        """Calls it with the other arguments."""
        if not HAS_NUMBA:
            return int(self.kernel.py_func(*self.given, *map(_as_records, others)) or 0)
        kinds, numbers = words.of(others)
        if kinds not in self.codes:
            self.codes[kinds] = self.kernel.code(self.kinds + kinds)
        code = self.codes[kinds]
        if code is None:
            return int(self.kernel.alone(*self.given, *others) or 0)
        return code(self.row + Words("q", numbers))


@functools.cache
def _warn() -> None:
    """Once in a process."""
    warnings.warn(
        "numba is not installed: impacts and landings are computed in plain Python, slowly; install tippetop[grids].",
        RuntimeWarning,
        stacklevel=4,
    )


def _as_records(argument: Any) -> Any:
    """An argument whose records Python reads as numba does: event.lane, not event["lane"]."""
    if isinstance(argument, tuple):
        parts = map(_as_records, argument)
        return type(argument)(*parts) if hasattr(argument, "_fields") else tuple(parts)
    return argument.view(np.recarray) if getattr(getattr(argument, "dtype", None), "names", None) else argument


def _callable(name: str, code: bytes) -> Code:
    """What calls the machine code of an entry with the numbers of its arguments; numba's runtime is there if needed."""
    try:
        loaded = machine.load(code, ("entry",))
    except ValueError:
        from .compiling import runtime

        runtime()
        loaded = machine.load(code, ("entry",))
    function = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)(loaded.addresses[0])

    def call(row: Words) -> int:
        if function(row.buffer_info()[0]):
            raise RuntimeError(f"`{name}` must come to its end, but an error stopped it")
        return row[0]

    call.library = loaded.library  # type: ignore[attr-defined]  # it owns the memory
    return call


class Intrinsic:
    """A function that writes LLVM's code: numba learns it when something that calls it is compiled."""

    def __init__(self, definition: Callable):
        self._defn = definition
        functools.update_wrapper(self, definition)  # type: ignore[arg-type]

    @functools.cached_property
    def _numba_type_(self) -> Any:
        from .compiling import intrinsic_type

        return intrinsic_type(self._defn)


kernel: Any = Kernel
inlined: Any = functools.partial(Kernel, forceinline=True)  # for a formula inside a loop that is to be vectorised
apart: Any = functools.partial(Kernel, apart=True, forceinline=True)  # the same, of arrays that share no memory
allocating: Any = functools.partial(Kernel, _nrt=True)  # makes arrays
entry: Any = Entry
allocating_entry: Any = functools.partial(Entry, _nrt=True)
intrinsic: Any = Intrinsic

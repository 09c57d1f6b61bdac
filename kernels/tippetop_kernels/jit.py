"""The decorators that compile with numba: every flag is set here, once.

error_model="numpy": a division does not test for zero; 3.1 ns per potential instead of 5.7. No fastmath: it gained
nothing, and the compensated sums of the potential would not survive it. numba's own cache is off: it is stale when a
formula in another file changes (numba#1833).
"""

from collections.abc import Callable
from typing import Any

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic as _intrinsic

from .disk import DiskCache


intrinsic: Any = _intrinsic


kernel = njit(error_model="numpy", nogil=True)
inlined = njit(
    error_model="numpy", nogil=True, forceinline=True
)  # for a formula inside a loop that is to be vectorised


def entry(function: Callable) -> Any:
    """A kernel that Python calls: its machine code, with all that is compiled into it, is kept on disk.

    Not for kernels that kernels call: those are in the code of their callers. Addresses must come as arguments, not as
    constants of a module, and symbols that LLVM is to know by name must be added before the first call: another process
    has others.
    """
    dispatcher: Any = kernel(function)
    dispatcher._cache = DiskCache(dispatcher)
    return dispatcher


@intrinsic
def lent(typing, record):
    """A named tuple whose arrays nobody counts references to, for as long as the caller has it: a loop that passes
    twenty arrays on spends more time with counting than with a Taylor step."""

    def generate(context, builder, signature, arguments):
        value, kind = arguments[0], signature.args[0]
        for i, member in enumerate(kind.types):
            if isinstance(member, types.Array):
                array = context.make_array(member)(context, builder, value=builder.extract_value(value, i))
                array.meminfo = cgutils.get_null_value(array.meminfo.type)
                array.parent = cgutils.get_null_value(array.parent.type)
                value = builder.insert_value(value, array._getvalue(), i)
        return value

    return record(record), generate

"""The machine code of a Taylor integrator that was compiled elsewhere, called by its addresses.

step(state, pars, time, h, tc) makes one step in place, and dense(out, tc, h) gives the state at h after the beginning
of the step. All are arrays of doubles.
"""

import ctypes
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from .jit import intrinsic
from .machine import load as load_object


class MachineCode(NamedTuple):
    """The functions of an integrator in memory."""

    engine: Any  # owns the memory
    step: int  # addresses
    dense: int


def load(code: bytes, libraries: Iterable[str] = (), names: tuple[str, str] = ("step", "d_out_f")) -> MachineCode:
    """Loads an object file into memory.

    Parameters
    ----------
    code
        The object file.
    libraries
        Paths of shared libraries whose functions it calls.
    names
        Of the two functions.

    Returns
    -------
    MachineCode

    Raises
    ------
    ValueError
        If it is no object of this machine, or a function is missing that it calls or has.
    """
    engine, addresses = load_object(code, names, libraries)
    return MachineCode(engine, *addresses)


def call(address: int, *arrays: np.ndarray) -> None:
    """Calls one of the functions from Python: `step` with five arrays, `dense` with three.

    Parameters
    ----------
    address
        Of the function.
    arrays
        Doubles, contiguous.
    """
    if not all(array.dtype == np.float64 and array.flags.c_contiguous for array in arrays):
        raise ValueError("the arrays of a step must be contiguous doubles")
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(arrays))(address)(*(array.ctypes.data for array in arrays))


def _calling(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Calls the address that is the first argument, with pointers to the numbers of the others."""
    from llvmlite import ir

    pointer = ir.IntType(8).as_pointer()
    pointers = [
        builder.bitcast(context.make_array(kind)(context, builder, value=array).data, pointer)
        for kind, array in zip(signature.args[1:], arguments[1:], strict=True)
    ]
    function = ir.FunctionType(ir.VoidType(), [pointer] * len(pointers)).as_pointer()
    builder.call(builder.inttoptr(arguments[0], function), pointers)
    return context.get_dummy_value()


@intrinsic
def call_step(typing, address, state, pars, time, h, tc):
    """One step in place: h is the longest that is allowed, and then the one that was made."""
    from numba import types

    return types.void(address, state, pars, time, h, tc), _calling


@intrinsic
def call_dense(typing, address, out, tc, h):
    """The state at h after the beginning of a step, into out."""
    from numba import types

    return types.void(address, out, tc, h), _calling

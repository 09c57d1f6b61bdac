"""Arguments of a kernel as a row of 64-bit words, and what they are: what a call from Python needs, without numba.

A number is a word; an array is its address, shape and strides; a tuple is its fields, one after another; a kernel is
nothing, as it is compiled in. A kind is what is compiled for an argument: `int`, `float` or `bool`; ("array", dtype,
dimensions, flags); ("tuple", class, kinds of the fields); or the kernel itself.
"""

import struct
from ctypes import addressof, c_char
from typing import Any

import numpy as np


C_ORDER, F_ORDER, ALIGNED, WRITEABLE = 0x1, 0x2, 0x100, 0x400  # of numpy's `flags.num`
_first: Any = c_char
FLAGS = C_ORDER | F_ORDER | ALIGNED | WRITEABLE


def of(arguments: tuple) -> tuple[tuple, list[int]]:
    """The kinds of arguments, and their words.

    Parameters
    ----------
    arguments
        int, float, bool, arrays, tuples of them, kernels.

    Returns
    -------
    tuple
        A kind each.
    list of int
        Words, signed.

    Raises
    ------
    TypeError
        If an argument is something else.
    """
    numbers: list[int] = []
    return tuple([_taken(argument, numbers) for argument in arguments]), numbers


def _address(array: np.ndarray) -> int:
    """Where the numbers of an array are."""
    try:
        return addressof(_first.from_buffer(array))  # a third of the time of the other, for fifty arrays of a run
    except (ValueError, TypeError, BufferError):  # empty, read-only, or with gaps
        return int(array.ctypes.data)


def _taken(argument: Any, numbers: list[int]) -> Any:
    """The kind of an argument; adds its words."""
    if isinstance(argument, np.ndarray):
        flags = argument.flags.num & FLAGS
        if flags & C_ORDER:  # so is one with a single row in the other order too: it is no other kind for that
            flags &= ~F_ORDER
        if not flags & ALIGNED or argument.dtype.hasobject:
            raise TypeError(f"an array must be aligned and of numbers, but is {argument.dtype}")
        numbers.append(_address(argument))
        numbers += argument.shape
        numbers += argument.strides
        return "array", argument.dtype, argument.ndim, flags
    if isinstance(argument, tuple):
        return "tuple", type(argument), tuple([_taken(field, numbers) for field in argument])
    if isinstance(argument, bool | np.bool_):
        numbers.append(int(argument))
        return bool
    if isinstance(argument, float):
        numbers += struct.unpack("<q", struct.pack("<d", argument))
        return float
    if isinstance(argument, int | np.int64):
        numbers.append(int(argument))
        return int
    if hasattr(argument, "py_func"):
        return argument
    raise TypeError(f"a kernel takes numbers, arrays, tuples and kernels, but got {type(argument).__name__}")

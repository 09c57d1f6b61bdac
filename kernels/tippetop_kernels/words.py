"""Arguments of a kernel as a row of 64-bit words, and what they are: what a call from Python needs, without numba.

A number is a word; an array is its address, shape and strides; a tuple is its fields, one after another; a kernel is
nothing, as it is compiled in.
"""

import struct
from typing import Any, NamedTuple

import numpy as np


class ArrayKind(NamedTuple):
    """What is compiled for an array."""

    dtype: np.dtype
    ndim: int
    layout: str  # "C", "F" or "A"
    readonly: bool


class TupleKind(NamedTuple):
    """What is compiled for a tuple or a named tuple."""

    record: type
    fields: tuple


def of(arguments: tuple) -> tuple[tuple, list[int]]:
    """The kinds of arguments, and their words.

    Parameters
    ----------
    arguments
        int, float, bool, arrays, tuples of them, kernels.

    Returns
    -------
    tuple
        A kind each: int, float, bool, ArrayKind, TupleKind, or the kernel itself.
    list of int
        Words, signed.

    Raises
    ------
    TypeError
        If an argument is something else.
    """
    numbers: list[int] = []
    return tuple(_taken(argument, numbers) for argument in arguments), numbers


def _taken(argument: Any, numbers: list[int]) -> Any:
    """The kind of an argument; adds its words."""
    if isinstance(argument, np.ndarray):
        flags = argument.flags
        if not flags.aligned or argument.dtype.hasobject:
            raise TypeError(f"an array must be aligned and of numbers, but is {argument.dtype}")
        numbers += (argument.ctypes.data, *argument.shape, *argument.strides)
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return ArrayKind(argument.dtype, argument.ndim, layout, not flags.writeable)
    if isinstance(argument, tuple):
        return TupleKind(type(argument), tuple(_taken(field, numbers) for field in argument))
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

"""Calls machine code that was compiled elsewhere: an object file becomes addresses, and a kernel calls an address.

The code is that of a Taylor integrator: step(state, pars, time, h, tc) makes one step in place, and dense(out, tc, h)
gives the state at h after the beginning of the step. All are arrays of doubles.
"""

import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types

from .jit import entry, intrinsic


class MachineCode(NamedTuple):
    """MachineCode code in memory."""

    engine: Any  # owns the memory
    step: int  # addresses
    dense: int


def undefined_symbols(code: bytes) -> list[str]:
    """The names that an ELF object (64 bits, little-endian) expects from elsewhere.

    Parameters
    ----------
    code
        The object file.

    Returns
    -------
    list of str

    Raises
    ------
    ValueError
        If it is none.
    """
    if code[:6] != b"\x7fELF\x02\x01":
        raise ValueError("an object must be a 64-bit little-endian ELF file")
    try:
        (table,), (size, count) = struct.unpack_from("<Q", code, 40), struct.unpack_from("<HH", code, 58)
        sections = [struct.unpack_from("<IIQQQQIIQQ", code, table + i * size) for i in range(count)]
        names = []
        for _, kind, _, _, start, length, link, _, _, entry in sections:
            if kind != 2:  # not the table of symbols
                continue
            for place in range(start + entry, start + length, entry):
                name, _, _, section = struct.unpack_from("<IBBH", code, place)
                if section == 0 and name:
                    begin = sections[link][4] + name
                    names.append(code[begin : code.index(b"\0", begin)].decode())
    except (struct.error, IndexError, OverflowError) as error:
        raise ValueError(f"an object must be a whole ELF file: {error}") from None
    return names


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
    for library in libraries:
        llvm.load_library_permanently(library)
    missing = [name for name in undefined_symbols(code) if llvm.address_of_symbol(name) is None]
    if missing:  # LLVM would abort the process
        raise ValueError(f"the functions that an object calls must be there, but {', '.join(missing)} are missing")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    step, dense = (engine.get_function_address(name) for name in names)
    if not (step and dense):
        raise ValueError(f"an object must have the functions {' and '.join(names)}")
    return MachineCode(engine, step, dense)


def _calling(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Calls the address that is the first argument, with pointers to the numbers of the others."""
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
    return types.void(address, state, pars, time, h, tc), _calling


@intrinsic
def call_dense(typing, address, out, tc, h):
    """The state at h after the beginning of a step, into out."""
    return types.void(address, out, tc, h), _calling


@entry
def first_step(step, state, pars, time, h, tc):
    """One step, called from Python."""
    call_step(step, state, pars, time, h, tc)

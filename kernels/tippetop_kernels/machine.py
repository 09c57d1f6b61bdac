"""An object file becomes addresses: by LLVM's own loader, without a compiler."""

import ctypes
import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

import llvmlite.binding as llvm


class Loaded(NamedTuple):
    """The functions of an object file in memory."""

    engine: Any  # owns the memory
    addresses: tuple[int, ...]  # of the functions that were asked for


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


def load(code: bytes, names: tuple[str, ...], libraries: Iterable[str] = ()) -> Loaded:
    """Loads an object file into memory.

    Parameters
    ----------
    code
        The object file.
    names
        Of the functions that are asked for.
    libraries
        Paths of shared libraries whose functions it calls.

    Returns
    -------
    Loaded

    Raises
    ------
    ValueError
        If it is no object of this machine, or a function is missing that it calls or must have.
    """
    for library in libraries:
        llvm.load_library_permanently(library)
    missing = [name for name in undefined_symbols(code) if not _is_known(name)]
    if missing:  # LLVM would abort the process
        raise ValueError(f"the functions that an object calls must be there, but {', '.join(missing)} are missing")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple().create_target_machine(jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    addresses = tuple(engine.get_function_address(name) for name in names)
    if not all(addresses):
        raise ValueError(f"an object must have the functions {' and '.join(names)}")
    return Loaded(engine, addresses)


def _is_known(name: str) -> bool:
    """Whether LLVM finds a function, after those of C in this process are made known to it."""
    if llvm.address_of_symbol(name) is None:
        function = getattr(ctypes.CDLL(None), name, None)
        if function is None:
            return False
        llvm.add_symbol(name, ctypes.cast(function, ctypes.c_void_p).value)
    return True

"""An object file becomes addresses: by LLVM's own loader, without a compiler."""

import ctypes
import itertools
import struct
from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple


try:
    import llvmlite.binding as llvm
except ModuleNotFoundError:  # it comes with numba; without it nothing is loaded
    llvm = None


class Loaded(NamedTuple):
    """The functions of an object file in memory."""

    library: Any  # owns the memory
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
        If it is no object of this machine, or a function is missing that it calls or must have; without llvmlite.
    """
    if llvm is None:
        raise ValueError("llvmlite must be there to load an object, but it is not installed")
    for library in libraries:
        llvm.load_library_permanently(library)
    called = {name: _address(name) for name in undefined_symbols(code)}
    if missing := [name for name, address in called.items() if address is None]:
        raise ValueError(f"the functions that an object calls must be there, but {', '.join(missing)} are missing")
    builder = llvm.JITLibraryBuilder().add_object_img(code)
    for name, address in called.items():
        builder.import_symbol(name, address)
    for name in names:
        builder.export_symbol(name)
    try:
        library = builder.link(_linker(), f"object-{next(_numbers)}")
    except RuntimeError as error:
        raise ValueError(f"an object must have the functions {' and '.join(names)}, but: {error}") from None
    return Loaded(library, tuple(library[name] for name in names))


_numbers = itertools.count()


@lru_cache(maxsize=1)
def _linker() -> Any:
    """LLVM's linker of objects in memory. It puts all parts of an object into one piece of memory: its older one asks
    for them one by one, and ends the process where two are more than 2 GiB apart, as they are in one that is large."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler(use_jit_link=True)


def _address(name: str) -> int | None:
    """Where a function is that LLVM or the C library of this process knows; None: nowhere."""
    address = llvm.address_of_symbol(name)
    if address is None and (function := getattr(ctypes.CDLL(None), name, None)) is not None:
        address = ctypes.cast(function, ctypes.c_void_p).value
    return address

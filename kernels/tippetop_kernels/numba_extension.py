"""Entry point of numba, which calls `begin` in every program before its first compilation.

It imports nothing: a program that does not use tippetop does not load it.
"""

from collections.abc import Callable


_teachers: list[Callable[[], None]] = []
_begun: list[bool] = []


def begin() -> None:
    """Teach numba what has been imported, and from now on what will be."""
    _begun.append(True)
    for teach in _teachers:
        teach()


def at_beginning(teach: Callable[[], None]) -> None:
    """Call a function before numba compiles anything, or now if it has begun."""
    _teachers.append(teach)
    if _begun:
        teach()

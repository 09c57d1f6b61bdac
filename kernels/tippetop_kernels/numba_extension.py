"""Entry point of numba, which calls `begin` in every program before its first compilation.

It imports nothing: a program that does not use tippetop does not load it.
"""

import sys


def begin() -> None:
    """Teach numba the formulas, if a program uses tippetop."""
    operand = sys.modules.get("tippetop.mechanics.operand")
    if operand is not None:
        operand.teach_numba()

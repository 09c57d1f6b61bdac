"""The machine code of heyoka's Taylor steps, loaded by LLVM: the compiled loop calls its addresses.

step(state, pars, time, h, tc) makes one step in place: h is the longest allowed step, and then the one that was made.
dense(out, tc, h) writes the state at h after the beginning of the step. All are arrays of doubles.
"""

import ctypes
import itertools
import sys
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import heyoka as hy
import llvmlite.binding as llvm
import numpy as np


UNKNOWN, SEPARATE, FUSED = range(3)
"""How compiled code rounds a product and the difference that takes it; `loop.c` has the same numbers."""

TRIALS = 4
"""Random polynomials by which the rounding is recognised."""


class MachineCode(NamedTuple):
    """The functions of an integrator in memory."""

    library: Any  # owns the memory
    step: int  # addresses
    dense: int


def load(code: bytes) -> MachineCode:
    """Load the object file of an integrator. Raises RuntimeError if a function that it calls or has is missing."""
    builder = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
    library = builder.export_symbol("step").export_symbol("d_out_f").link(_linker(), f"step-{next(_numbers)}")
    return MachineCode(library, library["step"], library["d_out_f"])


_numbers = itertools.count()


@cache
def _linker() -> Any:
    """Return LLVM's linker of objects in memory.

    It puts all parts of an object into one piece of memory. LLVM's older linker asks for them one by one, and ends the
    process where two are more than 2 GiB apart, as they may be in a large process.
    """
    extension = sys.modules[hy.expression.__module__]  # it brings the libraries whose functions heyoka's code calls
    llvm.load_library_permanently(extension.__file__)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler(use_jit_link=True)


def call(address: int, *arrays: np.ndarray) -> None:
    """Call one of the functions: `step` with five arrays, `dense` with three, contiguous doubles."""
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(arrays))(address)(*(array.ctypes.data for array in arrays))


def rounding_of(dense: int, variables: int, order: int) -> int:
    """Return how a dense output rounds its compensated sums. UNKNOWN if neither way has its bits, or both have."""
    random = np.random.default_rng(order)
    alike = {SEPARATE, FUSED}
    for _ in range(TRIALS):
        tc, h = random.normal(size=(variables, order + 1, 1)), random.uniform(0.5, 1.0, 1)
        tc[:, 0] = -(tc[:, 1:, 0] @ h ** np.arange(1, order + 1))[:, None]  # only rounding is left
        out = np.zeros((variables, 1))
        call(dense, out, tc, h)
        polynomials, given = tc[..., 0].tolist(), out[:, 0].tolist()
        alike = {kind for kind in alike if given == [_sum(c, float(h[0]), kind) for c in polynomials]}
        if len(alike) < 2:
            break
    return alike.pop() if len(alike) == 1 else UNKNOWN


def _sum(coefficients: list[float], h: float, kind: int) -> float:
    """Return the compensated sum of a polynomial."""
    (total, *others), rest, power = coefficients, 0.0, h
    for c in others:
        more = c * power - rest if kind == SEPARATE else float(Fraction(c) * Fraction(power) - Fraction(rest))
        new = total + more
        rest = (new - total) - more
        total, power = new, power * h
    return total

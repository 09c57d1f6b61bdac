"""Taylor steps of heyoka, made by one of two steppers.

`Loaded` is heyoka's machine code, loaded by LLVM: the compiled loop calls its addresses. `Called`
is an integrator that Python calls: where code cannot be loaded, and for numbers wider than doubles.

step(state, pars, time, h, tc) makes one step in place: h is the longest allowed step, and then the
one that was made. dense(out, tc, h) writes the state at h after the beginning of the step. All are
arrays of doubles.
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


TRIALS = 4
"""Random polynomials by which the rounding of code is recognised."""


class Loaded(NamedTuple):
    """The functions of an integrator in memory."""

    library: Any  # owns the memory
    step: int  # addresses
    dense: int
    fused: bool = False  # whether `dense` rounds a product and the difference that takes it once


def load(code: bytes) -> Loaded:
    """Load the object file of an integrator.

    Raises RuntimeError if a function that it calls or has is missing.
    """
    builder = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
    library = (
        builder.export_symbol("step")
        .export_symbol("d_out_f")
        .link(_linker(), f"step-{next(_numbers)}")
    )
    return Loaded(library, library["step"], library["d_out_f"])


class Called:
    """An integrator of heyoka whose steps the loop calls back: one run, or the lanes of a batch.

    For doubles, its numbers have the bits of the loaded code. A subclass may keep state, time and
    coefficients in wider numbers and write them rounded to the arrays of the loop. It may also
    correct the time at which the step starts (`start_high` and `start_low`, `high` and `low`); a
    run is finished where `h` is equal to `limit`.

    Parameters
    ----------
    integrator
        For this stepper alone.

    Attributes
    ----------
    records
        Those of the loop that calls it.
    """

    records: dict[str, Any]

    def __init__(self, integrator: Any):
        self.integrator = integrator
        self.lanes = integrator.state.shape[1:]  # () for one run

    def step(self, motion: Any) -> None:
        """Make a step from `motion.state`, at most `motion.limit` long.

        Write its end, its length and coefficients.
        """
        ta = self.integrator
        ta.state[:], ta.pars[:] = (
            motion.state.reshape(ta.state.shape),
            motion.pars.reshape(ta.pars.shape),
        )
        if (
            self.lanes
        ):  # dense output counts from the start of the step, exactly, where that is at zero
            ta.set_time(0.0)
            ta.step(motion.limit.tolist(), write_tc=True)
            motion.h[:] = [h for _, h in ta.step_res]
        else:
            ta.time = 0.0
            motion.h[0] = ta.step(float(motion.limit[0]), write_tc=True)[1]
        motion.state[:], motion.tc[:] = (
            ta.state.reshape(motion.state.shape),
            ta.tc.reshape(motion.tc.shape),
        )

    def state_at(self, inside: np.ndarray) -> np.ndarray:
        """Return the states (variables, lanes) at times `inside` (lanes,) since the start of the
        present step.
        """
        times = inside if self.lanes else float(inside[0])
        return self.integrator.update_d_output(times).reshape(-1, len(inside))


Stepper = Loaded | Called


_numbers = itertools.count()


@cache
def _linker() -> Any:
    """Return LLVM's linker of objects in memory.

    It puts all parts of an object into one piece of memory. LLVM's older linker asks for them one
    by one, and ends the process where two are more than 2 GiB apart, as they may be in a large
    process.
    """
    extension = sys.modules[
        hy.expression.__module__
    ]  # it brings the libraries whose functions heyoka's code calls
    llvm.load_library_permanently(extension.__file__)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler(use_jit_link=True)


def call(address: int, *arrays: np.ndarray) -> None:
    """Call one of the functions: `step` with five arrays, `dense` with three,
    contiguous doubles.
    """
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(arrays))(address)(
        *(array.ctypes.data for array in arrays)
    )


def is_fused(dense: int, variables: int, order: int) -> bool:
    """Return whether a dense output rounds a product and the difference that takes it once, in
    compensated sums.
    """
    random = np.random.default_rng(order)
    for _ in range(TRIALS):
        tc, h = random.normal(size=(variables, order + 1, 1)), random.uniform(0.5, 1.0, 1)
        tc[:, 0] = -(tc[:, 1:, 0] @ h ** np.arange(1, order + 1))[:, None]  # only rounding is left
        out = np.zeros((variables, 1))
        call(dense, out, tc, h)
        if out[:, 0].tolist() != [_sum(c, float(h[0])) for c in tc[..., 0].tolist()]:
            return False
    return True


def _sum(coefficients: list[float], h: float) -> float:
    """Return the compensated sum of a polynomial, with fused products."""
    (total, *others), rest, power = coefficients, 0.0, h
    for c in others:
        more = float(Fraction(c) * Fraction(power) - Fraction(rest))
        new = total + more
        rest = (new - total) - more
        total, power = new, power * h
    return total

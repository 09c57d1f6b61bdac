"""Make Taylor steps by the code that heyoka has compiled, in one of two ways.

`Loaded` is heyoka's machine code in memory, whose functions the loop calls by their addresses.
`Called` is a Python object whose methods the loop calls, for numbers wider than doubles.

step(state, pars, time, h, tc, tape) makes one step in place: h is the longest allowed step, and
then the one that was made; code in heyoka's compact mode works on the tape, other code ignores it.
dense(out, tc, h) writes the state at h after the beginning of the step. All are arrays of doubles.
"""

import itertools
import sys
from functools import cache
from typing import Any, NamedTuple

import heyoka as hy
import llvmlite.binding as llvm

from ..errors import BuildError
from .opt_level import DEFAULT


class Loaded(NamedTuple):
    """The machine code of an integrator in memory; `Loop` takes the fields by position."""

    library: Any  # owns the memory
    step: int  # addresses
    dense: int
    # whether `dense` rounds a product and the difference that takes it once: then the loop may sum
    # rows itself (`sum_rows`), with the same bits; False is always right, but slower
    fused: bool
    tape: int  # doubles that `step` works on


def load(code: list[bytes], level: int, tape: int = 0) -> Loaded:
    """Load the object files of an integrator that LLVM has optimised at this level.

    Each is linked under a new name, because all share one linker. `tape` is the length of the array
    that compact code works on, in doubles. At another level than DEFAULT the operations that are
    fused are not known, so `fused` is False.

    Raises BuildError if a function that it calls or has is missing.
    """
    try:
        builder = llvm.JITLibraryBuilder().add_current_process()
        for part in code:
            builder.add_object_img(part)
        builder.export_symbol("step").export_symbol("d_out_f")
        library = builder.link(_linker(), f"step-{next(_numbers)}")
    except RuntimeError as error:
        raise BuildError(f"the code of a step cannot be loaded: {error}") from None
    fused = level == DEFAULT and llvm.get_host_cpu_features().get("fma", False)
    return Loaded(library, library["step"], library["d_out_f"], fused, tape)


class Called:
    """Base of steppers in Python, whose methods the loop calls: `WideSteps` is the only one.

    It writes state, time and coefficients rounded to the arrays of the loop, and keeps states at
    passages and rows itself. It may also correct the time at which the step starts (`start_high`
    and `start_low`, `high` and `low`); a run is finished where `h` is equal to `limit`.
    """

    def step(self, motion: Any) -> None:
        """Make a step from `motion.state`, at most `motion.limit` long.

        Write its end, its length and coefficients.
        """
        raise NotImplementedError

    def keep(self) -> None:
        """Store the state at the next passage of the present step, or else at the next row.

        The loop calls it as `dense`: for each passage, in the order of the sorted log, then for
        each row.
        """
        raise NotImplementedError


Stepper = Loaded | Called


_numbers = itertools.count()


@cache
def _linker() -> Any:
    """Return LLVM's linker of objects in memory, one for the whole process: so it is cached.

    It puts all parts of an object into one piece of memory. LLVM's older linker asks for them one
    by one, and ends the process where two are more than 2 GiB apart, as they may be in a large
    process.
    """
    # it brings the libraries whose functions heyoka's code calls
    extension = sys.modules[hy.expression.__module__]
    llvm.load_library_permanently(extension.__file__)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler(use_jit_link=True)

"""Compile formulas to an integrator of heyoka, whose machine code the loop calls.

The loop finds events on the Taylor coefficients of this integrator, because heyoka's own detection
takes three times the integration. An event function that is a variable, or the rate of one, has
such coefficients already. Any other one becomes the rate of a further variable, whose coefficients
come with the step; it is scaled by a small power of two, so that it does not control the step.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import repeat
from typing import Any

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..mechanics.variables import INTEGRAL_SCALE, Variables
from ..problem import PRECISIONS
from .code_cache import compiled_once
from .expressions import Formulas, equations_of_motion
from .opt_level import opt_level
from .stepper import load
from .tallies import EventRows, event_rows


@dataclass(frozen=True, eq=False)
class Compiled:
    """A compiled integrator, and the positions of event functions among its coefficients.

    Parameters
    ----------
    integrator
        heyoka's integrator, to be copied: state, parameters and time are zero.
    rows
        The events, with the positions of their functions among the variables.
    machine
        The step as machine code, `Loaded`; None in numbers wider than doubles.
    """

    integrator: Any
    rows: EventRows
    machine: Any


# terms of a right-hand side from which LLVM would take 4 to 10 s, for each phase of a contact
HUGE = 100_000
MOST_COMPILED = 64  # 0.1 to 4 MB each, measured; the one that was used least lately goes


def awaited_once(make: Callable, key: tuple, text: str, stop: threading.Event | None = None) -> Any:
    """Return `make(*key)`, which is cached; the first time, wait for it on a thread.

    Parameters
    ----------
    make
        A cached function: the thread fills its cache, and the last call returns from it.
    key
        Its arguments.
    text
        Words for the progress report.
    stop
        Set it to give up.

    Raises
    ------
    Interrupted
        If `stop` is set meanwhile.
    """
    if (make, key) not in _known:  # a thread takes 0.1 ms
        clock = time.perf_counter()
        awaited(lambda: make(*key), text, stop)
        compiling.seconds += time.perf_counter() - clock
        if len(_known) >= MOST_COMPILED:  # some may have gone since
            _known.clear()
        _known.add((make, key))
    return make(*key)


_known: set[tuple] = set()  # what this process has compiled


class _Compiling(threading.local):
    """The time that a thread has waited for the compiler."""

    seconds = 0.0


compiling = _Compiling()
"""How long this thread has waited for `awaited_once`, in all: `seconds`."""


@lru_cache(maxsize=MOST_COMPILED)
def compiled_from(
    formulas: Formulas,
    precision: str,
    tolerance: float,
    lanes: int,
    orientation: bool,
) -> Compiled:
    """Return an integrator: compiled once, then loaded from disk.

    Parameters
    ----------
    formulas
        The equations of motion and the event functions.
    precision, tolerance
        Type of its numbers, and tolerance of a step.
    lanes
        How many runs it advances at a time; one has heyoka's integrator for one.
    orientation
        Whether the orientation of the body is integrated too.

    Returns
    -------
    Compiled

    Notes
    -----
    Numbers wider than doubles and huge equations of one run get heyoka's compact code: it runs a
    third slower, but other code would take 6 s (longdouble), 25 s (quad), 4 s for each phase of
    drilling friction or 5 s (a rattleback) to compile.
    """
    number = PRECISIONS[precision]
    several = lanes > 1
    variables = Variables(formulas.form, orientation)
    q, carried, body, equations = equations_of_motion(formulas, variables)
    sources = []
    of_integrals = [integral.of or None for integral in variables.integrals]
    for e, (event, formula) in enumerate(
        zip(formulas.events, formulas.functions(q, carried, body), strict=True)
    ):
        function = hy.expression(0.0) + formula
        source = _source(e, function, equations, formulas, variables)
        if not source and event.extremes in of_integrals:
            # the integral behind the state whose rate this function is, times its scale
            source = variables.moving + of_integrals.index(event.extremes), 1, INTEGRAL_SCALE, 0.0
        # a resolved one must control the step
        scale = 1.0 if event.name in formulas.form.resolved else INTEGRAL_SCALE
        sources.append(source or (len(equations), 1, scale, 0.0))
        if not source:
            integral = hy.make_vars(f"integral_{event.name}")
            equations.append((integral, hy.expression(scale) * function))
    axis = [variables.names.index(v) for v in ("ux", "uy", "uz") if v in variables.names]
    terms = sum(len(hy.expression(0.0) + rate) for _, rate in equations)
    compact = precision != "double" or (terms > HUGE and not (several and formulas.alone))
    integrator = compiled_once(
        hy.taylor_adaptive_batch if several else hy.taylor_adaptive,
        equations,
        np.zeros((len(equations), lanes) if several else len(equations), number),
        high_accuracy=True,
        tol=number(tolerance),
        compact_mode=compact,
        fp_type=number,
        opt_level=opt_level(),
    )
    machine = None
    if precision == "double":
        code = integrator.llvm_state.object_code
        size = len(integrator.decomposition) * (integrator.order + 1) * lanes
        tape = size if compact else 0  # at most this
        machine = load(code if compact else [code], opt_level(), tape)
    rows = event_rows(formulas.events, sources, axis)
    return Compiled(integrator, rows, machine)


def _source(
    e: int, function: Any, equations: list[tuple], formulas: Formulas, variables: Variables
) -> tuple[int, int, float, float] | None:
    """Return where the coefficients of event function `e` are, or None if it is not integrated.

    It is a variable plus an offset (shift 0); or, times a scale, the rate of one (shift 1). Return
    the index of the variable, shift, scale and offset, as `tallies.event_rows` takes them.
    """
    for index, (variable, rate) in enumerate(equations):
        alone = hy.get_variables(function) == [str(variable)] and not hy.get_params(function)
        if alone and hy.diff(function, variable) == hy.expression(1.0):
            return index, 0, 1.0, _at_zero(e, index, formulas, variables)
        for scale in (1.0, INTEGRAL_SCALE):
            if hy.expression(scale) * function == rate:
                return index, 1, scale, 0.0
    return None


def _at_zero(e: int, index: int, formulas: Formulas, variables: Variables) -> float:
    """Return an event function that depends on one variable, where this is zero.

    It is computed by the formula, because heyoka would take 70 ms to compile it.
    """
    state = np.ones(len(variables.names))
    state[index] = 0.0
    with np.errstate(all="ignore"):  # the others mean nothing
        return float(
            formulas.functions(*variables.split(list(state)), formulas.body(repeat(1.0)))[e]
        )

"""Compile the equations of a problem, and return the driver that integrates it.

`driver_of(problem)` is the entrance for `runs`; `code_for` compiles formulas for other drivers.
"""

import hashlib
import threading
from functools import lru_cache
from typing import Any

import heyoka as hy

from ..mechanics.event import ON_ZERO
from ..mechanics.operand import leaves
from ..mechanics.units import SECOND
from ..problem import Problem
from .driver import Driver
from .expressions import Formulas, formulas_of
from .integrator import MOST_COMPILED, Compiled, awaited_once, compiled_from
from .observables import event_functions
from .opt_level import DEFAULT, opt_level
from .tallies import looked_for
from .wide import WideDriver


def silence() -> None:
    """Stop heyoka's warnings for the whole process.

    They go to standard output, and a status reports the same outcomes. Call it only in processes of
    this package: the command line, and the workers of a sweep.
    """
    hy.set_logger_level_critical()


def driver_of(problem: Problem, stop: threading.Event | None = None) -> Driver:
    """Return the driver of a problem, at its start.

    Raises Interrupted if `stop` is set while it is compiled.

    Parameters
    ----------
    problem
        The run.
    stop
        Set it to give up.

    Returns
    -------
    Driver
    """
    if problem.system.is_hybrid:
        from . import hybrid  # a twentieth of a start, which other runs do without

        wide = problem.precision != "double"
        return (hybrid.WideHybridDriver if wide else hybrid.HybridDriver)(problem, stop)
    system = problem.system
    body = problem.internal_body
    code = code_for(problem, formulas_of(system, problem.form.name, body.friction.__class__), stop)
    # turnings are many: they are found only if they are logged; as in `PhaseSolver._records`
    watched = (not event.sense or event.name in problem.events for event in system.events)
    rows = looked_for(code.rows, watched, stops=problem.on_liftoff != "continue")
    functions = event_functions(problem.alone)[0]
    signs = problem.joint.get("signs", {})
    for k, event in enumerate(system.events):
        if signs.get(event.name) and abs(functions[k]) < ON_ZERO:
            # for `new_tallies` just not on a zero: its zero may still be found
            functions[k] = signs[event.name] * ON_ZERO
    kind = Driver if problem.precision == "double" else WideDriver
    return kind(code, rows, leaves(body), problem.start(), functions, internal_end(problem))


def internal_end(problem: Problem) -> Any:
    """Return the internal time of the end of a run, in its precision."""
    return problem.number(problem.until) / problem.number(problem.unit(SECOND))


def code_for(
    problem: Problem, formulas: Formulas, stop: threading.Event | None = None, lanes: int = 1
) -> Compiled:
    """Return the integrator of formulas with the options of a run, or of several in lanes.

    Raises Interrupted if `stop` is set meanwhile.
    """
    key = formulas, problem.precision, problem.tolerance, lanes, problem.orientation
    return compiled_when(key, stop)


def compiled_when(key: tuple, stop: threading.Event | None = None) -> Compiled:
    """Return `compiled_from` these arguments. Raises Interrupted if `stop` is set meanwhile."""
    return awaited_once(compiled_from, key, "the equations are being compiled", stop)


def fingerprint(driver: Driver) -> str:
    """Return a digest of the equations of a driver and of the compiler options.

    Stores contain it, and a run is not resumed with another one.
    """
    return _digest(driver.codes(), opt_level())


@lru_cache(maxsize=MOST_COMPILED)
def _digest(codes: tuple[Compiled, ...], level: int) -> str:  # 1 ms, and every keyframe has one
    """Return the fingerprint of integrators compiled at a level; cached, as it takes 1 ms."""
    lines = "\n".join(f"{a}' = {b}" for code in codes for a, b in code.integrator.sys)
    if level != DEFAULT:
        lines += f"\nopt_level {level}"
    return hashlib.sha256(lines.encode()).hexdigest()[:16]

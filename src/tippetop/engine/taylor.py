"""A problem becomes a driver, which integrates it."""

import hashlib
import threading
import weakref
from typing import Any

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..mechanics.operand import leaves
from ..mechanics.system import Form, System
from ..mechanics.units import SECOND
from ..problem import Problem
from .compiled import MOST_COMPILED, compiled
from .driver import Driver
from .observables import event_functions
from .opt_level import DEFAULT, opt_level
from .tallies import looked_for
from .wide import WideDriver


LONG = 1e5  # internal time beyond which 6 s (longdouble) or 25 s (quad) of compilation pay


def silence() -> None:
    """Stops heyoka's warnings for the whole process: they go to standard output, and every outcome that they are about
    has a status here. For whoever owns the process: the command line, and the workers that a sweep starts."""
    hy.set_logger_level_critical()


def driver_of(problem: Problem, stop: threading.Event | None = None) -> Driver:
    """Return the driver of a problem, at its start. Raises Interrupted if `stop` is set while it is compiled.

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
    if problem.contact is not None:
        from .contact.driver import ContactDriver  # a twentieth of a start, which other runs do without

        return ContactDriver(problem, stop)  # type: ignore[return-value]
    functions = event_functions(problem.alone)[0]
    return new_driver(problem, problem.system, problem.form, problem.internal_body, problem.start(), functions, stop)


def new_driver(
    problem: Problem,
    system: System,
    form: Form,
    body: Any,
    start: np.ndarray,
    functions: np.ndarray,
    stop: threading.Event | None = None,
) -> Driver:
    """Return a driver of some equations with the options of a problem.

    Parameters
    ----------
    problem
        The run: its precision, its end, its events.
    system, form
        The equations: those of the problem, or of a phase of its contact.
    body
        As they take it, in internal units.
    start, functions
        The state at the start, (variables,), and the event functions there.
    stop
        Set it to give up while the equations are being compiled.

    Returns
    -------
    Driver
    """
    end = problem.number(problem.until) / problem.number(float(problem.scales.of(SECOND)))
    compact = problem.precision != "double" and float(end) < LONG
    law = type(body.friction)
    key: tuple[Any, ...] = (
        system,
        form.name,
        law,
        problem.precision,
        problem.tolerance,
        0,
        compact,
        problem.orientation,
    )
    if key in _known:
        code = compiled(*key)
    else:
        code = awaited(lambda: compiled(*key), "the equations are being compiled", stop)
        if len(_known) >= MOST_COMPILED:  # some may have gone since
            _known.clear()
        _known.add(key)
    records = looked_for(code.rows, system.events, problem.events, stops=problem.on_liftoff != "continue")
    kind = Driver if problem.precision == "double" else WideDriver
    return kind(code, records, leaves(body), start, functions, end)


_known: set[tuple] = set()  # what this process has compiled: a thread to wait for it takes 0.1 ms


def fingerprint(driver: Driver) -> str:
    """Says which equations a driver was made of: a digest of their expressions, and of how they were compiled."""
    known, level = _fingerprints.setdefault(driver, {}), opt_level()
    if level not in known:  # 1 ms, and there is one in every keyframe
        lines = "\n".join(f"{a}' = {b}" for a, b in driver.equations())
        if level != DEFAULT:
            lines += f"\nopt_level {level}"
        known[level] = hashlib.sha256(lines.encode()).hexdigest()[:16]
    return known[level]


_fingerprints: weakref.WeakKeyDictionary[Driver, dict[int, str]] = weakref.WeakKeyDictionary()

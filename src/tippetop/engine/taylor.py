"""A problem becomes what integrates it: the compiled step where there is one, heyoka's own loop elsewhere."""

import hashlib
import threading
import weakref

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..mechanics.operand import leaves
from ..problem import Problem
from .compiled import MOST_COMPILED, Compiled, compiled, is_same_step
from .one_run import CompiledDriver
from .opt_level import DEFAULT, opt_level
from .slices import Driver
from .wide import SliceDriver


LONG = 1e5  # internal time beyond which 6 s (longdouble) or 25 s (quad) of compilation pay


def silence() -> None:
    """Stops heyoka's warnings for the whole process: they go to standard output, and every outcome that they are about
    has a status here. For whoever owns the process: the command line, and the workers that a sweep starts."""
    hy.set_logger_level_critical()


def driver_of(problem: Problem, stop: threading.Event | None = None) -> Driver:
    """What integrates a problem, at its start. Raises Interrupted if `stop` is set while it is compiled.

    Parameters
    ----------
    problem
        What is integrated.
    stop
        Set it to give up.

    Returns
    -------
    Driver
    """
    if problem.contact is not None:
        from .contact.driver import ContactDriver  # a twentieth of a start, which other runs do without

        return ContactDriver(problem, lambda leg: driver_of(leg, stop))  # type: ignore[return-value]
    key = _key(problem)
    if key in _known:
        return _driver(problem, key)

    driver = awaited(lambda: _driver(problem, key), "the equations are being compiled", stop)
    if len(_known) >= MOST_COMPILED:  # some may have gone since
        _known.clear()
    _known.add(key)
    return driver


def _driver(problem: Problem, key: tuple) -> Driver:
    code = _checked(problem, compiled(*key))
    return (CompiledDriver if code.machine is not None else SliceDriver)(problem, code)


_known: set[tuple] = set()  # what this process has compiled: a thread to wait for it takes 0.1 ms


def _key(problem: Problem) -> tuple:
    """What its integrator is compiled for."""
    compact = problem.precision != "double" and float(problem.internal_time(problem.until)) < LONG
    return (
        problem.system,
        problem.form.name,
        problem.friction.__class__,
        problem.precision,
        problem.tolerance,
        0,
        compact,
        problem.orientation,
    )


def _checked(problem: Problem, code: Compiled) -> Compiled:
    """Without the machine code if it does not make the step that heyoka makes."""
    if code.machine is None or code.agrees == [True]:
        return code
    state = np.zeros(len(code.integrator.state))
    state[: len(problem.variables.names)] = problem.start()
    pars = np.array([float(leaf) for leaf in leaves(problem.internal_body)][: len(code.integrator.pars)])
    return code if is_same_step(code, state, pars) else code._replace(machine=None)


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

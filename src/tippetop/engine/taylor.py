"""A problem becomes a compiled Taylor integrator and advances slice by slice.

The only user of heyoka's integrators.
"""

import copy
import hashlib
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from ..awaiting import awaited
from ..mechanics.events import Event
from ..mechanics.operand import leaves
from ..mechanics.system import System
from ..mechanics.variables import Variables
from ..problem import PRECISIONS, Problem
from .expressions import equations_of_motion
from .status import Status
from .zeros import Zero


STEPS_PER_SLICE = 8192  # about 20 ms of work and 18 MB of dense output, which costs 1.2 ms a call: heyoka compiles it
LONG = 1e5  # internal time beyond which 6 s (longdouble) or 25 s (quad) of compilation pay
DIRECTIONS = {-1: hy.event_direction.negative, 0: hy.event_direction.any, 1: hy.event_direction.positive}
EVENT_SCALE = 2.0**-24  # events must not control the step either: with and without them, a run has the same bits


def silence() -> None:
    """Stops heyoka's warnings for the whole process: they go to standard output, and every outcome that they are about
    has a status here. For whoever owns the process: the command line, and the workers that a sweep starts."""
    hy.set_logger_level_critical()


class Compiled(NamedTuple):
    """An integrator to be copied, and the events that end its runs, in heyoka's order."""

    integrator: Any
    endings: tuple[Event, ...]


class Log:
    """What heyoka calls at an event that ends no run. heyoka copies it deeply: each copy has zeros of its own."""

    def __init__(self, kind: str):
        self.kind = kind
        self.zeros: list[Zero] = []

    def __deepcopy__(self, memo: dict) -> "Log":
        return Log(self.kind)

    def __call__(self, integrator: Any, t: Any, sign: int) -> None:
        self.zeros.append(Zero(t, self.kind, sign))


class Stop:
    """What heyoka calls at an event that ends a run: keeps the sign of the crossing, and stops."""

    def __init__(self) -> None:
        self.sign = 0

    def __deepcopy__(self, memo: dict) -> "Stop":
        return Stop()

    def __call__(self, integrator: Any, sign: int) -> bool:
        self.sign = sign
        return False


@lru_cache(maxsize=32)  # 0.1 to 4 MB each, measured; the one that was used least lately goes
def compiled(
    system: System,
    form_name: str,
    friction: Any,
    precision: str,
    tolerance: float,
    events: tuple[str, ...],
    stop: bool,
    compact: bool,
    orientation: bool,
) -> Compiled:
    """The integrator of a system in a form with a friction law: compiled once per process (and cached on disk by
    heyoka). `events` are the kinds to detect; some of them end the run if `stop`. `compact` code compiles at once, and
    runs a third slower.

    Parameters
    ----------
    system, form_name, friction
        What moves: friction is the type of the record of the law.
    precision, tolerance
        Of the integrator.
    events
        Kinds that are detected.
    stop
        Whether events that have an ending end the run.
    compact
        Whether heyoka's compact code is made.
    orientation
        Whether the orientation of the body is integrated too.

    Returns
    -------
    Compiled
        To be copied: state, parameters and time are zero.
    """
    form = system.forms[form_name]
    q, _, body, rates = equations_of_motion(system, Variables(form, orientation), friction)
    scalars, number = form.scalars(q, body), PRECISIONS[precision]
    number = float if number is np.float64 else number
    passing, terminal, endings = [], [], []
    for event in system.events:
        if event.name not in events:
            continue
        expression = hy.expression(EVENT_SCALE) * event.formula(scalars, body)
        if not hy.get_variables(expression):  # it never changes: without friction, sliding dissipates nothing
            continue
        options = {"direction": DIRECTIONS[event.direction], "fp_type": number}
        if event.ends and stop:
            terminal.append(hy.t_event(expression, callback=Stop(), **options))
            endings.append(event)
        else:
            passing.append(hy.nt_event(expression, Log(event.name), **options))
    integrator = hy.taylor_adaptive(
        rates,
        np.zeros(len(rates), dtype=PRECISIONS[precision]),
        tol=number(tolerance),
        high_accuracy=True,
        nt_events=passing,
        t_events=terminal,
        compact_mode=compact,
        fp_type=number,
    )
    return Compiled(integrator, tuple(endings))


@dataclass
class Slice:
    """A run of accepted steps: their ends, the dense output over them, and the zeros found in them."""

    times: np.ndarray  # (n + 1,) internal
    output: Callable  # output(internal times) -> (k, variables)
    coefficients: np.ndarray  # (n, variables, order + 1)
    ends: np.ndarray  # (n, variables): the states at times[1:]
    zeros: list[Zero]
    status: Status | None  # None: to be continued
    wall: float  # [s] spent inside heyoka


def _compiled_for(problem: Problem) -> Compiled:
    """What is compiled of a problem. Turnings are many, and nothing else needs them: they are detected if logged."""
    detected = tuple(e.name for e in problem.system.events if not e.sense or e.name in problem.events)
    return compiled(
        problem.system,
        problem.form.name,
        problem.friction.__class__,
        problem.precision,
        problem.tolerance,
        detected,
        problem.on_liftoff == "stop",
        problem.precision != "double" and float(problem.internal_time(problem.until)) < LONG,
        problem.orientation,
    )


def integrator_of(problem: Problem, stop: threading.Event | None = None) -> Any:
    """A fresh integrator of the problem, at its start. Raises Interrupted if `stop` is set while it is compiled."""
    doing = "the equations are being compiled"
    integrator = copy.deepcopy(awaited(lambda: _compiled_for(problem), doing, stop).integrator)
    numbers = leaves(problem.internal_body)[: len(integrator.pars)]  # it has none beyond the last that it reads
    integrator.pars[:] = [problem.number(leaf) for leaf in numbers]
    integrator.state[:] = problem.start()
    return integrator


def endings_of(problem: Problem) -> tuple[Event, ...]:
    """The events that end a run of the problem, in the order of its integrator."""
    return _compiled_for(problem).endings


def slices(integrator: Any, end: Any, endings: tuple[Event, ...] = (), steps: int | None = None) -> Iterator[Slice]:
    """Drives an integrator to the internal time `end`, so many steps at a time; the last slice carries the status.
    `endings` are the events that end it, in its order.

    Slices of a number of steps are bit-identical to one long call; slices of time would not be.
    """
    steps = steps or STEPS_PER_SLICE
    logs = [event.callback for event in integrator.nt_events] if integrator.with_events else []
    while True:
        for log in logs:
            log.zeros.clear()
        start, clock = integrator.time, time.perf_counter()
        outcome, *_, output, _ = integrator.propagate_until(end, max_steps=steps, c_output=True)
        wall = time.perf_counter() - clock
        zeros = [zero for log in logs for zero in log.zeros]
        status, last_event = _decoded(outcome, endings)
        if outcome == hy.taylor_outcome.step_limit and output.times[-1] - start < steps * 1e-10:
            status = Status.STALLED
        if last_event is not None:
            sign = integrator.t_events[endings.index(last_event)].callback.sign
            zeros.append(Zero(integrator.time, last_event.name, sign))
        if output is None:  # not one step was possible
            none = np.zeros((0, len(integrator.state), 2))
            yield Slice(np.array([start]), _nothing, none, none[:, :, 0], [], status, wall)
            return
        coefficients = output.tcs
        last = integrator.state if status is not Status.NON_FINITE else output(output.times[-1])
        ends = np.concatenate([coefficients[1:, :, 0], last[None, :]])
        yield Slice(output.times, output, coefficients, ends, sorted(zeros, key=lambda z: z.time), status, wall)
        if status is not None:
            return


def _decoded(outcome: Any, endings: tuple[Event, ...]) -> tuple[Status | None, Event | None]:
    """The status that an outcome of heyoka means, None if there are steps to be made; and the event that ended it."""
    known = {
        hy.taylor_outcome.time_limit: Status.FINISHED,
        hy.taylor_outcome.err_nf_state: Status.NON_FINITE,
        hy.taylor_outcome.step_limit: None,
    }
    if outcome in known:
        return known[outcome], None
    event = endings[-1 - int(outcome)]  # heyoka gives -1 for the first event that stops, -2 for the second, ...
    assert event.ends is not None
    return Status.of_event(event.ends), event


def _nothing(times: np.ndarray) -> np.ndarray:
    """The dense output of no step at all."""
    raise AssertionError("a slice without steps was asked for a state")


def fingerprint(integrator: Any) -> str:
    """Says which equations an integrator was made of: a digest of their expressions."""
    return hashlib.sha256("\n".join(f"{a}' = {b}" for a, b in integrator.sys).encode()).hexdigest()[:16]


def rows_at(piece: Slice, times: np.ndarray, problem: Problem) -> np.ndarray:
    """States at internal times inside the slice, copied (heyoka reuses one buffer for single times)."""
    return np.array(piece.output(np.asarray(times, dtype=problem.number)), copy=True)

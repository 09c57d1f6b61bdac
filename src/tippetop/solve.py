"""A problem becomes a compiled Taylor integrator and runs, slice by slice, to a named end. The only user of heyoka's
integrators."""

import copy
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from .events import KINDS, EventTable, Zero, amplitudes, significance
from .monitor import Monitor
from .operand import leaves, refill
from .problem import PRECISIONS, QUADRATURE_SCALE, Problem
from .system import SECOND, Form, System
from .trajectory import View
from .watch import Extremes, rate_extremes


STEPS_PER_SLICE = 4096  # about 10 ms of work and 6 MB of dense output: prompt to interrupt, cheap to keep
EVENT_SCALE = 2.0**-24  # events must not control the step either: with and without them, a run has the same bits
AT_START = 1e-9  # an event function that is smaller than this at t = 0, of order one, starts on its zero


class Status(Enum):
    """How a run ended. Only FINISHED, LIFTOFF and FALLEN are ordinary ends."""

    FINISHED = "finished"
    LIFTOFF = "liftoff"
    FALLEN = "fallen"
    NON_FINITE = "non-finite"
    STALLED = "stalled"
    INTERRUPTED = "interrupted"


class Compiled(NamedTuple):
    """An integrator to be copied, the expressions it was made of, and the log its events write to."""

    integrator: Any
    kinds: tuple[str, ...]


class Log:
    """What heyoka calls at an event. Copies are the object itself: heyoka copies callbacks deeply."""

    def __init__(self, kind: str):
        self.kind, self.zeros = kind, []

    def __deepcopy__(self, memo: dict) -> "Log":
        return Log(self.kind)

    def __call__(self, integrator: Any, t: Any, sign: int) -> None:
        self.zeros.append(Zero(t, self.kind, sign))


def variables(system: System, form: Form, friction: type) -> tuple[Any, Any, list[tuple]]:
    """State and body as heyoka expressions, and the equations of motion, in internal units.

    What is 0 or 1 by construction is a number, so that expressions fold; everything else is a run-time parameter.
    """
    state = hy.make_vars(*form.units._fields)
    scaled = [v / QUADRATURE_SCALE if v_ in form.quadratures else v for v, v_ in zip(state, form.units._fields)]  # noqa: B905
    record = type(form.units)(*scaled)
    template = system.body({name: 1.0 for name in system.parameters}, friction(*(1.0 for _ in friction._fields)))
    count = iter(range(len(leaves(template))))
    body = refill(template, (hy.par[i] for i in count))._replace(**system.folded)
    rates = form.rates(record, body)
    equations = [
        (v, hy.expression(0.0) + (QUADRATURE_SCALE * rate if name in form.quadratures else rate))
        for v, name, rate in zip(state, form.units._fields, rates, strict=True)
    ]
    return record, body, equations


@lru_cache(maxsize=32)
def compiled(
    name: str, form_name: str, friction: type, precision: str, tolerance: float, events: tuple[str, ...], stop: bool
) -> Compiled:
    """The integrator of a system in a form with a friction law: compiled once per process (and cached on disk by
    heyoka). `events` are the kinds to detect; liftoff ends the run if `stop`."""
    from .systems import SYSTEMS

    system = SYSTEMS[name]
    form = system.forms[form_name]
    record, body, equations = variables(system, form, friction)
    scalars, number = form.scalars(record, body), PRECISIONS[precision]
    number = float if number is np.float64 else number
    passing, terminal, kinds = [], [], []
    for event in system.events:
        if event.name not in events:
            continue
        expression = hy.expression(EVENT_SCALE) * event.formula(scalars, body)
        if not hy.get_variables(expression):  # it never changes: without friction, sliding dissipates nothing
            continue
        direction = {-1: hy.event_direction.negative, 0: hy.event_direction.any, 1: hy.event_direction.positive}
        options = {"direction": direction[event.direction], "fp_type": number}
        if event.stops and stop:
            terminal.append(hy.t_event(expression, **options))
        else:
            passing.append(hy.nt_event(expression, Log(event.name), **options))
            kinds.append(event.name)
    integrator = hy.taylor_adaptive(
        equations,
        np.zeros(len(equations), dtype=PRECISIONS[precision]),
        pars=np.zeros(len(leaves(body)), dtype=PRECISIONS[precision]),
        tol=number(tolerance),
        high_accuracy=True,
        nt_events=passing,
        t_events=terminal,
        compact_mode=precision != "double",  # otherwise 6 s (longdouble) and 25 s (quad) of compilation
        fp_type=number,
    )
    return Compiled(integrator, tuple(kinds))


@dataclass
class Slice:
    """A run of accepted steps: their ends, the dense output over them, and the zeros found in them."""

    times: np.ndarray  # (n + 1,) internal
    output: Callable  # output(internal times) -> (k, variables)
    coefficients: np.ndarray  # (n, variables, order + 1)
    zeros: list[Zero]
    status: Status | None  # None: to be continued
    wall: float  # [s] spent inside heyoka


def integrator_of(problem: Problem) -> Any:
    """A fresh integrator of the problem, at its start."""
    detected = tuple(k for k in KINDS if k != "turning" or k in problem.events)
    integrator = copy.deepcopy(
        compiled(
            problem.system.name,
            problem.form.name,
            type(problem.friction),
            problem.precision,
            problem.tolerance,
            detected,
            problem.on_liftoff == "stop",
        ).integrator
    )
    integrator.pars[:] = [problem.number(leaf) for leaf in leaves(problem.internal_body)]
    integrator.state[:] = problem.start()
    return integrator


def terminal_kinds(problem: Problem) -> tuple[str, ...]:
    """The kinds of the events that end a run, in heyoka's order."""
    return tuple(e.name for e in problem.system.events if e.stops and problem.on_liftoff == "stop")


def slices(integrator: Any, end: Any, terminal: tuple[str, ...] = ("liftoff",)) -> Iterator[Slice]:
    """Drives an integrator to the internal time `end`; the last slice carries the status. `terminal` are its kinds.

    Slices of a number of steps are bit-identical to one long call; slices of time would not be.
    """
    stop = hy.taylor_outcome
    logs = [event.callback for event in integrator.nt_events] if integrator.with_events else []
    while True:
        for log in logs:
            log.zeros.clear()
        start, clock = integrator.time, time.perf_counter()
        outcome, *_, output, _ = integrator.propagate_until(end, max_steps=STEPS_PER_SLICE, c_output=True)
        wall = time.perf_counter() - clock
        zeros = [zero for log in logs for zero in log.zeros]
        if outcome == stop.time_limit:
            status = Status.FINISHED
        elif outcome == stop.err_nf_state:
            status = Status.NON_FINITE
        elif outcome == stop.step_limit:
            status = Status.STALLED if output.times[-1] - start < STEPS_PER_SLICE * 1e-10 else None
        else:
            kind = terminal[-int(outcome) - 1]  # heyoka numbers the terminal events -1, -2, ...
            status = Status.LIFTOFF if kind == "liftoff" else Status.FALLEN
            zeros.append(Zero(integrator.time, kind, -1))
        if output is None:  # not one step was possible
            yield Slice(
                np.array([start]), lambda t: np.zeros((0, len(integrator.state))), np.zeros((0,)), [], status, 0
            )
            return
        yield Slice(output.times, output, output.tcs, sorted(zeros, key=lambda z: z.time), status, wall)
        if status is not None:
            return


@dataclass
class Run:
    """A finished run: rows and events, and what was measured on the way."""

    problem: Problem
    status: Status
    reason: str
    times: np.ndarray  # [s]
    rows: np.ndarray  # (n, variables), internal
    events: EventTable
    final: np.ndarray  # last good internal state
    report: dict[str, Any]
    seconds: dict[str, float]  # where the time went: compile, integrate

    def columns(self) -> dict[str, Any]:
        """The rows as named SI columns."""
        return View(self.problem).columns(self.times, self.rows)


def solve(problem: Problem, progress: Callable[[float, dict], None] | None = None) -> Run:
    """Integrates a problem to its end, gathering rows and events in memory.

    progress(t, report) is called after every slice with the time reached [s].
    """
    clock = time.perf_counter()
    integrator = integrator_of(problem)
    seconds = {"compile": time.perf_counter() - clock, "integrate": 0.0}
    monitor = Monitor(problem)
    view, second = monitor.view, float(problem.scales.of(SECOND))
    first = integrator.state.copy()[None, :]
    monitor.begin(first)
    log = EventLog(problem, view, first)
    end = problem.number(problem.until) / problem.number(second)
    wanted = np.asarray(problem.times) / second
    rows, filled, last = [first[:0]], 0, first[0]
    status, t_end = Status.FINISHED, 0.0
    for found in slices(integrator, end, terminal_kinds(problem)):
        force = _force(found, problem)
        piece = grazing(found, force, problem, view)
        seconds["integrate"] += piece.wall
        reached = float(piece.times[-1])
        upto = int(np.searchsorted(wanted, reached, side="right" if piece.status else "left"))
        if len(piece.times) > 1:
            rows.append(_rows(piece, wanted[filled:upto], problem))
            filled = upto
            ends = _rows(piece, piece.times[1:], problem)
            last, t_end = ends[-1], reached * second
            monitor.follow(ends, force, len(piece.times) - 1)
            log.take(piece)
        status = piece.status
        if len(piece.times) == 1 and piece.status is Status.LIFTOFF and filled < upto:  # it never had contact
            rows.append(first)
            filled = upto
        if progress is not None:
            progress(t_end, {"steps": monitor.steps, "drift": monitor.drift, "events": log.count})
        if status is not None:
            break
    final_theta = float(view.angles(last[None, :]).theta[0])
    events = log.table(final_theta, last)
    assert status is not None
    return Run(
        problem,
        status,
        _reason(status, t_end, view, last, events),
        np.asarray(problem.times)[:filled],
        np.concatenate(rows),
        events.logged(problem.events),
        last,
        monitor.report(events, t_end, final_theta),
        seconds,
    )


class EventLog:
    """Gathers the zeros of the slices as rows of the event table. An event at t = 0 is never logged: the log covers
    0 < t <= t_end, and a run that starts on the zero of an event does not find it again."""

    def __init__(self, problem: Problem, view: Any, first: np.ndarray):
        self.view, self.second = view, float(problem.scales.of(SECOND))
        self.sense = {event.name: event.sense for event in problem.system.events}
        self.tables: list[EventTable] = []
        self.start = float(view.angles(first).theta[0])
        scalars, body = view.scalars(first), view.body
        on_zero = {e.name: abs(float(e.formula(scalars, body)[0])) < AT_START for e in problem.system.events}
        self.starts_on = {name for name, is_zero in on_zero.items() if is_zero}
        self.count = 0

    def take(self, piece: Slice) -> None:
        """Adds the zeros of a slice."""
        zeros = [z for z in piece.zeros if z.time > (1e-6 if z.kind in self.starts_on else 0.0)]
        if not zeros:
            return
        times = np.array([z.time for z in zeros])
        states = np.asarray(piece.output(times))
        angles = self.view.angles(states)
        kind = np.array([KINDS.index(z.kind) for z in zeros], dtype=np.int8)
        crossing = np.array([z.sign * self.sense[z.kind] for z in zeros])
        rising = np.where(crossing != 0, crossing, np.sign(np.asarray(angles.theta_dot, float)))
        theta, seconds = np.asarray(angles.theta, float), times.astype(float) * self.second
        blank = np.full(theta.shape, np.nan), np.ones(theta.shape, dtype=bool)
        self.tables.append(EventTable(seconds, kind, theta, rising.astype(np.int8), *blank))
        self.count += len(zeros)

    def table(self, theta_end: float, last: np.ndarray) -> EventTable:
        """The log of a run that ended at theta_end in the state `last`, with amplitudes and significance.

        Sliding that dies for a moment only has not settled: of `settled`, the last one stays if sliding did not return.
        """
        log = EventTable.joined(self.tables)
        settled = np.flatnonzero(log.kind == KINDS.index("settled"))
        if len(settled):
            sliding = next(e.formula for e in self.view.system.events if e.name == "settled")
            over = float(sliding(self.view.scalars(last[None, :]), self.view.body)[0]) < 0
            log = EventTable(*(np.delete(column, settled[:-1] if over else settled) for column in log))
        turning = log.kind == KINDS.index("turning")
        log.significant[turning] = significance(log.theta[turning], log.theta_dot_sign[turning], theta_end)
        return log._replace(amplitude=amplitudes(log.theta, turning, self.start))


def grazing(piece: Slice, force: Extremes, problem: Problem, view: Any) -> Slice:
    """The slice, cut at the moment the normal force falls below zero, if no liftoff event told of it.

    Event detection finds simple roots; a force that dips below zero within rounding of a double root, or that is
    negative from the start, is seen here, in the extremes of every step.
    """
    if "liftoff" not in terminal_kinds(problem) or not force.least < -1e-13:
        return piece
    grid = np.linspace(float(piece.times[0]), force.t_least, 65)

    def normal_force(times: np.ndarray) -> np.ndarray:
        return np.asarray(view.internal("normal_force", view.scalars(_rows(piece, times, problem))), float)

    values = normal_force(grid)
    if values[0] <= 0:
        return Slice(piece.times[:1], piece.output, piece.coefficients[:0], [], Status.LIFTOFF, piece.wall)
    high = int(np.argmax(values < 0)) if np.any(values < 0) else len(grid) - 1
    low, high = grid[high - 1], grid[high]
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (middle, high) if normal_force(np.array([middle]))[0] > 0 else (low, middle)
    steps = int(np.searchsorted(np.asarray(piece.times, float), high))
    times = np.append(piece.times[:steps], problem.number(high))
    zeros = [zero for zero in piece.zeros if zero.time <= high] + [Zero(problem.number(high), "liftoff", -1)]
    return Slice(times, piece.output, piece.coefficients[:steps], zeros, Status.LIFTOFF, piece.wall)


def _rows(piece: Slice, times: np.ndarray, problem: Problem) -> np.ndarray:
    """States at internal times inside the slice, copied (heyoka reuses one buffer for single times)."""
    return np.array(piece.output(np.asarray(times, dtype=problem.number)), copy=True)


def _force(piece: Slice, problem: Problem) -> Extremes:
    """Extremes of the normal force over every step of the slice, in internal units."""
    names = problem.form.units._fields
    if "impulse" not in names:
        return Extremes()
    return rate_extremes(piece.times, piece.coefficients[:, names.index("impulse")].astype(float) / QUADRATURE_SCALE)


def _reason(status: Status, t_end: float, view: Any, last: np.ndarray, events: EventTable) -> str:
    """The sentence that a person reads."""
    if status is Status.FINISHED:
        unilateral = any(e.name == "liftoff" and e.stops for e in view.system.events)
        lifted = events.of("liftoff").time if unilateral else ()
        beyond = f", but outside the model since the liftoff at t = {lifted[0]:.9g} s" if len(lifted) else ""
        return f"finished at t = {t_end:.6g} s{beyond}"
    if status is Status.LIFTOFF:
        return f"the top lifted off at t = {t_end:.9g} s (g_n = 0): the model ends there"
    if status is Status.FALLEN:
        return f"the top fell at t = {t_end:.9g} s (theta = pi/2): the plane is in its way"
    hazards = view.hazards(last[None, :])
    meaning, least = min(hazards.items(), key=lambda item: item[1]) if hazards else ("no known cause", math.inf)
    cause = meaning if least < 1e-3 else "no singularity is near, so the equations are too stiff (large mu, small eps)"
    what = "the state is not finite after" if status is Status.NON_FINITE else "the step size vanishes at"
    return f"{what} t = {t_end:.9g} s: {cause}. The last good state is kept."

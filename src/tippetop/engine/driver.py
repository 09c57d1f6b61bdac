"""The loop of a run: a compiled step, the time in double length, the observer, samples, rows; for one run or many.

No Python is called inside and the lock of Python is released; each number of a lane depends on its own steps alone.
"""

from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.compiled_step import call, call_dense, call_step
from tippetop_kernels.dense_rows import TIMES, UNKNOWN, VARIABLES, sums
from tippetop_kernels.jit import apart, entry, inlined

from .observer import take_step
from .status import Status


RUNNING, FINISHED, NON_FINITE = Status.RUNNING.code, Status.FINISHED.code, Status.NON_FINITE.code
FEW = 2  # rows in a step, which are made one by one


class Motion(NamedTuple):
    """The lanes of an integrator: internal units, time in double length."""

    state: np.ndarray  # (variables, lanes)
    before: np.ndarray  # (variables, lanes) where the present step began
    pars: np.ndarray  # (parameters, lanes)
    tc: np.ndarray  # (variables, order + 1, lanes) Taylor coefficients of the present step
    high: np.ndarray  # (lanes,) time
    low: np.ndarray
    start_high: np.ndarray  # (lanes,) time where the present step began
    start_low: np.ndarray
    end: np.ndarray  # (lanes,) of the run
    limit: np.ndarray  # (lanes,) the longest step that is allowed
    h: np.ndarray  # (lanes,) the step that was made


class Rows(NamedTuple):
    """States that are asked for of the first lane: at given times, or at the ends of its steps."""

    times: np.ndarray  # (n,) internal, ascending; those of steps are written here
    states: np.ndarray  # (variables that are asked for, n)
    filled: np.ndarray  # (1,) how many of them there are
    steps: bool  # at the ends of steps
    out: np.ndarray  # (variables,) room for a state
    when: np.ndarray  # (TIMES,) room for times since the beginning of a step
    some: np.ndarray  # (VARIABLES, TIMES) room for values of variables
    rounding: int  # of the dense output


def new_motion(integrator: Any, lanes: int) -> Motion:
    """Lanes of an integrator that have nothing in them."""
    n, order = len(integrator.state), integrator.order
    state = np.zeros((n, lanes))
    line = [np.zeros(lanes) for _ in range(7)]
    return Motion(state, state.copy(), np.zeros((len(integrator.pars), lanes)), np.zeros((n, order + 1, lanes)), *line)


def no_rows(variables: int, rounding: int) -> Rows:
    """Nothing is asked for, of a dense output that rounds so."""
    room = np.zeros(variables), np.zeros(TIMES), np.zeros((VARIABLES, TIMES))
    return Rows(np.zeros(0), np.zeros((variables, 0)), np.zeros(1, np.int64), False, *room, rounding)


@entry
def drive(step, dense, motion, events, tallies, log, samples, scratch, rows, rules, most):
    """Makes at most so many steps; stops where a lane ends, and where there is no more room for what is asked for.

    Parameters
    ----------
    step, dense
        Addresses of machine code: one step of all lanes, and the state within it.
    motion, tallies, log, samples, rows
        What the steps change. Rows and log are those of the first lane.
    events, rules
        What is looked for, and what ends a run.
    scratch
        Room.
    most
        Steps.

    Returns
    -------
    int
        Steps made.
    """
    steps, ended = 0, False
    room = len(events.events) * len(scratch.zeros)
    while True:
        full = _rows(dense, motion, tallies, rows, steps > 0)
        full = full or (len(log.time) > 0 and log.filled[0] + room > len(log.time))
        full = full or (len(samples.top) > 0 and samples.filled[0] + len(motion.h) > len(samples.top))
        if steps == most or ended or full:
            return steps
        begin_step(motion, tallies)
        call_step(step, motion.state, motion.pars, motion.start_high, motion.h, motion.tc)
        known = log.filled[0]
        ended = end_step(motion, events, rules, tallies, log, samples, scratch)
        steps += 1
        for k in range(known, log.filled[0]):
            motion.limit[0] = (log.time[k] - motion.start_high[0]) - motion.start_low[0]
            call_dense(dense, rows.out, motion.tc, motion.limit)
            _copy(rows.out, log.states, k)


@inlined
def begin_step(motion, tallies):
    """Says how long the next step may be: up to the end of a run, 0 in a lane that has ended."""
    for i in range(len(motion.state)):
        for lane in range(len(motion.h)):
            motion.before[i, lane] = motion.state[i, lane]
    for lane in range(len(motion.h)):
        motion.start_high[lane], motion.start_low[lane] = motion.high[lane], motion.low[lane]
        running = tallies.lane[lane].status == RUNNING
        motion.limit[lane] = (motion.end[lane] - motion.high[lane]) - motion.low[lane] if running else 0.0
        motion.h[lane] = motion.limit[lane]


@inlined
def end_step(motion, events, rules, tallies, log, samples, scratch):
    """Takes in the step that was made; gives whether a run has ended."""
    ended, finite = False, scratch.quiet
    _add(motion.high, motion.low, motion.h, finite)
    for i in range(len(motion.state)):
        _look(motion.state[i], finite)
    for lane in range(len(motion.h)):
        if finite[lane] != 0.0:
            tallies.lane[lane].status = NON_FINITE
            for i in range(len(motion.state)):
                motion.state[i, lane] = motion.before[i, lane]
            motion.high[lane], motion.low[lane] = motion.start_high[lane], motion.start_low[lane]
    take_step(0, motion.tc, motion.start_high, motion.high, events, rules, tallies, log, scratch)
    for lane in range(len(motion.h)):
        tally = tallies.lane[lane]
        if not motion.limit[lane] > 0:
            continue
        if tally.status == RUNNING and motion.h[lane] == motion.limit[lane]:
            tally.status = FINISHED
        ended = ended or tally.status != RUNNING
        if len(samples.top) == 0 or tally.upto < 1.0:
            continue
        if tally.steps <= rules.first or tally.steps & (rules.every - 1) == 0:
            at = samples.filled[0]
            samples.top[at] = samples.in_lane[lane]
            for i in range(len(motion.state)):
                samples.states[at, i] = motion.state[i, lane]
            samples.filled[0] = at + 1
    return ended


@apart
def _add(high, low, h, finite):
    """Adds steps to times, in double length; begins to look whether all is finite: 0, or not a number."""
    for lane in range(len(h)):
        a, b = high[lane], h[lane]
        total = a + b
        part = total - a
        rest = low[lane] + ((a - (total - part)) + (b - part))
        high[lane] = total + rest
        low[lane] = rest - (high[lane] - total)
        finite[lane] = 0.0 * high[lane]


@apart
def _look(values, finite):
    """Looks whether values are finite too."""
    for lane in range(len(finite)):
        finite[lane] += 0.0 * values[lane]


@inlined
def _rows(dense, motion, tallies, rows, moved):
    """Fills rows that lie in the present step of the first lane; gives whether there is room for no more. `moved`:
    this call has made a step; the end of one that was made before it has its row."""
    n = len(rows.times)
    if n == 0:
        return False
    tally, at = tallies.lane[0], rows.filled[0]
    if rows.steps:
        if moved and tally.upto == 1.0 and tally.status != NON_FINITE:
            rows.times[at] = motion.high[0]
            for i in range(len(rows.states)):
                rows.states[i, at] = motion.state[i, 0]
            rows.filled[0] = at + 1
        return rows.filled[0] == n
    ended = tally.status != RUNNING
    if tally.status == NON_FINITE or tally.steps == 0:
        return False
    while True:
        count = 0
        while at + count < n and count < TIMES:
            when = rows.times[at + count]
            if not (when < tally.t or (ended and when <= tally.t)):
                break
            rows.when[count] = (when - motion.start_high[0]) - motion.start_low[0]
            count += 1
        if count > FEW and rows.rounding != UNKNOWN:
            _several(motion.tc, rows, at, count)
        else:
            for k in range(count):
                motion.limit[0] = rows.when[k]
                call_dense(dense, rows.out, motion.tc, motion.limit)
                for i in range(len(rows.states)):
                    rows.states[i, at + k] = rows.out[i]
        at += count
        if count < TIMES:
            break
    rows.filled[0] = at
    return at == n


@inlined
def _several(tc, rows, at, count):
    """Fills so many rows, up to TIMES, of the present step: the bits of heyoka's dense output."""
    for k in range(count, TIMES):
        rows.when[k] = rows.when[count - 1]
    variables = len(rows.states)
    for first in range(0, variables, VARIABLES):
        sums(tc, first, rows.when, rows.some, rows.rounding)
        for i in range(min(VARIABLES, variables - first)):
            for k in range(count):
                rows.states[first + i, at + k] = rows.some[i, k]


@inlined
def _copy(values, table, row):
    """Puts values into a row; as a loop, for numba compiles an assignment of arrays with all its error messages."""
    for i in range(len(values)):
        table[row, i] = values[i]


def dense_state(dense: int, motion: Motion, when: np.ndarray, out: np.ndarray) -> None:
    """The states at the times `when` (lanes,) of the present step, into out (variables, lanes)."""
    motion.limit[:] = (when - motion.start_high) - motion.start_low
    call(dense, out, motion.tc, motion.limit)

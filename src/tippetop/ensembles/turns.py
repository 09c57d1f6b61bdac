"""The loop of lanes: tops are taken from a queue, one after another, and put down at their ends, without Python."""

from typing import NamedTuple

import numpy as np

from tippetop_kernels.compiled_step import call_dense, call_step
from tippetop_kernels.jit import entry, kernel

from ..engine.driver import begin_step, end_step
from ..engine.observer import take_turning
from ..engine.status import Status
from ..engine.tallies import LANE_RECORD, LEAST, MOST, ON_ZERO, SIGN, EventRows


RUNNING, SETTLED, DONE = Status.RUNNING.code, Status.SETTLED.code, Status.FINISHED.code
AT_END = (SIGN, LEAST, MOST)  # what is kept of the event functions of a top


class Tops(NamedTuple):
    """Every top of an ensemble: how it starts, in internal units, and how it has ended."""

    start: np.ndarray  # (variables, n) what columns are made of; integrals of event functions start from zero
    pars: np.ndarray  # (parameters, n)
    until: np.ndarray  # (n,)
    signs: np.ndarray  # (n, events) of the event functions at the start
    on_zero: np.ndarray  # (n, events) 1: on its zero there
    lane: np.ndarray  # (n,) records of the tallies
    functions: np.ndarray  # (3, events, n) see AT_END
    kept: np.ndarray  # (numbers, n)
    final: np.ndarray  # (variables, n) the last state


class Queue(NamedTuple):
    """Tops that wait for a lane."""

    tops: np.ndarray  # (lanes,)
    waiting: np.ndarray  # (1,) how many; the last is taken first
    ended: np.ndarray  # (1,) how many tops have been put down


def new_tops(
    start: np.ndarray, pars: np.ndarray, until: np.ndarray, signs: np.ndarray, on_zero: np.ndarray, rows: EventRows
) -> Tops:
    """Tops that have not yet begun."""
    start, pars, until = (np.ascontiguousarray(column, float) for column in (start, pars, until))
    signs, on_zero = (np.ascontiguousarray(column, np.int8) for column in (signs, on_zero))
    functions, kept = np.zeros((len(AT_END), len(rows.events), len(until))), np.zeros((len(rows.numbers), len(until)))
    lane, final = np.zeros(len(until), LANE_RECORD), np.full(start.shape, np.nan)
    return Tops(start, pars, until, signs, on_zero, lane, functions, kept, final)


@entry
def drive_lanes(step, dense, motion, rows, tallies, log, samples, scratch, tops, queue, fresh, out, rules, most):
    """Makes at most so many steps; stops where a lane stays empty, where there is no more room for samples, and where a
    top has settled: the next call puts it down, unless its status is that of a running one again.

    Parameters
    ----------
    step, dense, motion, rows, tallies, log, samples, scratch, rules, most
        As `driver.drive` has them.
    tops, queue
        Where tops come from, and where they are put.
    fresh
        Tallies of one lane whose run has not begun.
    out
        (variables, lanes) room for states.

    Returns
    -------
    int
        Steps made.
    """
    steps = 0
    change(dense, motion, rows, tallies, samples, tops, queue, fresh, out, True)
    while steps < most and (len(samples.top) == 0 or samples.filled[0] + len(motion.h) <= len(samples.top)):
        begin_step(motion, tallies)
        call_step(step, motion.state, motion.pars, motion.start_high, motion.h, motion.tc)
        ended = end_step(motion, rows, rules, tallies, log, samples, scratch)
        steps += 1
        if ended and change(dense, motion, rows, tallies, samples, tops, queue, fresh, out, False):
            break
    return steps


@kernel
def change(dense, motion, rows, tallies, samples, tops, queue, fresh, out, settled):
    """Puts down the tops that have ended, and those that have settled if they stay so (`settled`), and takes others;
    gives whether somebody must look: for a lane is empty, or a top has settled."""
    looks = False
    for lane in range(len(motion.h)):
        status = tallies.lane[lane].status
        if samples.in_lane[lane] >= 0 and status != RUNNING:
            if status == SETTLED and not settled:
                looks = True
                continue
            _put_down(dense, motion, rows, tallies, lane, tops, samples.in_lane[lane], out)
            queue.ended[0] += 1
            samples.in_lane[lane] = -1
        if samples.in_lane[lane] < 0:
            if queue.waiting[0] == 0:
                looks = True
                continue
            queue.waiting[0] -= 1
            samples.in_lane[lane] = queue.tops[queue.waiting[0]]
            _take(motion, tallies, lane, tops, samples.in_lane[lane], fresh)
    return looks


@entry
def change_apart(motion, rows, tallies, samples, tops, queue, fresh, out, settled):
    """`change`, called from Python."""
    return 1 if change(0, motion, rows, tallies, samples, tops, queue, fresh, out, settled) else 0


@entry
def begin_apart(motion, tallies):
    """`driver.begin_step`, called from Python."""
    begin_step(motion, tallies)


@entry
def end_apart(motion, rows, rules, tallies, log, samples, scratch):
    """`driver.end_step`, called from Python."""
    return 1 if end_step(motion, rows, rules, tallies, log, samples, scratch) else 0


@kernel
def _take(motion, tallies, lane, tops, top, fresh):
    """Puts a top into a lane."""
    for i in range(len(motion.state)):
        motion.state[i, lane] = tops.start[i, top] if i < len(tops.start) else 0.0
    for i in range(len(motion.pars)):
        motion.pars[i, lane] = tops.pars[i, top]
    motion.high[lane] = motion.low[lane] = 0.0
    motion.end[lane] = tops.until[top]
    tallies.lane[lane] = fresh.lane[0]
    for e in range(tallies.functions.shape[1]):
        for what in range(len(tallies.functions)):
            tallies.functions[what, e, lane] = fresh.functions[what, e, 0]
        tallies.functions[SIGN, e, lane], tallies.functions[ON_ZERO, e, lane] = tops.signs[top, e], tops.on_zero[top, e]
    for m in range(len(tallies.kept)):
        tallies.kept[m, lane] = fresh.kept[m, 0]


@kernel
def _put_down(dense, motion, rows, tallies, lane, tops, top, out):
    """Keeps how a top has ended, perhaps in the midst of a step; the end may confirm the turning that waits."""
    tally = tallies.lane[lane]
    if tally.upto == 1.0:
        for i in range(len(motion.state)):
            out[i, lane] = motion.state[i, lane]
    elif dense != 0:  # 0: somebody has written the state
        for other in range(len(motion.h)):
            motion.limit[other] = (tally.t - motion.start_high[other]) - motion.start_low[other]
        call_dense(dense, out, motion.tc, motion.limit)
    for i in range(len(tops.final)):
        tops.final[i, top] = out[i, lane]
    x, y, z = out[rows.axis[0], lane], out[rows.axis[1], lane], out[rows.axis[2], lane]
    take_turning(tally, 0, np.arctan2(np.sqrt(x * x + y * y), z))
    if tally.status == DONE:
        tally.t = tops.until[top]
    tops.lane[top] = tally
    for e in range(tallies.functions.shape[1]):
        for i, what in enumerate(AT_END):
            tops.functions[i, e, top] = tallies.functions[what, e, lane]
    for m in range(len(tallies.kept)):
        tops.kept[m, top] = tallies.kept[m, lane]

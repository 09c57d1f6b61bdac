"""The books of the lanes of a batch: what is kept of every top while its steps pass, step by step.

Every number depends on the lane's own steps alone: not on its neighbours, nor on where slices end.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.jit import inlined, kernel
from tippetop_kernels.polynomials import crossings, extremes, ranges

from ..mechanics.system import KINDS, NOISE_FLOOR


GOING, LIFTED, STALLED, SETTLED = range(4)
EVERY = 32  # steps between two looks at the invariants
TINY = 1e-10  # internal time: a step that leads nowhere
PATIENCE = 64  # tiny steps in a row that are a stall
KIND_COUNT = len(KINDS)
ORDER = (1, 0, 2, 3, 4)  # liftoff first: it ends the step for the others


class Sources(NamedTuple):
    """Where the event functions stand among the Taylor coefficients that are kept, by number of kind, and the axis.

    A function is a variable plus `offset` (shift 0), or the rate of one (shift 1), over `scale`; row -1: the system
    has none. A variable whose rate is the first function needs no sums of its own: that rate bounds it (`led`).
    """

    row: np.ndarray  # (kinds,)
    shift: np.ndarray  # (kinds,)
    scale: np.ndarray  # (kinds,)
    offset: np.ndarray  # (kinds,)
    led: np.ndarray  # (kinds,) of bool
    axis: np.ndarray  # (3,) rows of 3hat


class Rules(NamedTuple):
    """When a lane ends before its time."""

    stop_at_liftoff: bool
    settled_for: float  # internal time; infinite: never
    most_steps: int


_BLANK: dict[str, Any] = {
    "code": 0,
    "t": 0.0,  # internal time reached
    "steps": 0,
    "step": 0,  # of the slice, the last one made
    "upto": 1.0,  # how far of it
    "tiny": 0,  # steps in a row that led nowhere
    "positive": np.zeros(5, np.int8),  # present sign of the event functions, as in Places
    "on_zero": np.zeros(5, np.int8),  # the run starts on a zero, which is not logged
    "turnings": 0,
    "significant": 0,
    "waiting": 0,  # sign of the turning that waits to be confirmed; 0: none
    "waits_at": 0.0,  # its theta
    "equators": 0,
    "force_min": math.inf,
    "force_max": -math.inf,
    **dict.fromkeys(("theta_min", "theta_max", "first_equator", "last_equator"), math.nan),
    **dict.fromkeys(("inverted_at", "lifted_at", "settled_at"), math.nan),
}
"""What a page starts with; times are internal, NaN: did not happen."""


def blank(lanes: int) -> np.ndarray:
    """Books of so many lanes: one array of records, because numba counts references to each array that it passes."""
    books = np.empty(lanes, [(name, np.array(value).dtype, np.shape(value)) for name, value in _BLANK.items()])
    for name, value in _BLANK.items():
        books[name] = value
    return books


def open_page(books: np.ndarray, lane: int, positive: np.ndarray, on_zero: np.ndarray) -> None:
    """A new top in a lane: event functions are positive or not at its start, or on their zero."""
    books[lane] = _PAGE
    books["positive"][lane], books["on_zero"][lane] = positive, on_zero


_PAGE = blank(1)[0]


@kernel
def follow(times, tcs, sources, rules, books, samples):
    """Takes in the steps of a slice: times (n + 1, lanes), Taylor coefficients tcs (n, rows, order + 1, lanes).

    The book of a lane that ended by a rule says in which step and where in it. Fills `samples` (2, k) with step and
    lane of every 32nd step of a lane; gives how many there are.
    """
    steps, _, size, lanes = tcs.shape
    p, work, found, nodes = np.empty(size), np.empty(size), np.empty(size), np.empty(9)
    factors, sums = np.empty((2, size, lanes)), np.empty((3, lanes))
    low, high, steady = np.empty((KIND_COUNT, lanes)), np.empty((KIND_COUNT, lanes)), np.empty((KIND_COUNT, lanes))
    known, quiet = np.empty((KIND_COUNT + 2, lanes)), np.empty(lanes)
    for lane in range(lanes):
        _recall(books[lane], sources, known, lane)
    kept = 0
    for i in range(steps):
        _factors(times[i], times[i + 1], factors)
        for e in range(KIND_COUNT):
            if sources.led[e]:
                _led(tcs[i, sources.row[e], 0], sources.offset[e], factors[0, 1], low, high, steady, e)
            elif sources.row[e] >= 0:
                shift = sources.shift[e]
                ranges(tcs[i, sources.row[e]], shift, factors[shift], low[e], high[e], steady[e], sums)
        _silence(low, high, known, sources, quiet)
        for lane in range(lanes):
            t, h = times[i, lane], times[i + 1, lane] - times[i, lane]
            book = books[lane]
            if not h > 0 or book.code != GOING:
                continue
            upto = 1.0
            if not quiet[lane] >= 0:
                for e in ORDER:
                    if sources.row[e] < 0:
                        continue
                    if _keeps(e, low, high, known, lane) and (e != 1 or _inside(low, high, known, lane)):
                        continue
                    shift, unit, monotone = sources.shift[e], 1.0 / sources.scale[e], steady[e, lane] > 0
                    p[size - 1] = 0.0
                    for k in range(size - shift):
                        p[k] = tcs[i, sources.row[e], k + shift, lane] * factors[shift, k, lane] * unit
                    p[0] += sources.offset[e]
                    if e == 1:
                        upto = _force(p, t, h, low[e, lane] > 0, book, rules, found, work, nodes, monotone)
                        continue
                    count, _ = crossings(p, book.positive[e] != 0, found, work, monotone)
                    if e == 0:
                        _turnings(tcs, i, t, h, lane, upto, sources, book, found, count)
                    else:
                        _passages(e, t, h, upto, book, found, count)
                _recall(book, sources, known, lane)
            book.steps += 1
            book.tiny = book.tiny + 1 if h < TINY else 0
            if book.code == GOING:
                if book.steps >= rules.most_steps or book.tiny >= PATIENCE:
                    book.code = STALLED
                elif not book.positive[4] and t + h - book.settled_at > rules.settled_for:
                    book.code = SETTLED
            book.t = t + upto * h if upto < 1.0 else times[i + 1, lane]
            book.step, book.upto = i, upto
            if upto == 1.0 and book.steps % EVERY == 0:
                samples[0, kept], samples[1, kept] = i, lane
                kept += 1
    return kept


@inlined
def _recall(book, sources, known, lane):
    """What decides whether a step of a lane says anything new: signs, and extremes of the force in the row's units."""
    for e in range(KIND_COUNT):
        known[e, lane] = 1.0 if book.positive[e] else -1.0
    known[KIND_COUNT, lane] = book.force_min * sources.scale[1]
    known[KIND_COUNT + 1, lane] = book.force_max * sources.scale[1]


@inlined
def _keeps(e, low, high, known, lane):
    """Whether a function keeps its sign over a step."""
    return (low[e, lane] if known[e, lane] > 0 else -high[e, lane]) > 0


@inlined
def _inside(low, high, known, lane):
    """Whether the force stays within its extremes."""
    return low[1, lane] >= known[KIND_COUNT, lane] and high[1, lane] <= known[KIND_COUNT + 1, lane]


@kernel
def _silence(low, high, known, sources, quiet):
    """Not negative for lanes in whose step no function says anything new."""
    lanes = len(quiet)
    for lane in range(lanes):
        quiet[lane] = 1.0
    for e in range(KIND_COUNT):
        if sources.row[e] >= 0:
            for lane in range(lanes):
                quiet[lane] = quiet[lane] if _keeps(e, low, high, known, lane) else -1.0
    if sources.row[1] >= 0:
        for lane in range(lanes):
            quiet[lane] = quiet[lane] if _inside(low, high, known, lane) else -1.0


@kernel
def _factors(start, end, factors):
    """What turns Taylor coefficients in time into those in time over h: of variables, and of rates."""
    for lane in range(len(start)):
        factors[0, 0, lane] = factors[1, 0, lane] = 1.0
    for k in range(1, factors.shape[1]):
        for lane in range(len(start)):
            factors[0, k, lane] = factors[0, k - 1, lane] * (end[lane] - start[lane])
            factors[1, k, lane] = (k + 1) * factors[0, k, lane]


@kernel
def _theta(tcs, i, x, lane, axis):
    """theta at the time x of step i."""
    a, b, c = 0.0, 0.0, 0.0
    for k in range(tcs.shape[2] - 1, -1, -1):
        a = a * x + tcs[i, axis[0], k, lane]
        b = b * x + tcs[i, axis[1], k, lane]
        c = c * x + tcs[i, axis[2], k, lane]
    return np.arctan2(np.sqrt(a * a + b * b), c)


@inlined
def _led(start, offset, h, low, high, steady, e):
    """Bounds of a variable plus `offset` by those of its rate, the function of the first kind."""
    for lane in range(len(start)):
        low[e, lane] = start[lane] + offset + h[lane] * min(0.0, low[0, lane])
        high[e, lane] = start[lane] + offset + h[lane] * max(0.0, high[0, lane])
        steady[e, lane] = 1.0 if low[0, lane] > 0 or high[0, lane] < 0 else 0.0


@inlined
def _force(p, t, h, sound, book, rules, found, work, nodes, monotone):
    """Liftoff, and extremes of the normal force up to it; gives where in the step the top ends, 1 if it does not.
    `sound`: the force is known to stay positive."""
    upto, count, positive = 1.0, 0, True
    if not sound or not book.positive[1]:
        count, positive = crossings(p, book.positive[1] != 0, found, work, monotone)
    book.positive[1] = positive
    for k in range(count):
        falling = positive != ((count - k) % 2 == 1)
        if falling and np.isnan(book.lifted_at):
            book.lifted_at = t + found[k] * h
            if rules.stop_at_liftoff:
                book.code, upto = LIFTED, found[k]
                power = 1.0
                for j in range(len(p)):
                    p[j] *= power
                    power *= upto
    book.force_min, book.force_max = extremes(p, book.force_min, book.force_max, nodes, monotone)
    return upto


@inlined
def _turnings(tcs, i, t, h, lane, upto, sources, book, found, count):
    """Turning angles: how many, how many more than rounding (as `events.Confirmation` tells), and their band."""
    for k in range(count):
        if found[k] > upto:
            break
        book.positive[0] = 1 - book.positive[0]
        if book.on_zero[0] and t + found[k] * h <= 1e-6:
            continue
        book.turnings += 1
        theta, sign = _theta(tcs, i, found[k] * h, lane, sources.axis), -1 if book.positive[0] else 1
        confirm(book, theta)
        if book.waiting == 0 or (sign == book.waiting and sign * (theta - book.waits_at) < 0):
            book.waiting, book.waits_at = sign, theta


@kernel
def confirm(book, theta):
    """The waiting turning counts once theta has come back from it by the floor."""
    if book.waiting != 0 and book.waiting * (theta - book.waits_at) >= NOISE_FLOOR:
        at = book.waits_at
        book.significant += 1
        book.theta_min = at if np.isnan(book.theta_min) else min(at, book.theta_min)
        book.theta_max = at if np.isnan(book.theta_max) else max(at, book.theta_max)
        book.waiting = 0


@inlined
def _passages(e, t, h, upto, book, found, count):
    """First and last passages of the equator, the first beyond pi - 0.1, and the last moment when sliding died."""
    for k in range(count):
        when = t + found[k] * h
        if found[k] > upto:
            break
        book.positive[e] = 1 - book.positive[e]
        falling = not book.positive[e]
        if book.on_zero[e] and when <= 1e-6:
            continue
        if e == 2:
            book.equators += 1
            book.last_equator = when
            if np.isnan(book.first_equator):
                book.first_equator = when
        elif e == 3 and falling and np.isnan(book.inverted_at):
            book.inverted_at = when
        elif e == 4 and falling:
            book.settled_at = when

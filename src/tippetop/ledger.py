"""The books of the lanes of a batch: what is kept of every top while its steps pass, step by step.

Every number depends on the lane's own steps alone: not on its neighbours, nor on where slices end.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.crossings import crossings, extremes
from tippetop_kernels.jit import inlined, kernel

from .events import NOISE_FLOOR


GOING, LIFTED, STALLED, SETTLED = range(4)
EVERY = 32  # steps between two looks at the invariants
TINY = 1e-10  # internal time: a step that leads nowhere
PATIENCE = 64  # tiny steps in a row that are a stall


class Places(NamedTuple):
    """Where the integrals of the event functions stand among the integrated variables (-1: nowhere), and the axis."""

    turning: int
    liftoff: int
    equator: int
    inverted: int
    settled: int
    ux: int
    uy: int
    uz: int


class Rules(NamedTuple):
    """When a lane ends before its time."""

    stop_at_liftoff: bool
    settled_for: float  # internal time; infinite: never
    most_steps: int


_BLANK: dict[str, Any] = {
    "code": 0,
    "t": 0.0,  # internal time reached
    "steps": 0,
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


def blank(lanes: int) -> np.recarray:
    """Books of so many lanes: one array of records, because numba counts references to each array that it passes."""
    fields = [(name, np.array(value).dtype, np.shape(value)) for name, value in _BLANK.items()]
    books = np.recarray(lanes, dtype=fields)
    for name, value in _BLANK.items():
        books[name] = value
    return books


def open_page(books: np.recarray, lane: int, positive: np.ndarray, on_zero: np.ndarray) -> None:
    """A new top in a lane: event functions are positive or not at its start, or on their zero."""
    books[lane] = blank(1)[0]
    books.positive[lane], books.on_zero[lane] = positive, on_zero


@kernel
def follow(times, tcs, places, rules, books, scale, final, samples, owners):
    """Takes in the steps of a slice: times (n + 1, lanes), Taylor coefficients tcs (n, variables, order + 1, lanes).

    Fills `final` (lanes, variables) of lanes that ended by a rule, and `samples` (variables, k) with every 32nd state
    of a lane, `owners` (k,) with its lane. Gives how many samples there are.
    """
    steps, variables, size, lanes = tcs.shape
    p, work, found = np.empty(size - 1), np.empty(size - 1), np.empty(size)
    powers, nodes = np.empty(size - 1), np.empty(9)
    kept = 0
    for i in range(steps):
        for lane in range(lanes):
            h = times[i + 1, lane] - times[i, lane]
            if books[lane].code != GOING or not h > 0:
                continue
            t, upto = times[i, lane], 1.0
            power = scale
            for k in range(size - 1):
                powers[k] = (k + 1) * power
                power *= h
            if places.liftoff >= 0:
                _rate(tcs, i, places.liftoff, lane, powers, p)
                upto = _force(p, t, h, lane, rules, books, found, work, nodes)
            _turnings(tcs, i, t, h, lane, upto, powers, places, books, p, found, work)
            _passages(tcs, i, t, h, lane, upto, powers, places, books, p, found, work)
            books[lane].steps += 1
            books[lane].t = t + upto * h if upto < 1.0 else times[i + 1, lane]
            books[lane].tiny = books[lane].tiny + 1 if h < TINY else 0
            if books[lane].code == GOING:
                if books[lane].steps >= rules.most_steps or books[lane].tiny >= PATIENCE:
                    books[lane].code = STALLED
                elif t + h - books[lane].settled_at > rules.settled_for and not books[lane].positive[4]:
                    books[lane].code = SETTLED
            if books[lane].code != GOING:
                for v in range(variables):
                    final[lane, v] = _at(tcs, i, v, lane, h, upto)
            if books[lane].steps % EVERY == 0:
                for v in range(variables):
                    samples[v, kept] = _at(tcs, i, v, lane, h, upto)
                owners[kept] = lane
                kept += 1
    return kept


@inlined
def _rate(tcs, i, v, lane, powers, p):
    """The rate of a variable over a step, as a polynomial in time over h; powers of h come with k and units."""
    for k in range(len(p)):
        p[k] = tcs[i, v, k + 1, lane] * powers[k]


@inlined
def _at(tcs, i, v, lane, h, tau):
    """A variable at the time tau h of a step."""
    total, x = 0.0, tau * h
    for k in range(tcs.shape[2] - 1, -1, -1):
        total = total * x + tcs[i, v, k, lane]
    return total


@kernel
def _theta(tcs, i, h, lane, tau, places):
    x, y, z = (
        _at(tcs, i, places.ux, lane, h, tau),
        _at(tcs, i, places.uy, lane, h, tau),
        _at(tcs, i, places.uz, lane, h, tau),
    )
    return np.arctan2(np.sqrt(x * x + y * y), z)


@inlined
def _force(p, t, h, lane, rules, books, found, work, nodes):
    """Liftoff, and extremes of the normal force up to it; gives where in the step the top ends, 1 if it does not."""
    upto = 1.0
    count, positive = crossings(p, books[lane].positive[1] != 0, found, work)
    books[lane].positive[1] = positive
    for k in range(count):
        falling = positive != ((count - k) % 2 == 1)
        if falling and np.isnan(books[lane].lifted_at):
            books[lane].lifted_at = t + found[k] * h
            if rules.stop_at_liftoff:
                books[lane].code, upto = LIFTED, found[k]
                power = 1.0
                for j in range(len(p)):
                    p[j] *= power
                    power *= upto
    low, high = books[lane].force_min, books[lane].force_max
    books[lane].force_min, books[lane].force_max = extremes(p, low, high, nodes)
    return upto


@inlined
def _turnings(tcs, i, t, h, lane, upto, powers, places, books, p, found, work):
    """Turning angles: how many, how many more than rounding (as `events.Confirmation` tells), and their band."""
    if places.turning < 0:
        return
    _rate(tcs, i, places.turning, lane, powers, p)
    count, _ = crossings(p, books[lane].positive[0] != 0, found, work)
    for k in range(count):
        if found[k] > upto:
            break
        books[lane].positive[0] = 1 - books[lane].positive[0]
        if books[lane].on_zero[0] and t + found[k] * h <= 1e-6:
            continue
        books[lane].turnings += 1
        theta, sign = _theta(tcs, i, h, lane, found[k], places), -1 if books[lane].positive[0] else 1
        confirm(books, lane, theta)
        if books[lane].waiting == 0 or (sign == books[lane].waiting and sign * (theta - books[lane].waits_at) < 0):
            books[lane].waiting, books[lane].waits_at = sign, theta


@kernel
def confirm(books, lane, theta):
    """The waiting turning counts once theta has come back from it by the floor."""
    if books[lane].waiting != 0 and books[lane].waiting * (theta - books[lane].waits_at) >= NOISE_FLOOR:
        at = books[lane].waits_at
        books[lane].significant += 1
        books[lane].theta_min = at if np.isnan(books[lane].theta_min) else min(at, books[lane].theta_min)
        books[lane].theta_max = at if np.isnan(books[lane].theta_max) else max(at, books[lane].theta_max)
        books[lane].waiting = 0


@inlined
def _passages(tcs, i, t, h, lane, upto, powers, places, books, p, found, work):
    """First and last passages of the equator, the first beyond pi - 0.1, and the last moment when sliding died."""
    for e, v in ((2, places.equator), (3, places.inverted), (4, places.settled)):
        if v < 0:
            continue
        _rate(tcs, i, v, lane, powers, p)
        count, _ = crossings(p, books[lane].positive[e] != 0, found, work)
        for k in range(count):
            when = t + found[k] * h
            if found[k] > upto:
                break
            books[lane].positive[e] = 1 - books[lane].positive[e]
            falling = not books[lane].positive[e]
            if books[lane].on_zero[e] and when <= 1e-6:
                continue
            if e == 2:
                books[lane].equators += 1
                books[lane].last_equator = when
                if np.isnan(books[lane].first_equator):
                    books[lane].first_equator = when
            elif e == 3 and falling and np.isnan(books[lane].inverted_at):
                books[lane].inverted_at = when
            elif e == 4 and falling:
                books[lane].settled_at = when

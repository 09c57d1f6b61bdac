"""The books of the lanes of a batch: what is kept of every top while its steps pass, step by step.

Every number depends on the lane's own steps alone: not on its neighbours, nor on where slices end.
"""

from typing import Any, NamedTuple

import numpy as np

from tippetop_kernels.crossings import crossings, least
from tippetop_kernels.jit import kernel

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


class Books(NamedTuple):
    """One entry per lane; times are internal, NaN: did not happen."""

    code: Any
    t: Any  # internal time reached
    steps: Any
    tiny: Any
    positive: Any  # (lanes, 5): present sign of the event functions, as in Places
    on_zero: Any  # (lanes, 5): the run starts on a zero, which is not logged
    turnings: Any
    significant: Any
    waiting: Any  # sign of the turning that waits to be confirmed; 0: none
    waits_at: Any  # its theta
    theta_min: Any
    theta_max: Any
    first_equator: Any
    last_equator: Any
    equators: Any
    inverted_at: Any
    lifted_at: Any
    settled_at: Any
    force_min: Any
    force_max: Any


def blank(lanes: int) -> Books:
    """Books of so many lanes."""
    kinds: dict[str, Any] = {"positive": np.zeros((lanes, 5), bool), "on_zero": np.zeros((lanes, 5), bool)}
    counts = dict.fromkeys(("code", "steps", "tiny", "turnings", "significant", "waiting", "equators"), 0)
    values = {"t": 0.0, "waits_at": 0.0, "force_min": np.inf, "force_max": -np.inf}
    for name in Books._fields:
        if name not in kinds:
            kinds[name] = np.full(lanes, counts[name] if name in counts else values.get(name, np.nan))
    return Books(**kinds)


def open_page(books: Books, lane: int, positive: np.ndarray, on_zero: np.ndarray) -> None:
    """A new top in a lane: event functions are positive or not at its start, or on their zero."""
    for name, empty in zip(Books._fields, blank(1), strict=True):
        getattr(books, name)[lane] = empty[0]
    books.positive[lane], books.on_zero[lane] = positive, on_zero


@kernel
def follow(times, tcs, places, rules, books, scale, final, samples, owners):
    """Takes in the steps of a slice: times (n + 1, lanes), Taylor coefficients tcs (n, variables, order + 1, lanes).

    Fills `final` (lanes, variables) of lanes that ended by a rule, and `samples` (variables, k) with every 32nd state
    of a lane, `owners` (k,) with its lane. Gives how many samples there are.
    """
    steps, variables, size, lanes = tcs.shape
    p, work, found = np.empty(size - 1), np.empty(size - 1), np.empty(size)
    kept = 0
    for i in range(steps):
        for lane in range(lanes):
            h = times[i + 1, lane] - times[i, lane]
            if books.code[lane] != GOING or not h > 0:
                continue
            t, upto = times[i, lane], 1.0
            if places.liftoff >= 0:
                _rate(tcs, i, places.liftoff, lane, h, scale, p)
                upto = _force(p, t, h, lane, rules, books, found, work)
            _turnings(tcs, i, t, h, lane, upto, scale, places, books, p, found, work)
            _passages(tcs, i, t, h, lane, upto, scale, places, books, p, found, work)
            books.steps[lane] += 1
            books.t[lane] = t + upto * h if upto < 1.0 else times[i + 1, lane]
            books.tiny[lane] = books.tiny[lane] + 1 if h < TINY else 0
            if books.code[lane] == GOING:
                if books.steps[lane] >= rules.most_steps or books.tiny[lane] >= PATIENCE:
                    books.code[lane] = STALLED
                elif t + h - books.settled_at[lane] > rules.settled_for and not books.positive[lane, 4]:
                    books.code[lane] = SETTLED
            if books.code[lane] != GOING:
                for v in range(variables):
                    final[lane, v] = _at(tcs, i, v, lane, h, upto)
            if books.steps[lane] % EVERY == 0:
                for v in range(variables):
                    samples[v, kept] = _at(tcs, i, v, lane, h, upto)
                owners[kept] = lane
                kept += 1
    return kept


@kernel
def _rate(tcs, i, v, lane, h, scale, p):
    """The rate of a variable over a step, as a polynomial in time over h."""
    power = scale
    for k in range(len(p)):
        p[k] = (k + 1) * tcs[i, v, k + 1, lane] * power
        power *= h


@kernel
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


@kernel
def _force(p, t, h, lane, rules, books, found, work):
    """Liftoff, and extremes of the normal force up to it; gives where in the step the top ends, 1 if it does not."""
    upto = 1.0
    count, books.positive[lane, 1] = crossings(p, books.positive[lane, 1], found, work)
    for k in range(count):
        falling = books.positive[lane, 1] != ((count - k) % 2 == 1)
        if falling and np.isnan(books.lifted_at[lane]):
            books.lifted_at[lane] = t + found[k] * h
            if rules.stop_at_liftoff:
                books.code[lane], upto = LIFTED, found[k]
                power = 1.0
                for j in range(len(p)):
                    p[j] *= power
                    power *= upto
    low, _ = least(p, 1.0, books.force_min[lane])
    high, _ = least(p, -1.0, -books.force_max[lane])
    books.force_min[lane] = min(books.force_min[lane], low)
    books.force_max[lane] = max(books.force_max[lane], -high)
    return upto


@kernel
def _turnings(tcs, i, t, h, lane, upto, scale, places, books, p, found, work):
    """Turning angles: how many, how many more than rounding (as `events.Confirmation` tells), and their band."""
    if places.turning < 0:
        return
    _rate(tcs, i, places.turning, lane, h, scale, p)
    count, _ = crossings(p, books.positive[lane, 0], found, work)
    for k in range(count):
        if found[k] > upto:
            break
        books.positive[lane, 0] = not books.positive[lane, 0]
        if books.on_zero[lane, 0] and t + found[k] * h <= 1e-6:
            continue
        books.turnings[lane] += 1
        theta, sign = _theta(tcs, i, h, lane, found[k], places), -1 if books.positive[lane, 0] else 1
        confirm(books, lane, theta)
        if books.waiting[lane] == 0 or (sign == books.waiting[lane] and sign * (theta - books.waits_at[lane]) < 0):
            books.waiting[lane], books.waits_at[lane] = sign, theta


@kernel
def confirm(books, lane, theta):
    """The waiting turning counts once theta has come back from it by the floor."""
    if books.waiting[lane] != 0 and books.waiting[lane] * (theta - books.waits_at[lane]) >= NOISE_FLOOR:
        at = books.waits_at[lane]
        books.significant[lane] += 1
        books.theta_min[lane] = at if np.isnan(books.theta_min[lane]) else min(at, books.theta_min[lane])
        books.theta_max[lane] = at if np.isnan(books.theta_max[lane]) else max(at, books.theta_max[lane])
        books.waiting[lane] = 0


@kernel
def _passages(tcs, i, t, h, lane, upto, scale, places, books, p, found, work):
    """First and last passages of the equator, the first beyond pi - 0.1, and the last moment when sliding died."""
    for e, v in ((2, places.equator), (3, places.inverted), (4, places.settled)):
        if v < 0:
            continue
        _rate(tcs, i, v, lane, h, scale, p)
        count, _ = crossings(p, books.positive[lane, e], found, work)
        for k in range(count):
            when = t + found[k] * h
            if found[k] > upto:
                break
            books.positive[lane, e] = not books.positive[lane, e]
            falling = not books.positive[lane, e]
            if books.on_zero[lane, e] and when <= 1e-6:
                continue
            if e == 2:
                books.equators[lane] += 1
                books.last_equator[lane] = when
                if np.isnan(books.first_equator[lane]):
                    books.first_equator[lane] = when
            elif e == 3 and falling and np.isnan(books.inverted_at[lane]):
                books.inverted_at[lane] = when
            elif e == 4 and falling:
                books.settled_at[lane] = when

"""Minima over a grid of points, row by row on all threads, neighbouring points in the lanes of one
instruction.
"""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from .compilation import entry, inlined, kernel
from .level_crossings import Level, band_of, swing
from .minimise import (
    AT_REST,
    MOST_EXTREMES,
    NEARLY,
    Status,
    clipped,
    extremes,
    factor,
    lowest,
    minimise,
    settled,
)
from .staging import BLOCK, first, get, put, second, third, width


STAGED = 8  # doubles that a stage may hand to the next
STEPS = 2  # of Halley, for every point: almost all points of a dense grid are then at rest
BLOCK_STEP_IN_POINTS = (
    64  # a step of one point by itself costs as much as that of so many in a block
)
ROWS_BETWEEN_GUESSES = 32
"""Rows after which `heights` guesses anew: what it gives does not depend on how many threads share
a grid.
"""


@kernel
def row(
    prepare, guess, slopes, value, ends, several, x, ys, r, F, q, status, count, enough, before
):
    """One row of `minima`, block by block: `count` steps for all points, more for those whose last
    is not `enough`.

    It starts from guesses; or, `before` being (near, far, ahead), `ahead` times as far from the q
    of the row `near` as those are from the row `far`.
    """
    near, far, ahead = before
    like = prepare(x, ys[0], r)
    points, stages, last = np.empty(width(like) * BLOCK), np.empty(STAGED * BLOCK), np.empty(BLOCK)
    for start in range(0, ys.size, BLOCK):
        s = slice(start, min(start + BLOCK, ys.size))
        prepared(prepare, x, ys[s], r, points)
        if ahead:
            carried_on(near[s], far[s], ahead, q[s])
        else:
            guesses(guess, like, r, q[s], points, stages)
        steps(slopes, like, r, q[s], last, points, stages, count, enough)
        values(value, like, r, q[s], F[s], points, stages)
        if judged(ends, like, x, ys[s], r, last, status[s], points, enough) or several:
            for j in range(start, s.stop):
                if several or status[j]:
                    k = slice(j, j + 1)
                    closer(
                        prepare,
                        guess,
                        slopes,
                        value,
                        several,
                        x,
                        ys[j],
                        r,
                        F[k],
                        q[k],
                        status[k],
                        ahead != 0,
                    )


@kernel
def prepared(prepare, x, ys, r, points):
    """Prepares the points of a block."""
    for j in range(ys.size):
        put(points, j, prepare(x, ys[j], r))


@kernel
def guesses(guess, like, r, q, points, stages):
    """Guesses q of the points of a block."""
    one = first(guess, like, r)
    two = second(guess, one, like, r)
    for j in range(q.size):
        put(stages, j, first(guess, get(points, j, like), r))
    for j in range(q.size):
        put(stages, j, second(guess, get(stages, j, one), get(points, j, like), r))
    for j in range(q.size):
        q[j] = clipped(third(guess, get(stages, j, two), get(points, j, like), r))


@kernel
def carried_on(near, far, ahead, q):
    """q of the points of a block, carried on from two rows: q if small, 1/q if large, as each is
    linear at its pole.
    """
    for j in range(q.size):
        step = ahead * (near[j] - far[j])
        small = near[j] < 1
        q[j] = clipped(
            (near[j] + step if small else near[j] * far[j]) / (1.0 if small else far[j] - step)
        )


@inlined
def staged(whole, like, r, q, points, stages):
    """Work the first two stages of a formula at q of the points of a block.

    Return a result of the second.
    """
    one = first(whole, 1.0, like, r)
    for j in range(q.size):
        put(stages, j, first(whole, q[j], get(points, j, like), r))
    for j in range(q.size):
        put(stages, j, second(whole, get(stages, j, one), q[j], get(points, j, like), r))
    return second(whole, one, 1.0, like, r)


@kernel
def steps(slopes, like, r, q, last, points, stages, count, enough):
    """Steps q of the points of a block until most are at rest; those that are stay, whatever their
    neighbours do.
    """
    n = restless = q.size
    for step in range(8):
        if step >= count and BLOCK_STEP_IN_POINTS * restless <= n:
            break
        two = staged(slopes, like, r, q, points, stages)
        restless = 0
        for j in range(n):
            g1, g2, g3 = third(slopes, get(stages, j, two), q[j], get(points, j, like), r)
            f = factor(g1, g2, g3)
            move = step < count or not last[j] <= enough
            q[j] = q[j] * f if move else q[j]
            last[j] = abs(f - 1) if move else last[j]
            restless += not last[j] <= enough


@kernel
def values(value, like, r, q, F, points, stages):
    """The values at q of the points of a block."""
    two = staged(value, like, r, q, points, stages)
    for j in range(q.size):
        F[j] = third(value, get(stages, j, two), q[j], get(points, j, like), r)


@kernel
def judged(ends, like, x, ys, r, last, status, points, enough):
    """Status of the points of a block before the closer look; how many need one."""
    special = 0
    for j in range(ys.size):
        lower, upper = ends(x, ys[j], get(points, j, like), r)
        rest = 0 if last[j] <= enough else 4
        status[j] = 1 if lower else (2 if upper else rest)
        special += status[j] > 0
    return special


@kernel
def closer(prepare, guess, slopes, value, several, x, y, r, F, q, status, anew):
    """A point that needs a closer look, from a guess if `anew`; F, q and status are
    arrays of one.
    """
    if not (np.isfinite(x) and np.isfinite(y)):
        F[0], q[0], status[0] = np.nan, np.nan, Status.UNDEFINED
        return
    p = prepare(x, y, r)
    count = 1
    if several:
        turns = np.full(MOST_EXTREMES, np.nan)
        count = (extremes(slopes, p, r, turns) + 1) // 2
        q[0] = turns[2 * lowest(value, turns, 0, count - 1, p, r)]
    else:
        q[0] = settled(slopes, clipped(guess(p, r)) if anew else q[0], p, r)
        if np.isnan(q[0]):
            q[0] = minimise(slopes, guess, p, r)
    F[0] = value(q[0], p, r)
    if not np.isfinite(F[0]):
        status[0] = Status.UNSETTLED
        return
    at_end = (status[0] == Status.AT_LOWER_END and q[0] < 1e-6) or (
        status[0] == Status.AT_UPPER_END and q[0] > 1e6
    )
    if status[0] == Status.UNSETTLED or (several and not at_end):
        status[0] = Status.LOWER_OF_TWO if count > 1 else Status.ATTAINED


def minima(prepare, guess, slopes, value, ends):
    """Return the kernel of the minimum over q at every (x, y).

    It fills F, q (float64) and status (int8), each (xs.size, ys.size).
    """

    @entry
    def minima(several, xs, ys, r, F, q, status):
        steps = STEPS, AT_REST, (ys, ys, 0.0)
        for i in range(xs.size):
            out = F[i], q[i], status[i]
            row(prepare, guess, slopes, value, ends, several, xs[i], ys, r, *out, *steps)

    return minima


def heights(prepare, guess, slopes, value, ends):
    """Return the kernel of F alone: it is flat at its minimum, and one step is enough for its
    digits.

    Most rows start from the q of the two before them. So the last bit of F may depend on the grid.
    """

    @entry
    def heights(several, xs, ys, r, F, status):
        q = np.empty((3, ys.size))
        for i in range(xs.size):
            follows = i % ROWS_BETWEEN_GUESSES >= 2
            ahead = (xs[i] - xs[i - 1]) / (xs[i - 1] - xs[i - 2]) if follows else 0.0
            before = q[(i - 1) % 3], q[(i - 2) % 3], ahead
            out = F[i], q[i % 3], status[i]
            row(prepare, guess, slopes, value, ends, several, xs[i], ys, r, *out, 1, NEARLY, before)

    return heights


def on_threads(work: Callable[[slice], None], rows: int, threads: int | None = None) -> None:
    """Call work(slice of rows) on all threads; kernels release the interpreter's lock.

    Slices begin at multiples of `ROWS_BETWEEN_GUESSES` and shrink towards the end: a call takes 40
    us to unpack its records, and no thread should wait long for another. Not numba's prange: it
    does not take records of records, and compiles three times as long.
    """
    threads = threads or os.cpu_count() or 1
    if threads == 1 or rows == 1:
        work(slice(0, rows))
        return
    ends, end = [0], 0
    while end < rows:
        end += max(1, (rows - end) // (2 * threads * ROWS_BETWEEN_GUESSES)) * ROWS_BETWEEN_GUESSES
        ends.append(min(end, rows))
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(work, itertools.starmap(slice, itertools.pairwise(ends))):
            pass


def gradients(prepare, gradient):
    """Return the kernel of gradient(q, p, r) at every (x, y); fills by_x, by_y,
    (xs.size, ys.size).
    """

    @entry
    def gradients(xs, ys, r, q, by_x, by_y):
        for i in range(xs.size):
            for j in range(ys.size):
                by_x[i, j], by_y[i, j] = gradient(q[i, j], prepare(xs[i], ys[j], r), r)

    return gradients


def potentials(prepare, slopes, value):
    """Return the kernel of the value and, times a constant, its two derivatives by z.

    It fills V, V_z, V_zz, each (zs.size, xs.size, ys.size); q = (1 - z)/(1 + z), NaN unless -1 < z
    < 1.
    """

    @entry
    def potentials(zs, xs, ys, r, V, V_z, V_zz):
        for i in range(zs.size):
            z = zs[i] if abs(zs[i]) < 1 else np.nan
            q, w = (1 - z) / (1 + z), (1 - z) * (1 + z)
            for j in range(xs.size):
                for k in range(ys.size):
                    p = prepare(xs[j], ys[k], r)
                    V[i, j, k] = value(q, p, r)
                    g1, g2, _ = slopes(q, p, r)
                    V_z[i, j, k] = -2 * g1 / (q * w)
                    V_zz[i, j, k] = 4 * (g2 - z * g1) / (q * w * w)

    return potentials


def turnings(prepare, slopes, value, excess, bend):
    """Return the kernel of a minimum, the crossings around it, and a Level at points (xs, ys,
    levels).

    It takes the minimum in whose basin `at` lies, the lowest where it is NaN; then the lowest that
    the band contains. It fills `other` (2, n) with the crossings of a band elsewhere. All other
    arrays are (n,).
    """

    @entry
    def turnings(allowance, xs, ys, levels, at, r, low, high, other, q, F, bends, status):
        turns = np.full(MOST_EXTREMES, np.nan)
        for i in range(xs.size):
            low[i] = high[i] = other[0, i] = other[1, i] = q[i] = F[i] = bends[i] = np.nan
            status[i] = Level.UNDEFINED
            if not np.isfinite(xs[i] + ys[i]):
                continue
            p = prepare(xs[i], ys[i], r)
            count = extremes(slopes, p, r, turns)
            minima = (count + 1) // 2
            if np.isnan(at[i]):
                well = lowest(value, turns, 0, minima - 1, p, r)
            else:
                well = 0
                while well + 1 < minima and at[i] > turns[2 * well + 1]:
                    well += 1
            band = band_of(excess, turns, count, well, levels[i], allowance, p, r)
            low[i], high[i], status[i], first, last = band
            k = lowest(value, turns, first, last, p, r)
            q[i] = turns[2 * k]
            F[i], bends[i] = value(q[i], p, r), bend(q[i], p, r)
            for another in range(minima):
                if another < first or another > last:
                    band = band_of(excess, turns, count, another, levels[i], allowance, p, r)
                    if band[2] != Level.BELOW:
                        other[0, i], other[1, i] = band[0], band[1]

    return turnings


def periods(prepare, excess, inertia):
    """Return the kernel of the period of the swing between low and high at each point; fills period
    (n,).
    """

    @entry
    def periods(low, high, xs, ys, levels, r, b, period):
        for i in range(xs.size):
            p = prepare(xs[i], ys[i], r)
            period[i] = swing(excess, inertia, low[i], high[i], levels[i], p, r, b)

    return periods

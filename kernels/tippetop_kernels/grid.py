"""Minima over a grid of points, row by row on all threads, with neighbouring points in SIMD lanes.

Each step of the iteration is a separate loop over a block of points, because a short chain of
dependent operations keeps the processor busier than a long one.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from .compilation import entry, kernel
from .level_crossings import Level, band_of, swing
from .minimise import (
    AT_REST,
    MOST_EXTREMES,
    Status,
    clipped,
    extremes,
    factor,
    lowest,
    minimise,
)


BLOCK = 256
"""Points of a block; its arrays fit into the first-level cache."""

STEPS = 2
"""Steps of Halley for every point, after which almost all points of a dense grid are at rest."""

BLOCK_STEP_IN_POINTS = 64
"""Single-point steps that cost as much as a step of a whole block."""


@kernel
def step_to_rest(prepare, slopes, x, ys, r, q, last):
    """Step q of the points of a block until most are at rest.

    A point at rest is not moved again, so its q does not depend on its neighbours.
    """
    n = restless = q.size
    for step in range(8):
        if step >= STEPS and BLOCK_STEP_IN_POINTS * restless <= n:
            break
        restless = 0
        for j in range(n):
            g1, g2, g3 = slopes(q[j], prepare(x, ys[j], r), r)
            f = factor(g1, g2, g3)
            move = step < STEPS or not last[j] <= AT_REST
            q[j] = q[j] * f if move else q[j]
            last[j] = abs(f - 1) if move else last[j]
            restless += not last[j] <= AT_REST


@kernel
def judge(prepare, ends, x, ys, r, last, status):
    """Write the status of the points of a block; return how many must be computed one by one."""
    special = 0
    for j in range(ys.size):
        lower, upper = ends(x, ys[j], prepare(x, ys[j], r), r)
        rest = 0 if last[j] <= AT_REST else 4
        status[j] = 1 if lower else (2 if upper else rest)
        special += status[j] > 0
    return special


@kernel
def single_minimum(prepare, guess, slopes, value, several, x, y, r, F, q, status):
    """Compute a point that needs a closer look; F, q and status are arrays of one."""
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

    @kernel
    def block(several, x, ys, r, F, q, status, last):
        for j in range(ys.size):
            q[j] = clipped(guess(prepare(x, ys[j], r), r))
        step_to_rest(prepare, slopes, x, ys, r, q, last)
        for j in range(ys.size):
            F[j] = value(q[j], prepare(x, ys[j], r), r)
        if judge(prepare, ends, x, ys, r, last, status) or several:
            for j in range(ys.size):
                if several or status[j]:
                    k = slice(j, j + 1)
                    out = F[k], q[k], status[k]
                    single_minimum(prepare, guess, slopes, value, several, x, ys[j], r, *out)

    @entry
    def minima(several, xs, ys, r, F, q, status):
        last = np.empty(BLOCK)
        for i in range(xs.size):
            for start in range(0, ys.size, BLOCK):
                s = slice(start, min(start + BLOCK, ys.size))
                block(several, xs[i], ys[s], r, F[i, s], q[i, s], status[i, s], last)

    return minima


def on_threads(work: Callable[[slice], None], rows: int, threads: int | None = None) -> None:
    """Call work(slice of rows) on all threads; kernels release the interpreter's lock.

    numba's prange does not take records of records, and compiles three times as long.
    """
    threads = threads or os.cpu_count() or 1
    size = -(-rows // (8 * threads))
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, (slice(k, k + size) for k in range(0, rows, size))))


def gradients(prepare, gradient):
    """Return the kernel of gradient(q, p, r) at every (x, y).

    Fills by_x, by_y, (xs.size, ys.size).
    """

    @entry
    def gradients(xs, ys, r, q, by_x, by_y):
        for i in range(xs.size):
            for j in range(ys.size):
                by_x[i, j], by_y[i, j] = gradient(q[i, j], prepare(xs[i], ys[j], r), r)

    return gradients


def turnings(prepare, slopes, value, excess, bend, inertia):
    """Return the kernel of a minimum, the crossings around it, and a Level, at points.

    The points are (xs, ys, levels). It takes the minimum in whose basin `at` lies, the lowest one
    if `at` is NaN; then the lowest that the band contains. It fills status (n,) and the rows of out
    (8, n): the crossings, q of the minimum, the value and the bend there, the period of the swing
    between the crossings, and the crossings of a band elsewhere.
    """

    @entry
    def turnings(allowance, xs, ys, levels, at, r, b, status, out):
        turns = np.full(MOST_EXTREMES, np.nan)
        for i in range(xs.size):
            status[i], out[:, i] = Level.UNDEFINED, np.nan
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
            low, high, status[i], first, last = band
            q = turns[2 * lowest(value, turns, first, last, p, r)]
            period = swing(excess, inertia, low, high, levels[i], p, r, b)
            out[0, i], out[1, i], out[2, i] = low, high, q
            out[3, i], out[4, i], out[5, i] = value(q, p, r), bend(q, p, r), period
            for another in range(minima):
                if another < first or another > last:
                    band = band_of(excess, turns, count, another, levels[i], allowance, p, r)
                    if band[2] != Level.BELOW:
                        out[6, i], out[7, i] = band[0], band[1]

    return turnings

"""Minima over a grid of points, row by row on all threads, with neighbouring points in SIMD lanes.

The functions of a problem go in (see `minimise`); kernels come out that fill arrays of the caller.

Symbols
    xs, ys    coordinates of the points; prepare(x, y, r): the record p of one
    r         record of all points, the coefficients of a body; only functions of a problem read it
    q, F      place and value of the minimum; status: a `minimise.Status`; last: size of a step
    several   whether a function can have two minima
    b, inertia   the body record of a system, and inertia(z, b), the factor of the square of the
              speed, for periods

Each step of the iteration is a separate loop over a row of points, because a short chain of
dependent operations keeps the processor busier than a long one.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from .compilation import entry, kernel
from .level_crossings import Level, band_of, swing
from .minimise import AT_REST, MOST_EXTREMES, Status, clipped, extremes, lowest, stepped


STEPS, MOST_STEPS = 2, 8
"""Steps of Halley for every point of a row, after which almost all are at rest, and for one."""


@kernel
def scanned(prepare, slope, value, x, y, r, status, j):
    """Return F and q of the lowest minimum at a point (x, y), found by a scan; write status[j].

    For a point where the iteration did not converge, or the function has several minima. status[j]
    is that which `row` has found.
    """
    p = prepare(x, y, r)
    turns = np.empty(MOST_EXTREMES)
    last = extremes(slope, p, r, turns)
    well = lowest(value, turns, 0, last, p, r)
    q = turns[2 * well]
    F = value(q, p, r)
    if not np.isfinite(F):
        status[j] = Status.UNSETTLED if np.isfinite(x + y) else Status.UNDEFINED
        return np.nan, np.nan
    # the number of the minimum at the end that `row` has found
    at_end = last if status[j] == Status.AT_UPPER_END else 0
    if status[j] == Status.UNSETTLED or well != at_end:
        status[j] = Status.LOWER_OF_TWO if last else Status.ATTAINED
    return F, q


def minima(prepare, guess, slopes, slope, value, reaches_pole):
    """Return the kernel of the minimum over q at every (x, y), for these functions of a problem.

    They are those of `minimise`, as kernels; prepare(x, y, r) -> p, and reaches_pole(x, y, p, r) ->
    whether the infimum is approached at either end. The kernel fills F, q (float64) and status
    (int8), each (xs.size, ys.size).
    """

    @kernel
    def row(several, x, ys, r, F, q, status, last):
        """Fill F, q and status of all points (x, y) with one x.

        All points make the same first steps, which LLVM turns into vectors; those that have not
        converged continue one by one. A point at an end, or of a top with several minima, is
        scanned.
        """
        for j in range(ys.size):
            q[j] = clipped(guess(prepare(x, ys[j], r), r))
        for _ in range(STEPS):
            for j in range(ys.size):
                q[j], last[j] = stepped(slopes, q[j], prepare(x, ys[j], r), r)
        for j in range(ys.size):
            for _ in range(STEPS, MOST_STEPS):
                if last[j] <= AT_REST:
                    break
                q[j], last[j] = stepped(slopes, q[j], prepare(x, ys[j], r), r)
        for j in range(ys.size):
            F[j] = value(q[j], prepare(x, ys[j], r), r)
        for j in range(ys.size):
            lower, upper = reaches_pole(x, ys[j], prepare(x, ys[j], r), r)
            # codes of Status: UNSETTLED or ATTAINED; then AT_LOWER_END, AT_UPPER_END
            rest = 0 if last[j] <= AT_REST else 4
            status[j] = 1 if lower else (2 if upper else rest)
        for j in range(ys.size):
            if several or status[j]:
                F[j], q[j] = scanned(prepare, slope, value, x, ys[j], r, status, j)

    @entry
    def minima(several, xs, ys, r, F, q, status):
        """Fill F, q and status (xs, ys) with the minimum at each point of the grid.

        `landscape.surface.minima` calls it, with r the coefficients of a body.
        """
        last = np.empty(ys.size)
        for i in range(xs.size):
            row(several, xs[i], ys, r, F[i], q[i], status[i], last)

    return minima


def on_threads(work: Callable[[slice], None], rows: int, threads: int | None = None) -> None:
    """Call work(slice of rows) on all threads; kernels release the interpreter's lock.

    Each thread gets about eight slices, as rows take unequal times.

    numba's prange does not take records of records, and compiles three times as long.
    """
    threads = threads or os.cpu_count() or 1
    size = -(-rows // (8 * threads))
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, (slice(k, k + size) for k in range(0, rows, size))))


def gradients(prepare, gradient):
    """Return the kernel of gradient(q, p, r) -> derivatives by x and by y, at every (x, y).

    prepare(x, y, r) -> p. Both must be kernels themselves. q (xs.size, ys.size) are the minima, as
    `minima` returns them; the kernel fills by_x, by_y of the same shape.
    """

    @entry
    def gradients(xs, ys, r, q, by_x, by_y):
        """Fill by_x and by_y (xs, ys) with the derivatives of the minimum at each point."""
        for i in range(xs.size):
            for j in range(ys.size):
                by_x[i, j], by_y[i, j] = gradient(q[i, j], prepare(xs[i], ys[j], r), r)

    return gradients


def turnings(prepare, slope, value, excess, bend, inertia):
    """Return the kernel of a minimum, the crossings around it, and a Level, at points.

    The points are (xs, ys, levels). It takes the minimum in whose basin `at` lies, the lowest one
    if `at` is NaN; then the lowest that the band contains. It fills status (n,) and the rows of out
    (8, n): the crossings, q of the minimum, the value and the bend there, the period of the swing
    between the crossings, and the crossings of a band elsewhere.
    """

    @entry
    def turnings(allowance, xs, ys, levels, at, r, b, status, out):
        """Write eight numbers of each point to `out`, and its Level to `status`.

        They are the crossings around the minimum, its q and F, the curvature there, the period, and
        the crossings around another minimum below the level, or NaN. `landscape.turning` unpacks
        them in this order: a change of one is a change of both.
        """
        turns = np.empty(MOST_EXTREMES)
        for i in range(xs.size):
            p = prepare(xs[i], ys[i], r)
            level = p, levels[i]
            maxima = extremes(slope, p, r, turns)
            well = lowest(value, turns, 0, maxima, p, r)
            if not np.isnan(at[i]):
                well = 0
                # minimum `well` is turns[2 well], the maximum after it turns[2 well + 1]
                while well < maxima and at[i] > turns[2 * well + 1]:
                    well += 1
            band = band_of(excess, turns, maxima, well, level, allowance, r)
            low, high, status[i], first, last = band
            q = turns[2 * lowest(value, turns, first, last, p, r)]
            F = value(q, p, r)
            q = q if np.isfinite(F) else np.nan  # as `scanned`, where there is no value
            period = swing(excess, inertia, low, high, level, r, b)
            out[:, i] = low, high, q, F, bend(q, p, r), period, np.nan, np.nan
            for another in range(maxima + 1):
                if another < first or another > last:
                    band = band_of(excess, turns, maxima, another, level, allowance, r)
                    if band[2] != Level.BELOW:
                        out[6, i], out[7, i] = band[0], band[1]

    return turnings

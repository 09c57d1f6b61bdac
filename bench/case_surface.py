"""How fast F = inf V is, against V itself, side by side in one process.

Wall clock: two threads take part. Where the machine has other work, the best of all repetitions
tells more.
"""

import statistics
from functools import partial

import numba
import numpy as np

from tippetop.landscape import kernels
from tippetop.landscape import landscape_body as bodies
from tippetop.mechanics.systems import tippe_top
from tippetop_kernels import grid

from .measure import elapsed


FIGURE = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 235 / 625 * 8e-6, "I3": 2 / 5 * 8e-6, "g": 9.82}

compiled = numba.njit(error_model="numpy", nogil=True)
potential = compiled(tippe_top.potential)


@compiled
def tabulate(zs, xs, ys, b, out):
    """V with another z at every point, rows in lanes."""
    for i in range(xs.size):
        for j in range(ys.size):
            out[i, j] = potential(zs[j], xs[i], ys[j], b)


def compare(quick: bool) -> dict:
    """Return the nanoseconds per point of V and F."""
    n, repeats = (400, 3) if quick else (2000, 9)
    t = bodies.top(FIGURE)
    D = 6 * np.sqrt(FIGURE["m"] * FIGURE["g"] * FIGURE["R"] * FIGURE["I3"])
    xs, ys = np.linspace(-D, D, n), np.linspace(-D * FIGURE["R"], D * FIGURE["R"], n)
    F, q, status = np.empty((n, n)), np.empty((n, n)), np.empty((n, n), np.int8)
    zs = np.linspace(-0.999, 0.999, n)

    def rows(s):
        kernels.minima(t.two_wells, xs[s], ys, t.coefficients, F[s], q[s], status[s])

    contestants = {
        "V": partial(tabulate, zs, xs, ys, t.body, F),
        "F and argmin, 1 thread": partial(grid.on_threads, rows, n, 1),
        "F and argmin, 2 threads": partial(grid.on_threads, rows, n, 2),
    }
    for work in contestants.values():
        work()  # compile
    times = {name: [] for name in contestants}
    for _ in range(repeats):
        for name, work in contestants.items():
            times[name].append(1e9 * elapsed(work) / n**2)
    found = {
        name: {"ns a point, median": statistics.median(each), "best": min(each)}
        for name, each in times.items()
    }
    return {"title": "V and the minimal surface F over a grid", "rows": found}

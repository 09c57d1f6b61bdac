"""How fast F = inf V is, against V itself and against what one would write without it, side by side
in one process.

Wall clock: two threads take part. Where the machine has other work, the best of all repetitions
tells more.
"""

import statistics
from functools import partial

import numba
import numpy as np
import scipy.optimize

from tippetop.landscape import kernels
from tippetop.landscape import landscape_body as bodies
from tippetop.landscape.surface import minimal_surface
from tippetop.mechanics.systems import tippe_top
from tippetop_kernels import grid

from .measure import elapsed


FIGURE = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 235 / 625 * 8e-6, "I3": 2 / 5 * 8e-6, "g": 9.82}
GOLDEN = (np.sqrt(5) - 1) / 2
STEPS = 42  # of a golden section: z to 2e-9, hence F to rounding where V is smooth on that scale

compiled = numba.njit(error_model="numpy", nogil=True)
potential = compiled(tippe_top.potential)


@compiled
def tabulate(f, zs, xs, ys, b, out):
    """V with another z at every point, rows in lanes."""
    for i in range(xs.size):
        for j in range(ys.size):
            out[i, j] = f(zs[j], xs[i], ys[j], b)


@compiled
def golden(f, xs, ys, b, out):
    """A golden section at every point, jitted."""
    for i in range(xs.size):
        for j in range(ys.size):
            low, high = -1.0, 1.0
            z1, z2 = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            f1, f2 = f(z1, xs[i], ys[j], b), f(z2, xs[i], ys[j], b)
            for _ in range(STEPS):
                if f1 < f2:
                    high, z2, f2 = z2, z1, f1
                    z1 = high - GOLDEN * (high - low)
                    f1 = f(z1, xs[i], ys[j], b)
                else:
                    low, z1, f1 = z1, z2, f2
                    z2 = low + GOLDEN * (high - low)
                    f2 = f(z2, xs[i], ys[j], b)
            out[i, j] = min(f1, f2)


def scipy_points(xs, ys, b, out):
    """scipy's bounded minimiser on the jitted V, point by point."""
    for i, j in np.ndindex(out.shape):
        found = scipy.optimize.minimize_scalar(
            lambda z, i=i, j=j: potential(z, xs[i], ys[j], b),
            bounds=(-1, 1),
            method="bounded",
            options={"xatol": 1e-9},
        )
        out[i, j] = found.fun


def compare(quick: bool) -> dict:
    """Return the nanoseconds per point of V, F and the peers, each on a grid of its own size."""
    n, repeats = (400, 3) if quick else (2000, 9)
    t = bodies.top(FIGURE)
    D = 6 * np.sqrt(FIGURE["m"] * FIGURE["g"] * FIGURE["R"] * FIGURE["I3"])

    def axes(m):
        return np.linspace(-D, D, m), np.linspace(-D * FIGURE["R"], D * FIGURE["R"], m)

    xs, ys = axes(n)
    F, q, status = np.empty((n, n)), np.empty((n, n)), np.empty((n, n), np.int8)
    zs = np.linspace(-0.999, 0.999, n)

    def rows(s):
        kernels.minima(t.two_wells, xs[s], ys, t.coefficients, F[s], q[s], status[s])

    contestants = {
        "V": (n, lambda: tabulate(potential, zs, xs, ys, t.body, F)),
        "F and argmin, 1 thread": (n, lambda: grid.on_threads(rows, n, 1)),
        "F and argmin, 2 threads": (n, lambda: grid.on_threads(rows, n, 2)),
    }
    tables = {}
    for name, m, work in (
        ("golden section, jitted", max(50, n // 5), partial(golden, potential)),
        ("scipy", 10, scipy_points),
    ):
        tables[name] = np.empty((m, m))
        contestants[name] = (m, partial(work, *axes(m), t.body, tables[name]))
    for _, work in contestants.values():
        work()  # compile
    times = {name: [] for name in contestants}
    for _ in range(repeats):
        for name, (m, work) in contestants.items():
            times[name].append(1e9 * elapsed(work) / m**2)
    found = {
        name: {"ns a point, median": statistics.median(each), "best": min(each)}
        for name, each in times.items()
    }
    for name, table in tables.items():
        exact = minimal_surface(t, *axes(len(table))).F.values
        found[name]["largest relative error"] = float(np.max(np.abs(table / exact - 1)))
    return {"title": "V and the minimal surface F over a grid", "rows": found}

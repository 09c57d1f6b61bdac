"""How fast F = inf V is, against V itself and against what one would write without it, side by side
in one process.

Wall clock: two threads take part. Where the machine has other work, the best of all repetitions
tells more.
"""

import statistics

import numba
import numpy as np
import scipy.optimize

from tippetop.landscape import kernels
from tippetop.landscape import landscape_body as bodies
from tippetop.landscape.surface import minimal_surface
from tippetop.mechanics.systems import tippe_top
from tippetop_kernels import grid

from .measure import elapsed, ratio


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


def golden_numpy(xs, ys, b, out):
    """The same golden section, a whole grid at a time in NumPy, row blocks that stay in
    the cache.
    """
    for i in range(xs.size):
        x = xs[i]
        low, high = np.full(ys.size, -1.0), np.full(ys.size, 1.0)
        z1, z2 = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        f1, f2 = tippe_top.potential(z1, x, ys, b), tippe_top.potential(z2, x, ys, b)
        for _ in range(STEPS):
            left = f1 < f2
            high, low = np.where(left, z2, high), np.where(left, low, z1)
            new = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
            f_new = tippe_top.potential(new, x, ys, b)
            z1, z2, f1, f2 = (
                np.where(left, new, z2),
                np.where(left, z1, new),
                np.where(left, f_new, f2),
                np.where(left, f1, f_new),
            )
        out[i] = np.minimum(f1, f2)


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


def grids(n, D, lam):
    """n x n points of a box."""
    return np.linspace(-D, D, n), np.linspace(-lam, lam, n)


def compete(n, repeats):
    """Nanoseconds per point of every contestant, by repetition."""
    t = bodies.top(FIGURE)
    b, r = t.body, t.coefficients
    D = 6 * np.sqrt(FIGURE["m"] * FIGURE["g"] * FIGURE["R"] * FIGURE["I3"])
    box = D, D * FIGURE["R"]
    out = {}

    def buffers(m):
        return np.empty((m, m)), np.empty((m, m)), np.empty((m, m), np.int8)

    xs, ys = grids(n, *box)
    F, q, status = buffers(n)
    zs = np.linspace(-0.999, 0.999, n)

    def rows(s):
        kernels.minima(t.two_wells, xs[s], ys, r, F[s], q[s], status[s])

    def surface(threads):
        return lambda: grid.on_threads(rows, n, threads)

    small = {
        "golden section, jitted": max(50, n // 5),
        "golden section, NumPy": max(30, n // 10),
        "scipy": 10,
    }
    axes = {name: grids(m, *box) for name, m in small.items()}
    tables = {name: np.empty((m, m)) for name, m in small.items()}
    contestants = {
        "V": (n, lambda: tabulate(potential, zs, xs, ys, b, F)),
        "F, 1 thread": (n, surface(1)),
        "F, 2 threads": (n, surface(2)),
    }
    for name, work in (
        ("golden section, jitted", lambda *a: golden(potential, *a)),
        ("golden section, NumPy", golden_numpy),
        ("scipy", scipy_points),
    ):
        contestants[name] = (small[name], lambda w=work, a=axes[name], o=tables[name]: w(*a, b, o))
    for _, work in contestants.values():
        work()
    for _ in range(repeats):
        for name, (m, work) in contestants.items():
            out.setdefault(name, []).append(1e9 * elapsed(work) / m**2)
    errors = {}
    for name, table in tables.items():
        exact = minimal_surface(FIGURE, *axes[name]).F.values
        errors[name] = float(np.max(np.abs(table / exact - 1)))
    return out, errors


def compare(quick: bool) -> dict:
    """Return the nanoseconds per point of V, F and the peers."""
    n, repeats = (400, 3) if quick else (2000, 9)
    times, errors = compete(n, repeats)
    one, two = times["F, 1 thread"], times["F, 2 threads"]
    return {
        "title": "V and the minimal surface F over a grid",
        "grid": [n, n],
        "repeats": repeats,
        "ns_per_point": {name: statistics.median(v) for name, v in times.items()},
        "best_ns_per_point": {name: min(v) for name, v in times.items()},
        "F_in_V": ratio(one, times["V"]),
        "scaling_1_to_2_threads": ratio(one, two),
        "times_faster_than": {
            name: {"1 thread": ratio(times[name], one), "2 threads": ratio(times[name], two)}
            for name in errors
        },
        "largest_relative_error": errors,
    }

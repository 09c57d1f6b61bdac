"""How many canonical tops a second and core: lanes of the Taylor integrator against a compiled and a Python DOP853.

    python bench/bench_ensemble.py [--quick]

Writes bench/results/ensemble.json. The lanes have all events and summaries on; DOP853 (numba, the coefficients and the
step control of SciPy's) integrates nine variables of the same right-hand side and nothing else. Errors are those of
theta after 10 s against 80-bit runs. Processor seconds of interleaved repetitions; ratios are medians of ratios of
neighbouring repetitions: the machine may have other work.
"""

import argparse
import json
import os
import platform
import statistics
import time
from pathlib import Path

import heyoka
import numba
import numpy as np
import scipy
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients as table

from tippetop import ensembles, scenario
from tippetop.friction import Viscous
from tippetop.operand import leaves
from tippetop.solve import solve
from tippetop.systems.gliding import Body, VectorState, vector_rates
from tippetop_kernels.jit import kernel


STAGES = table.N_STAGES
A, B, E3, E5 = table.A[:STAGES, :STAGES].copy(), table.B, table.E3, table.E5
VARIABLES = 9
rates = kernel(vector_rates)


@kernel
def slope(y, b, out):
    """The right-hand side, without quadratures."""
    q = VectorState(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8], 0.0, 0.0, 0.0, 0.0)
    d = rates(q, b)
    out[0], out[1], out[2], out[3], out[4] = d.ux, d.uy, d.uz, d.Lx, d.Ly
    out[5], out[6], out[7], out[8] = d.Lz, d.L3, d.rx_dot, d.ry_dot


@kernel
def dop853(y, end, tolerance, b):
    """Dormand and Prince 8(5,3), as SciPy has it; y is moved to the end. Gives the number of right-hand sides."""
    n, t, h, calls = len(y), 0.0, 1e-3, 1
    K, new = np.empty((STAGES + 1, n)), np.empty(n)
    slope(y, b, K[0])
    rejected = False
    while t < end:
        h = min(h, end - t)
        for s in range(1, STAGES):
            for i in range(n):
                total = 0.0
                for j in range(s):
                    total += A[s, j] * K[j, i]
                new[i] = y[i] + h * total
            slope(new, b, K[s])
        for i in range(n):
            total = 0.0
            for j in range(STAGES):
                total += B[j] * K[j, i]
            new[i] = y[i] + h * total
        slope(new, b, K[STAGES])
        calls += STAGES
        five, three = 0.0, 0.0
        for i in range(n):
            e5, e3 = 0.0, 0.0
            for j in range(STAGES + 1):
                e5 += E5[j] * K[j, i]
                e3 += E3[j] * K[j, i]
            scale = tolerance + tolerance * max(abs(y[i]), abs(new[i]))
            five += (e5 / scale) ** 2
            three += (e3 / scale) ** 2
        error = h * five / np.sqrt((five + 0.01 * three) * n) if five > 0 or three > 0 else 0.0
        if error < 1:
            factor = 10.0 if error == 0 else min(10.0, 0.9 * error**-0.125)
            t += h
            y[:] = new
            K[0] = K[STAGES]
            h *= min(1.0, factor) if rejected else factor
            rejected = False
        else:
            h *= max(0.2, 0.9 * error**-0.125)
            rejected = True
    return calls


def theta(y):
    """theta of a state."""
    return np.arctan2(np.hypot(y[0], y[1]), y[2])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    n, repeats = (32, 3) if options.quick else (128, 7)
    spins = np.linspace(150, 164, n)  # all invert, none lifts off
    tops, faults = ensembles.tops_of("inverting", {"initial.omega3": spins}, 10.0)
    assert not faults
    body = Body(*leaves(tops.base.internal_body)[:6], Viscous(float(tops.pars[6, 0])))
    body = body._make([*map(float, body[:6]), body.friction])
    end = float(tops.end[0])
    some = np.linspace(0, n - 1, 8).astype(int)
    exact = {}
    for i in some.tolist():
        wide = ["run.precision=longdouble", f"initial.omega3={float(spins[i])!r}", "run.output_step=10.0"]
        columns = solve(scenario.load("inverting", wide, 10.0)).columns()
        exact[i] = columns["theta"].values[-1] + columns["theta_lo"].values[-1]

    def compiled(tolerance, which):
        ends = {}
        for i in which:
            y = tops.start[:VARIABLES, i].copy()
            calls = dop853(y, end, tolerance, body)
            ends[i] = theta(y)
        return ends, calls

    ladder = {}
    for tolerance in (1e-12, 3e-13, 1e-13, 3e-14, 1e-14, 3e-15):
        ends, calls = compiled(tolerance, exact)
        ladder[tolerance] = {"error": max(abs(ends[i] - exact[i]) for i in exact), "right-hand sides": calls}
    ours = ensembles.measure(tops, threads=1)
    error = max(abs(ours.columns["theta_end"][i] - exact[i]) for i in exact)
    enough = [t for t, row in ladder.items() if row["error"] <= 1e-12]
    tolerance = max(enough) if enough else min(ladder, key=lambda t: ladder[t]["error"])

    seconds = {"lanes": [], "DOP853 compiled": [], "lanes, 1 thread, wall": [], "lanes, 2 threads, wall": []}
    for _ in range(repeats):
        found = ensembles.measure(tops, threads=1)
        seconds["lanes"].append(found.processor / n)
        seconds["lanes, 1 thread, wall"].append(found.seconds / n)
        seconds["lanes, 2 threads, wall"].append(ensembles.measure(tops, threads=2).seconds / n)
        clock = time.thread_time()
        compiled(tolerance, range(0, n, 4))
        seconds["DOP853 compiled"].append((time.thread_time() - clock) / len(range(0, n, 4)))

    def python(t, y):
        out = np.empty(VARIABLES)
        slope(y, body, out)
        return out

    def formulas(t, y):  # what one would write: the same formulas in Python
        return vector_rates(VectorState(*y, 0.0, 0.0, 0.0, 0.0), body)[:VARIABLES]

    scipys = {}
    for name, function in (("formulas in Python", formulas), ("right-hand side compiled", python)):
        clock, span = time.thread_time(), end / 10
        solve_ivp(function, (0, span), tops.start[:VARIABLES, 0], method="DOP853", rtol=3e-14, atol=tolerance)
        scipys[name] = 10 * (time.thread_time() - clock)

    def ratio(slow, fast):
        return statistics.median(a / b for a, b in zip(seconds[slow], seconds[fast], strict=True))

    lanes = statistics.median(seconds["lanes"])
    result = {
        "machine": f"{platform.machine()}, {os.cpu_count()} processors",
        "load_average": os.getloadavg(),
        "versions": {m.__name__: m.__version__ for m in (heyoka, numba, np, scipy)},
        "tops": n,
        "repeats": repeats,
        "ms_per_top": {name: 1e3 * statistics.median(v) for name, v in seconds.items()},
        "tops_per_second_and_core": 1 / lanes,
        "error_of_theta_after_10_s": {"lanes": error, "DOP853 compiled": ladder[tolerance]["error"]},
        "tolerance_of_DOP853": tolerance,
        "ladder_of_DOP853": {f"{t:g}": row for t, row in ladder.items()},
        "occupancy": found.occupancy,
        "times_faster_than_DOP853_compiled": ratio("DOP853 compiled", "lanes"),
        "times_faster_than_solve_ivp": {name: value / lanes for name, value in scipys.items()},
        "efficiency_of_2_threads": ratio("lanes, 1 thread, wall", "lanes, 2 threads, wall") / 2,
    }
    text = json.dumps(result, indent=2, default=float)
    print(text)
    (Path(__file__).parent / "results" / "ensemble.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

"""How the cost grows with the span, the tolerance, the number of tops and the points of a grid.

A measurement that would exceed the limit is extrapolated from the one before, and marked as such.
"""

import math
import statistics
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tippetop.engine.driver import STEPS_PER_SLICE
from tippetop.engine.taylor import driver_of
from tippetop.ensembles import ensemble
from tippetop.landscape import landscape_body as bodies
from tippetop.landscape import surface, surface_recording
from tippetop.runs import starting
from tippetop.runs.run import solve

from .case_ensemble import tops_at
from .case_surface import FIGURE
from .measure import timed
from .minimal import theta_of
from .ours import ENDLESS, NoRows


LIMIT, QUICK_LIMIT = 60.0, 4.0  # [s] of one measurement


def compare(quick: bool) -> dict[str, Any]:
    """Return tables of cost, with the exponent of a power law fitted to their last decades."""
    limit = QUICK_LIMIT if quick else LIMIT
    return {
        "title": "How the cost grows",
        "span": grown("span [s]", [10.0**k for k in range(1, 7)], span, limit),
        "tops": grown("tops", [10**k for k in range(7)], tops, limit),
        "grid": grown("points", [10**k for k in range(2, 9)], grid, limit / 2),
        "tolerance": tolerance(4 if quick else 1),
        **({} if quick else {"streamed": streamed(10_000)}),
    }


def grown(
    what: str, sizes: Iterable[float], cost: Callable[[float], float], limit: float
) -> dict[str, Any]:
    """Return processor seconds by size, and the exponent of a power law over the last three."""
    rows: list[dict[str, Any]] = []
    cost(next(iter(sizes)))  # compile
    for size in sizes:
        last = rows[-1]["seconds"] * size / rows[-1]["size"] if rows else 0.0
        if last > limit:
            rows.append({"size": size, "seconds": last, "extrapolated": True})
        else:
            repeats = 5 if last < limit / 60 else 1
            rows.append(
                {"size": size, "seconds": statistics.median(cost(size) for _ in range(repeats))}
            )
    measured = [row for row in rows if "extrapolated" not in row][-3:]
    logs = [[math.log(row[name]) for row in measured] for name in ("size", "seconds")]
    exponent = statistics.linear_regression(*logs).slope if len(measured) > 1 else math.nan
    return {"what": what, "rows": rows, "exponent": exponent}


def span(until: float) -> float:
    """Return the cost of a span of a heavy top, with its events, in memory that does not grow."""
    driver = driver_of(starting.load("heavy-top", None, until))

    def work() -> None:
        while driver.advance(NoRows(), STEPS_PER_SLICE).status is None:
            pass

    return timed(work)


def tops(n: float) -> float:
    """Return the cost of n canonical tops for 10 s, on one thread."""
    many = tops_at(np.linspace(150, 164, int(n)), 10.0)
    return timed(lambda: ensemble.measure(many, threads=1))


def grid(points: float) -> float:
    """Return the cost of F over a number of points, on one thread."""
    t, n = bodies.top(FIGURE), round(math.sqrt(points))
    D = 6 * math.sqrt(FIGURE["m"] * FIGURE["g"] * FIGURE["R"] * FIGURE["I3"])
    x, y = np.linspace(-D, D, n), np.linspace(-D * FIGURE["R"], D * FIGURE["R"], round(points / n))
    return timed(lambda: surface.minima(t, x, y, 1))


def tolerance(every: int) -> dict[str, Any]:
    """Return the cost of the canonical inversion, 8 s, from 1e-6 to 1e-18.

    Doubles are used down to 1e-15, 80-bit numbers to the end.
    """
    rows, times = [], np.array([2.0, 4.0, 6.0, 8.0])
    exact = None
    for precision, digits in [
        ("quad", 0),
        *(("double", k) for k in range(6, 16, every)),
        *(("longdouble", k) for k in range(6, 19, every)),
    ]:
        sets = [f"run.precision={precision}"]
        problem = replace(starting.load("inverting", sets, 8.0), times=times)
        if exact is None:
            exact = theta_of(problem, solve(problem).rows)
            continue
        problem = replace(problem, tolerance=10.0**-digits)
        error = np.abs(theta_of(problem, solve(problem).rows) - exact).max()
        seconds = [timed(partial(driver_of(problem).advance, NoRows(), ENDLESS)) for _ in range(5)]
        row = {"tolerance": 10.0**-digits, "precision": precision, "error": float(error)}
        rows.append({**row, "seconds": statistics.median(seconds)})
    return {"rows": rows, "exponents": {p: _exponent(rows, p) for p in ("double", "longdouble")}}


def _exponent(rows: list[dict], precision: str) -> float:
    """Return the exponent of the seconds over the digits."""
    chosen = [row for row in rows if row["precision"] == precision]
    x = [math.log(-math.log10(row["tolerance"])) for row in chosen]
    return statistics.linear_regression(x, [math.log(row["seconds"]) for row in chosen]).slope


def streamed(n: int) -> dict[str, Any]:
    """Return the cost of n x n points of F in a store."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "F.zarr"
        x, y = np.linspace(-8e-4, 9e-4, n), np.linspace(0, 8e-6, n)
        seconds = timed(
            lambda: surface_recording.write(
                path, surface_recording.Surface(FIGURE, x, y), threads=1
            )
        )
        size = sum(p.stat().st_size for p in path.rglob("*") if p.is_file())
    return {"points": n**2, "seconds": seconds, "stored_MB": size / 1e6}

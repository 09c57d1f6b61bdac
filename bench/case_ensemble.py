"""How many canonical tops a second and core: lanes of the Taylor integrator against DOP853, top
after top.

The lanes have all events and summaries on; the peers integrate the minimal state and nothing else.
The errors are those of theta at 6 s, in the midst of the inversion, where they are largest; the
times are those of 10 s. Processor seconds.
"""

import statistics
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np

from tippetop.engine.expressions import equations_of_motion, formulas_of
from tippetop.engine.pools import LANES
from tippetop.ensembles import ensemble
from tippetop.problem import Problems
from tippetop.runs import starting
from tippetop.runs.run import solve

from .measure import elapsed, interleaved, ratio, timed
from .minimal import Minimal, theta_of
from .ours import OURS, TAYLOR
from .peers import CALLING, FIELD, entries, scipy_formulas


CHECKED = 8  # tops that are held against 80-bit runs
MIDST, END = 6.0, 10.0  # [s]
FEW = "tippetop, lanes, class and inverted_at"
PYTHON = "DOP853, SciPy, formulas in Python"
PEERS = ("DOP853, C++", "DOP853, numbalsoda")


def tops_at(spins: np.ndarray, until: float, tolerance: float = 0.0) -> Problems:
    """Canonical tops with these spins [rad/s]."""
    tops = ensemble.vary(starting.load("inverting", None, until), {"initial.omega3": spins})
    assert tops.valid.all()
    return Problems(replace(tops.base, tolerance=tolerance or tops.base.tolerance), tops.columns)


def compare(quick: bool) -> dict[str, Any]:
    """Errors and seconds a top of the lanes and of the compiled peers."""
    n = 32 if quick else 128
    spins = np.linspace(150, 164, n)  # all invert, none lifts off
    some = np.linspace(0, n - 1, CHECKED).astype(int)
    exact = np.array([_exact(float(spin)) for spin in spins[some]])
    found: dict[str, Any] = {
        "title": "One of many canonical tops",
        "until": END,
        "tops": n,
        "contestants": {},
    }
    works: dict = {}
    entry = found["contestants"]["tippetop, lanes"] = {"kind": OURS, "points": []}
    for tolerance in TAYLOR:
        theta = ensemble.measure(tops_at(spins[some], MIDST, tolerance), threads=1).columns[
            "theta_end"
        ]
        tops = tops_at(spins, END, tolerance)
        works["tippetop, lanes", len(entry["points"])] = partial(_lanes, tops)
        entry["points"].append(
            {"tolerance": tolerance, "error": float(np.abs(theta - exact).max())}
        )
    points = found["contestants"]["tippetop, lanes"]["points"]
    entry = found["contestants"][FEW] = {
        "kind": OURS,
        "points": [dict(point) for point in points],
    }  # the same bits
    for i, tolerance in enumerate(TAYLOR):
        works[FEW, i] = partial(_lanes, tops_at(spins, END, tolerance), ("class", "inverted_at"))
    entry = found["contestants"]["tippetop, lanes, motion alone"] = {"kind": OURS, "points": []}
    for tolerance in TAYLOR:
        theta = theta_of(
            replace(tops.base, orientation=False), batched(tops_at(spins[some], MIDST, tolerance))()
        )
        work = batched(tops_at(spins[:LANES], END, tolerance))
        works["tippetop, lanes, motion alone", len(entry["points"])] = lambda work=work: (
            timed(work) / LANES
        )
        entry["points"].append(
            {"tolerance": tolerance, "error": float(np.abs(theta - exact).max())}
        )
    peers = [peer for peer in FIELD if peer.name in PEERS]
    found["contestants"] |= entries(
        peers, lambda entry, peer: _enter(entry, works, peer, spins, some, exact)
    )
    _enter_python(found["contestants"], works, float(spins[0]), exact[0])
    for (name, i), times in interleaved(works, 3 if quick else 5).items():
        found["contestants"][name]["points"][i] |= {
            "rounds": times,
            "seconds": statistics.median(times),
        }
    return found | _threads(tops_at(spins, END), 3 if quick else 7)


def _enter(
    entry: dict, works: dict, peer: Any, spins: np.ndarray, some: np.ndarray, exact: np.ndarray
) -> None:
    """A peer's errors, and its work among the works; it integrates every fourth top."""
    entry["points"] = []
    checked = [peer.prepare(_minimal(float(spin), MIDST)) for spin in spins[some]]
    paced = [peer.prepare(_minimal(float(spin), END)) for spin in spins[::4]]
    for tolerance in peer.tolerances[1:]:
        theta = np.array([solver(tolerance).theta()[-1] for solver in checked])
        solvers = [solver(tolerance) for solver in paced]
        works[peer.name, len(entry["points"])] = lambda solvers=solvers: _one_by_one(solvers)
        entry["points"].append(
            {"tolerance": tolerance, "error": float(np.abs(theta - exact).max())}
        )


def _enter_python(contestants: dict, works: dict, spin: float, exact: np.longdouble) -> None:
    """SciPy with the formulas in Python: one top is enough to be slow."""
    entry = contestants[PYTHON] = {"kind": CALLING, "points": []}
    checked, paced = (scipy_formulas(_minimal(spin, until)) for until in (MIDST, END))
    for tolerance in (1e-13, 3e-14):
        works[PYTHON, len(entry["points"])] = partial(_one_by_one, [paced(tolerance)])
        error = abs(float(checked(tolerance).theta()[-1] - exact))
        entry["points"].append({"tolerance": tolerance, "error": error})


def _minimal(spin: float, until: float) -> Minimal:
    return Minimal(
        starting.load("inverting", [f"initial.omega3={spin!r}"], until), np.array([until])
    )


def _exact(spin: float) -> np.longdouble:
    wide = starting.load(
        "inverting", ["run.precision=longdouble", f"initial.omega3={spin!r}"], MIDST
    )
    return theta_of(wide, solve(replace(wide, times=np.array([MIDST]))).rows)[0]


def batched(tops: Problems) -> Callable[[], np.ndarray]:
    """heyoka's batch integrator on the motion alone, no integrals, events or tallies; gives rows
    (n, variables).
    """
    base = tops.base
    equations = equations_of_motion(
        formulas_of(base.system, base.form.name, type(base.friction)), tops.variables
    ).rates
    kept = list(range(tops.variables.moving))
    start, rows = tops.start[kept], np.zeros((tops.n, len(equations)))
    made = hy.taylor_adaptive_batch(
        [equations[i] for i in kept],
        start.copy(),
        pars=tops.pars.copy(),
        tol=base.tolerance or 2.0**-52,
        high_accuracy=True,
    )

    def work() -> np.ndarray:
        made.set_time(0.0)
        made.state[:] = start
        made.propagate_until(tops.end)
        rows[:, kept] = made.state.T
        return rows

    return work


def _lanes(tops: Problems, wanted: tuple[str, ...] | None = None) -> float:
    return timed(lambda: ensemble.measure(tops, threads=1, wanted=wanted)) / tops.n


def _one_by_one(solvers: list) -> float:
    return timed(lambda: [solver.work(None) for solver in solvers]) / len(solvers)


def _threads(tops: Problems, rounds: int) -> dict[str, Any]:
    """What a second thread brings, by the wall clock."""
    works = {k: partial(elapsed, partial(ensemble.measure, tops, threads=k)) for k in (1, 2)}
    seconds = interleaved(works, rounds)
    return {
        "seconds_per_top_by_the_wall": {
            k: statistics.median(times) / tops.n for k, times in seconds.items()
        },
        "efficiency_of_2_threads": ratio(seconds[1], seconds[2]) / 2,
    }

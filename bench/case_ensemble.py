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

from .measure import interleaved, timed
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
    """Errors and seconds a top of the lanes and of the compiled peers; these take every 4th top."""
    n = 32 if quick else 128
    spins = np.linspace(150, 164, n)  # all invert, none lifts off
    some = spins[np.linspace(0, n - 1, CHECKED).astype(int)]
    exact = np.array([_exact(float(spin)) for spin in some])
    works: dict = {}

    def enter(
        entry: dict[str, Any],
        name: str,
        tolerances: tuple[float, ...],
        theta: Callable[[float], Any],
        work: Callable[[float], Callable[[], float]],
    ) -> dict[str, Any]:
        """Enter the errors of a contestant by tolerance, and its work of a top among the works."""
        entry["points"] = []
        for i, tolerance in enumerate(tolerances):
            found = np.atleast_1d(theta(tolerance))
            error = float(np.abs(found - exact[: len(found)]).max())
            works[name, i] = work(tolerance)
            entry["points"].append({"tolerance": tolerance, "error": error})
        return entry

    def of_lanes(tolerance: float) -> np.ndarray:
        measured = ensemble.measure(tops_at(some, MIDST, tolerance), threads=1)
        return measured.columns["theta_end"]

    def of_motion(tolerance: float) -> np.ndarray:
        tops = tops_at(some, MIDST, tolerance)
        return theta_of(replace(tops.base, orientation=False), batched(tops)())

    def lanes(wanted: tuple[str, ...] | None) -> Callable:
        return lambda tolerance: partial(_lanes, tops_at(spins, END, tolerance), wanted)

    def motion(tolerance: float) -> Callable[[], float]:
        work = batched(tops_at(spins[:LANES], END, tolerance))
        return lambda: timed(work) / LANES

    def enter_peer(
        entry: dict[str, Any], name: str, prepare: Callable, tolerances: Any, checked: Any, run: Any
    ) -> dict[str, Any]:
        at_midst = [prepare(_minimal(float(spin), MIDST)) for spin in checked]
        to_end = [prepare(_minimal(float(spin), END)) for spin in run]
        return enter(
            entry,
            name,
            tolerances,
            lambda tolerance: [solver(tolerance).theta()[-1] for solver in at_midst],
            lambda tolerance: partial(_one_by_one, [solver(tolerance) for solver in to_end]),
        )

    ways = {
        "tippetop, lanes": (of_lanes, lanes(None)),
        FEW: (of_lanes, lanes(("class", "inverted_at"))),
        "tippetop, lanes, motion alone": (of_motion, motion),
    }
    contestants = {name: enter({"kind": OURS}, name, TAYLOR, *way) for name, way in ways.items()}
    contestants |= entries(
        [peer for peer in FIELD if peer.name in PEERS],
        lambda entry, peer: enter_peer(
            entry, peer.name, peer.prepare, peer.tolerances[1:], some, spins[::4]
        ),
    )
    contestants[PYTHON] = enter_peer(  # one top is enough to be slow
        {"kind": CALLING}, PYTHON, scipy_formulas, (1e-13, 3e-14), spins[:1], spins[:1]
    )
    for (name, i), times in interleaved(works, 3 if quick else 5).items():
        contestants[name]["points"][i] |= {"rounds": times, "seconds": statistics.median(times)}
    title = "One of many canonical tops"
    return {"title": title, "until": END, "tops": n, "contestants": contestants}


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

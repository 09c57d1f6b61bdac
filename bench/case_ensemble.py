"""How many canonical tops a second and core: lanes of the Taylor integrator against DOP853, top
after top.

The lanes have all events and summaries on; the peers integrate the minimal state and nothing else.
The errors are those of theta at 6 s, in the midst of the inversion, where they are largest; the
times are those of 10 s. Processor seconds.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tippetop.ensembles import ensemble
from tippetop.problem import Problems
from tippetop.runs import starting
from tippetop.runs.run import solve

from .case_precision import contest
from .minimal import Minimal, theta_of
from .ours import OURS, TAYLOR
from .peers import FIELD, Peer, Solver


CHECKED = 8  # tops that are held against 80-bit runs
MIDST, END = 6.0, 10.0  # [s]
PEERS = ("DOP853, C++", "DOP853, numbalsoda")


class Spins(NamedTuple):
    """The spins of canonical tops [rad/s]: of those that are checked, and of all."""

    checked: np.ndarray
    all: np.ndarray


def compare(quick: bool) -> dict[str, Any]:
    """Errors and seconds a top of the lanes and of the compiled peers; these take every 4th top."""
    n = 32 if quick else 128
    spins = np.linspace(150, 164, n)  # all invert, none lifts off
    checked = spins[np.linspace(0, n - 1, CHECKED).astype(int)]
    exact = np.array([_exact(float(spin)) for spin in checked])
    field = (
        Peer("tippetop, lanes", OURS, in_lanes, tolerances=TAYLOR),
        *(
            peer._replace(prepare=partial(one_by_one, peer), tolerances=peer.tolerances[1:])
            for peer in FIELD
            if peer.name in PEERS
        ),
    )
    return {
        "title": "One of many canonical tops",
        "until": END,
        "tops": n,
        "contestants": contest(field, Spins(checked, spins), exact, quick),
    }


def in_lanes(spins: Spins) -> Callable[[float], Solver]:
    """All tops together, with events and summaries, on one thread."""

    def tops(of: np.ndarray, until: float, tolerance: float) -> Problems:
        made = ensemble.vary(starting.load("inverting", None, until), {"initial.omega3": of})
        assert made.valid.all()
        base = replace(made.base, tolerance=tolerance or made.base.tolerance)
        return Problems(base, made.columns)

    def solver(tolerance: float) -> Solver:
        to_midst = tops(spins.checked, MIDST, tolerance)
        to_end = tops(spins.all, END, tolerance)
        return Solver(
            lambda _: ensemble.measure(to_end, threads=1),
            lambda: ensemble.measure(to_midst, threads=1).columns["theta_end"],
            tops=to_end.n,
        )

    return solver


def one_by_one(peer: Peer, spins: Spins) -> Callable[[float], Solver]:
    """Every fourth top by a peer, one after the other."""
    to_midst = [peer.prepare(_minimal(float(spin), MIDST)) for spin in spins.checked]
    to_end = [peer.prepare(_minimal(float(spin), END)) for spin in spins.all[::4]]

    def solver(tolerance: float) -> Solver:
        made = [prepared(tolerance) for prepared in to_end]
        return Solver(
            lambda _: [each.work(None) for each in made],
            lambda: np.array([prepared(tolerance).theta()[-1] for prepared in to_midst]),
            tops=len(made),
        )

    return solver


def _minimal(spin: float, until: float) -> Minimal:
    return Minimal(
        starting.load("inverting", [f"initial.omega3={spin!r}"], until), np.array([until])
    )


def _exact(spin: float) -> np.longdouble:
    wide = starting.load(
        "inverting", ["run.precision=longdouble", f"initial.omega3={spin!r}"], MIDST
    )
    return theta_of(wide, solve(replace(wide, times=np.array([MIDST]))).rows)[0]

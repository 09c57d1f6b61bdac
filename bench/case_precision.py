"""Work against precision: every contestant at every tolerance, theta against an integration in
wider numbers.
"""

import statistics
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tippetop.runs import starting
from tippetop.runs.run import solve

from . import ours
from .measure import interleaved, timed
from .minimal import Minimal, apart, theta_of
from .peers import CALLING, COMPILED, FIELD, Peer, Solver, sentence


SAMPLES = 32  # times at which theta is compared, equally far apart, the end among them


class Comparison(NamedTuple):
    """A motion to be integrated by everybody."""

    title: str
    preset: str
    until: float  # [s]
    quick: float  # [s]
    wide: str  # the precision of the reference
    everybody: bool  # or only those that do not call back into Python


def compare(comparison: Comparison, quick: bool) -> dict[str, Any]:
    """Errors and seconds of all contestants."""
    until = comparison.quick if quick else comparison.until
    samples = until * np.arange(1, SAMPLES + 1) / SAMPLES
    minimal = Minimal(starting.load(comparison.preset, None, until), samples)
    hand = (ours.HAND,) if comparison.preset == "inverting" else ()
    field = [peer for peer in FIELD if comparison.everybody or peer.kind != CALLING]
    peers = (*ours.ENGINE, *hand, *field)
    return {
        "title": comparison.title,
        "until": until,
        "reference": comparison.wide,
        "contestants": contest(peers, minimal, reference(comparison, samples), quick),
    }


def contest(
    peers: Iterable[Peer], task: Any, exact: np.ndarray, quick: bool
) -> dict[str, dict[str, Any]]:
    """Return the errors and seconds of each peer by its name; of a missing one the reason.

    A peer that breaks is a result, and not the end of the others.
    """
    found: dict[str, dict[str, Any]] = {}
    works: dict = {}
    for peer in peers:
        entry = found[peer.name] = {"kind": peer.kind}
        try:
            if peer.missing:
                entry["missing"] = peer.missing
            else:
                enter(entry, works, peer, task, exact, quick)
        except Exception as error:
            entry["missing"] = sentence(error)
    slow = {key: works.pop(key) for key in list(works) if _slow(found[key[0]])}
    seconds = interleaved(works, 3 if quick else 7) | interleaved(slow, 1 if quick else 3)
    for (name, i), times in seconds.items():
        found[name]["points"][i] |= {"rounds": times, "seconds": statistics.median(times)}
    return found


def _slow(entry: dict[str, Any]) -> bool:
    """Whether a contestant gets fewer rounds: diffrax is compiled, but not quick."""
    return entry["kind"] == CALLING or (
        entry["kind"] == COMPILED and entry["points"][-1]["first"] > 1
    )


def enter(entry: dict, works: dict, peer: Peer, task: Any, exact: np.ndarray, quick: bool) -> None:
    """A contestant's errors, and its work among the works, down to the tolerance that
    it refuses.
    """
    tolerances = peer.tolerances[::-2][::-1] if quick else peer.tolerances
    solver = peer.prepare(task)
    entry["points"] = []
    for tolerance in tolerances:
        theta: list[np.ndarray] = []
        try:
            made = solver(tolerance)
            first = timed(lambda made=made, theta=theta: theta.append(made.theta()))
            wrong = apart(theta[0], exact)
            if not np.all(np.isfinite(wrong)):
                raise ArithmeticError("theta is not finite")
        except Exception as error:
            if not entry["points"]:
                raise
            entry["stopped"] = f"at {tolerance:g}: {sentence(error)}"
            return
        works[peer.name, len(entry["points"])] = partial(once, made)
        point = {"tolerance": tolerance, "error": float(wrong.max()), "first": first}
        entry["points"].append(point)


def once(solver: Solver) -> float:
    """Processor seconds of one solution, of each top."""
    ready = solver.setup()
    return timed(lambda: solver.work(ready)) / solver.tops


def reference(comparison: Comparison, samples: np.ndarray) -> np.ndarray:
    """theta at the samples [rad], by the engine in wider numbers; the tests hold the engine against
    an independent multi-precision integration.
    """
    wide = starting.load(
        comparison.preset,
        [f"run.precision={comparison.wide}"],
        float(samples[-1]),
    )
    wide = replace(wide, times=samples)
    return theta_of(wide, solve(wide).rows)

"""The goals: ratios side by side, at equal measured error."""

import math
from typing import Any, NamedTuple

from .equal import best_peer, common, points, ratio


ERROR = 1e-13
BARE, EVENTS, LANES = "tippetop, equations only", "tippetop, events on", "tippetop, lanes"
HAND = "heyoka by hand"


class Goal(NamedTuple):
    """What is wanted, what was measured, and whether that is enough."""

    what: str
    goal: str
    measured: str
    met: bool | None  # None: not measured


def goals(results: dict[str, Any]) -> list[Goal]:
    """Every goal, met or not. What was not run says so."""
    found = []
    for what, goal, case, judge in GOALS:
        try:
            measured, met = judge(results[case]) if case in results else (f"not run: --case {case}", None)
        except LookupError as error:
            measured, met = f"not measured: {error}", None
        found.append(Goal(what, goal, measured, met))
    return found


def _against(contestants: dict[str, Any], peer: str, ours: str, wanted: float, factor: float) -> tuple[str, bool]:
    if "points" not in contestants[peer]:
        raise LookupError(f"{peer} is missing")
    error = common(wanted, contestants[peer], contestants[ours])
    times = ratio(contestants[peer], contestants[ours], error)
    return f"{times:.3g} times, against {peer}, both at {error:.1e}", times >= factor


def _inversion(result: dict[str, Any]) -> tuple[str, bool]:
    contestants = result["contestants"]
    return _against(contestants, best_peer(contestants, contestants[BARE], ERROR), BARE, ERROR, 4)


def _smallest(result: dict[str, Any]) -> tuple[str, bool]:
    contestants = result["contestants"]
    peer = best_peer(contestants, contestants[BARE], 0.0)
    theirs, ours = points(contestants[peer])[-1], points(contestants[BARE])[-1]
    times, digits = theirs["seconds"] / ours["seconds"], math.log10(theirs["error"] / ours["error"])
    said = f"{times:.3g} times and {digits:.1f} digits more, against {peer} at its {theirs['error']:.1e}"
    return said, times >= 2 and digits >= 2


def _ensemble(result: dict[str, Any]) -> tuple[str, bool]:
    contestants = result["contestants"]
    return _against(contestants, best_peer(contestants, contestants[LANES], ERROR), LANES, ERROR, 12)


def _scipy(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], "DOP853, SciPy", BARE, ERROR, 200)


def _plain(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], HAND, BARE, ERROR, 1.3)


def _plain_events(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], HAND, EVENTS, ERROR, 1)


def _surface(result: dict[str, Any]) -> tuple[str, None]:
    return f"{result['F_in_V']:.3g} evaluations of V", None


def _golden(result: dict[str, Any]) -> tuple[str, None]:
    times = result["times_faster_than"]["golden section, jitted"]["1 thread"]
    return f"{times:.3g} times, thread against thread", None


GOALS: tuple[tuple[str, str, str, Any], ...] = (
    ("one canonical inversion at 1e-13, against the best compiled peer", ">= 4 times", "inversion", _inversion),
    ("the same at the smallest error that the peer reaches", ">= 2 times, two digits more", "inversion", _smallest),
    ("ensemble, per core, against the best compiled peer per core", ">= 12 times", "ensemble", _ensemble),
    ("against SciPy's solve_ivp with a jitted right-hand side", ">= 200 times", "inversion", _scipy),
    ("against heyoka written by hand (no events, no store)", ">= 1.3 times", "inversion", _plain),
    ("with turning and liftoff events on, against the same without them", ">= 1 times", "inversion", _plain_events),
    ("F at a point of a grid, one thread", "", "surface", _surface),
    ("F against a jitted golden section", "", "surface", _golden),
)  # fmt: skip

"""The goals: ratios side by side, at equal measured error."""

import math
from typing import Any, NamedTuple

from .equal import best_peer, common, points, ratio


ERROR = 1e-13
WHOLE, FEW, TOGETHER = (
    "tippetop, whole run without rows",
    "tippetop, lanes, class and inverted_at",
    "DOP853, C++",
)
LANES_ALONE = "tippetop, lanes, motion alone"
BARE, EVENTS, LANES = (
    "tippetop, motion alone",
    "tippetop, motion, turnings, liftoff",
    "tippetop, lanes",
)
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
            measured, met = (
                judge(results[case]) if case in results else (f"not run: --case {case}", None)
            )
        except LookupError as error:
            measured, met = f"not measured: {error}", None
        found.append(Goal(what, goal, measured, met))
    return found


def _against(
    contestants: dict[str, Any], peer: str, ours: str, wanted: float, factor: float
) -> tuple[str, bool]:
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
    said = (
        f"{times:.3g} times and {digits:.1f} digits more, against {peer} at its "
        f"{theirs['error']:.1e}"
    )
    return said, times >= 2 and digits >= 2


def _by_kind(result: dict[str, Any], amd: float, intel: float) -> float:
    """A goal that depends on whose processor it is."""
    return amd if "AMD" in result["machine"]["processor"] else intel


def _peer_at_its_best(ours: str, amd: float, intel: float) -> Any:
    """Ours against C++ DOP853, at the smallest error that this reaches."""

    def judge(result: dict[str, Any]) -> tuple[str, bool]:
        contestants, factor = result["contestants"], _by_kind(result, amd, intel)
        said, met = _against(contestants, TOGETHER, ours, 0.0, factor)
        return f"{said} ({factor:g} on this processor)" if amd != intel else said, met

    return judge


def _lanes_beside(ours: str, most: float) -> Any:
    """Lanes with what is kept against lanes that keep nothing."""

    def judge(result: dict[str, Any]) -> tuple[str, bool]:
        contestants = result["contestants"]
        if ours not in contestants:
            raise LookupError(f"{ours} was not run")
        error = common(ERROR, contestants[ours], contestants[LANES_ALONE])
        times = ratio(contestants[ours], contestants[LANES_ALONE], error)
        return f"{times:.3g} times, both at {error:.1e}", times <= most

    return judge


def _lanes_against(ours: str, amd: float, intel: float) -> Any:
    """Lanes against the best compiled peer, per core."""

    def judge(result: dict[str, Any]) -> tuple[str, bool]:
        contestants, factor = result["contestants"], _by_kind(result, amd, intel)
        if ours not in contestants:
            raise LookupError(f"{ours} was not run")
        said, met = _against(
            contestants, best_peer(contestants, contestants[ours], ERROR), ours, ERROR, factor
        )
        return f"{said} ({factor:g} on this processor)", met

    return judge


def _hops(result: dict[str, Any]) -> tuple[str, bool]:
    return f"{result['hops']['ratio']:.3g} times", result["hops"]["ratio"] <= 2


def _beside_motion(result: dict[str, Any]) -> tuple[str, bool]:
    most = dict(zip(result["runs"], (1.6, 1.6, 2.5, 5), strict=True))
    times = {name: entry["whole / motion"] for name, entry in result["runs"].items()}
    return ", ".join(f"{x:.3g}" for x in times.values()), all(
        times[name] <= most[name] for name in times
    )


def _rows_by_hand(result: dict[str, Any]) -> tuple[str, bool]:
    times = next(
        entry["rows / by hand"] for entry in result["runs"].values() if "rows / by hand" in entry
    )
    return f"{times:.3g} times", times <= 2.5


def _processors(result: dict[str, Any]) -> tuple[str, bool]:
    most = max(entry["processor / wall"] for entry in result["runs"].values())
    threads = max(entry.get("all threads / one", 1.0) for entry in result["runs"].values())
    return f"{most:.3g} at most; all threads / the one that works {threads:.3g}", max(
        most, threads
    ) <= 1.1


def _stored(way: str, most: float) -> Any:
    def judge(result: dict[str, Any]) -> tuple[str, bool]:
        times = {
            name: entry[f"{way} / bare"]
            for name, entry in result["runs"].items()
            if f"{way} / bare" in entry
        }
        if not times:
            raise LookupError(f"{way}")
        return ", ".join(f"{x:.3g}" for x in times.values()), max(times.values()) <= most

    return judge


def _python(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], "DOP853, SciPy, formulas in Python", LANES, ERROR, 1000)


def _workers(result: dict[str, Any]) -> tuple[str, bool]:
    said = f"{result['efficiency_of_2_workers']:.2f}"
    if "processor_of_1_and_2_workers" in result:
        one, two = result["processor_of_1_and_2_workers"]
        said += f" by the wall; {one / two:.2f} by the processor's time"
    return said, result["efficiency_of_2_workers"] >= 0.95


def _overhead(result: dict[str, Any]) -> tuple[str, bool]:
    added = result["ways"]["into a store, by the worker"]["processor"] - 1
    return f"{100 * added:.1f} % of the processor's time", added <= 0.05


def _started(what: str, most: float) -> Any:
    def judge(result: dict[str, Any]) -> tuple[str, bool]:
        if what not in result:
            raise LookupError(what)
        return f"{result[what]['wall']:.2f} s", result[what]["wall"] <= most

    return judge


def _scipy(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], "DOP853, SciPy", BARE, ERROR, 200)


def _plain(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], HAND, BARE, ERROR, 1.3)


def _plain_events(result: dict[str, Any]) -> tuple[str, bool]:
    return _against(result["contestants"], HAND, EVENTS, ERROR, 1)


def _surface(result: dict[str, Any]) -> tuple[str, bool]:
    return f"{result['F_in_V']:.3g} evaluations of V", result["F_in_V"] <= 12


def _golden(result: dict[str, Any]) -> tuple[str, bool]:
    return _faster(result, "golden section, jitted", "1 thread", 8)


def _golden_numpy(result: dict[str, Any]) -> tuple[str, bool]:
    return _faster(result, "golden section, NumPy", "1 thread", 50)


def _minimize(result: dict[str, Any]) -> tuple[str, bool]:
    return _faster(result, "scipy", "2 threads", 20_000)


def _faster(result: dict[str, Any], peer: str, threads: str, factor: float) -> tuple[str, bool]:
    times = result["times_faster_than"][peer][threads]
    return f"{times:.0f} times, on {threads}", times >= factor


def _threads(result: dict[str, Any]) -> tuple[str, bool]:
    times, best = result["scaling_1_to_2_threads"], result["best_ns_per_point"]
    said = (
        f"{times:.3g} times; by the best repetitions "
        f"{best['F, 1 thread'] / best['F, 2 threads']:.3g}"
    )
    return said, times >= 1.7


GOALS: tuple[tuple[str, str, str, Any], ...] = (
    (
        "one canonical inversion at 1e-13, against the best compiled peer",
        ">= 4 times",
        "inversion",
        _inversion,
    ),
    (
        "the same at the smallest error that the peer reaches",
        ">= 2 times, two digits more",
        "inversion",
        _smallest,
    ),
    (
        "whole run / its motion: inversion, rolling, heavy top, cylinder",
        "<= 1.6, 1.6, 2.5, 5",
        "whole",
        _beside_motion,
    ),
    (
        "a whole canonical run against C++ DOP853's bare motion at its best",
        ">= 1.6 (AMD), 1.3 (Intel)",
        "inversion",
        _peer_at_its_best(WHOLE, 1.6, 1.3),
    ),
    (
        "the canonical run with its rows in memory against heyoka by hand without any",
        "<= 2.5 times",
        "whole",
        _rows_by_hand,
    ),
    (
        "the motion of an inversion against C++ DOP853 at its best",
        ">= 3 times",
        "inversion",
        _peer_at_its_best(BARE, 3, 3),
    ),
    (
        "the motion of a rolling top against C++ DOP853 at its best",
        ">= 2.5 times",
        "rolling",
        _peer_at_its_best(BARE, 2.5, 2.5),
    ),
    (
        "the motion of a heavy top against C++ DOP853 at its best",
        ">= 5 times",
        "heavy-top",
        _peer_at_its_best(BARE, 5, 5),
    ),
    (
        "a top in lanes with all that is kept / in lanes alone",
        "<= 1.8 times",
        "ensemble",
        _lanes_beside(LANES, 1.8),
    ),
    (
        "the same with its class and inverted_at only",
        "<= 1.25 times",
        "ensemble",
        _lanes_beside(FEW, 1.25),
    ),
    (
        "ensemble, per core, against the best compiled peer per core",
        ">= 9 times (AMD), 6 (Intel)",
        "ensemble",
        _lanes_against(LANES, 9, 6),
    ),
    (
        "the same with class and inverted_at only",
        ">= 12 times (AMD), 8 (Intel)",
        "ensemble",
        _lanes_against(FEW, 12, 8),
    ),
    ("a second of a top that hops / of one that slides", "<= 2 times", "whole", _hops),
    ("processor time / wall time of a run", "<= 1.1", "whole", _processors),
    ("`tippetop run inverting`, warm", "<= 0.6 s", "startup", _started("alone", 0.6)),
    ("`tippetop --help`", "<= 0.12 s", "startup", _started("help", 0.12)),
    (
        "the same against SciPy's solve_ivp, formulas in Python",
        ">= 1000 times",
        "ensemble",
        _python,
    ),
    ("two workers of a sweep, efficiency", ">= 0.95", "sweep", _workers),
    ("dask and the store of a sweep, added to the tops alone", "<= 5 %", "sweep", _overhead),
    (
        "stored with keyframes / equations alone",
        "<= 1.25 times",
        "storing",
        _stored("keyframes", 1.25),
    ),
    (
        "stored at 1 kHz, three columns / equations alone",
        "<= 2 times",
        "storing",
        _stored("three", 2),
    ),
    (
        "stored at 1 kHz, all columns / equations alone",
        "<= 4 times",
        "storing",
        _stored("stored", 4),
    ),
    (
        "against SciPy's solve_ivp with a jitted right-hand side",
        ">= 200 times",
        "inversion",
        _scipy,
    ),
    ("against heyoka written by hand (no events, no store)", ">= 1.3 times", "inversion", _plain),
    (
        "with turning and liftoff events on, against the same without them",
        ">= 1 times",
        "inversion",
        _plain_events,
    ),
    ("F at a point of a grid, one thread", "<= 12 of V", "surface", _surface),
    ("F against a jitted golden section", ">= 8 times", "surface", _golden),
    ("F against a golden section in NumPy", ">= 50 times", "surface", _golden_numpy),
    (
        "F against scipy.optimize.minimize_scalar on a jitted V",
        ">= 20000 times",
        "surface",
        _minimize,
    ),
    ("F by two threads against one", ">= 1.7 times", "surface", _threads),
)

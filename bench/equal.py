"""Contestants at equal error: between the measured points, by straight lines in the logarithms."""

import math
import statistics
from typing import Any


def points(entry: dict[str, Any]) -> list[dict[str, Any]]:
    """The points of a contestant that no other point of it beats in both error and seconds, from
    rough to exact.
    """
    best: list[dict[str, Any]] = []
    for point in sorted(entry.get("points", []), key=lambda p: p["error"]):
        if not best or point["seconds"] < best[-1]["seconds"]:
            best.append(point)
    return best[::-1]


def least(entry: dict[str, Any]) -> float:
    """The smallest error a contestant reaches; infinite for one that is missing."""
    return min((p["error"] for p in entry.get("points", [])), default=math.inf)


def seconds(entry: dict[str, Any], error: float, of: Any = lambda p: p["seconds"]) -> float:
    """What an error costs a contestant [s]; infinite where it does not reach it.

    No less than its roughest point.
    """
    found = points(entry)
    if not found or error < found[-1]["error"] * (1 - 1e-12):
        return math.inf
    if error >= found[0]["error"]:
        return of(found[0])
    right = next(i for i, p in enumerate(found) if p["error"] <= error * (1 + 1e-12))
    a, b = found[right - 1], found[right]
    part = math.log(a["error"] / error) / math.log(a["error"] / b["error"])
    return of(a) ** (1 - part) * of(b) ** part


def ratio(slow: dict[str, Any], fast: dict[str, Any], error: float) -> float:
    """How many times faster the second is at an error: the median over rounds, if both ran in the
    same rounds.
    """
    counts = {len(p["rounds"]) for entry in (slow, fast) for p in entry["points"]}
    if len(counts) > 1:
        return seconds(slow, error) / seconds(fast, error)
    rounds = range(counts.pop())
    return statistics.median(
        seconds(slow, error, lambda p, i=i: p["rounds"][i])
        / seconds(fast, error, lambda p, i=i: p["rounds"][i])
        for i in rounds
    )


def common(wanted: float, *entries: dict[str, Any]) -> float:
    """The error at which all can be compared: the wanted one, or the smallest that all reach."""
    return max(wanted, *(least(entry) for entry in entries))


def best_peer(contestants: dict[str, Any], ours: dict[str, Any], wanted: float) -> str:
    """The compiled peer that fares best against ours at an error, or as near to it as both come.

    Those that stop a digit above what another peer reaches do not count.
    """
    peers = [
        name for name, entry in contestants.items() if entry["kind"] == "compiled" and points(entry)
    ]
    if not peers:
        raise LookupError("no compiled peer took part")
    near = 10 * max(wanted, min(least(contestants[name]) for name in peers))
    exact = [name for name in peers if least(contestants[name]) <= near]
    return min(
        exact,
        key=lambda name: ratio(contestants[name], ours, common(wanted, contestants[name], ours)),
    )

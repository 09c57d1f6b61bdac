"""Compare contestants at equal error, by log-log interpolation between measured points."""

import math
from typing import Any


def points(entry: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the points that no other point beats in both error and time, worst error first."""
    best: list[dict[str, Any]] = []
    for point in sorted(entry.get("points", []), key=lambda p: p["error"]):
        if not best or point["seconds"] < best[-1]["seconds"]:
            best.append(point)
    return best[::-1]


def least(entry: dict[str, Any]) -> float:
    """Return the smallest error of a contestant; infinite if it was not measured."""
    return min((p["error"] for p in entry.get("points", [])), default=math.inf)


def seconds(entry: dict[str, Any], error: float) -> float:
    """Return the time [s] of a contestant at an error; infinite if it does not reach the error."""
    found = points(entry)
    if not found or error < found[-1]["error"] * (1 - 1e-12):
        return math.inf
    if error >= found[0]["error"]:
        return found[0]["seconds"]
    right = next(i for i, p in enumerate(found) if p["error"] <= error * (1 + 1e-12))
    a, b = found[right - 1], found[right]
    part = math.log(a["error"] / error) / math.log(a["error"] / b["error"])
    return a["seconds"] ** (1 - part) * b["seconds"] ** part


def ratio(slow: dict[str, Any], fast: dict[str, Any], error: float) -> float:
    """Return how many times faster the second contestant is at an error."""
    return seconds(slow, error) / seconds(fast, error)


def common(wanted: float, *entries: dict[str, Any]) -> float:
    """Return the smallest error that all contestants reach, and not less than `wanted`."""
    return max(wanted, *(least(entry) for entry in entries))

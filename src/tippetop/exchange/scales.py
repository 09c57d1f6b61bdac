"""How a free number is searched: in which coordinate, and within which bounds."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..mechanics.parameter import Parameter


WIDEST = float(np.log(20))  # how far the logarithm of a number may go from where it starts
MARGIN = 1e-6  # by which a start lies within the bounds


class Scale(NamedTuple):
    """The coordinate of a free number: its logarithm where it must be positive, else itself in units of `size`."""

    logarithmic: bool
    size: float
    low: float
    high: float

    def inside(self, value: float) -> float:
        """The coordinate of a value."""
        return float(np.log(value)) if self.logarithmic else value / self.size

    def outside(self, inside: float) -> float:
        """The value of a coordinate."""
        return math.exp(min(max(inside, -600.0), 600.0)) if self.logarithmic else float(inside * self.size)

    def slope(self, value: float) -> float:
        """d value/d coordinate."""
        return value if self.logarithmic else self.size


def scale_of(rule: Parameter, value: float) -> Scale:
    """The scale of a number, by its interval and where it starts."""
    low = max((b for b in (rule.above, rule.least) if b is not None), default=-np.inf)
    high = min((b for b in (rule.below, rule.most) if b is not None), default=np.inf)
    if low == 0 and not np.isfinite(high) and value > 0:
        return Scale(True, 1.0, float(np.log(value)) - WIDEST, float(np.log(value)) + WIDEST)
    size = abs(value) or 1.0
    return Scale(False, size, low / size, high / size)


class Space:
    """The coordinates of all free numbers.

    Parameters
    ----------
    start
        Value of each by name.
    scales
        Of each.
    """

    def __init__(self, start: dict[str, float], scales: Sequence[Scale]):
        self.names, self.scales = tuple(start), tuple(scales)
        self.low, self.high = (np.array([getattr(s, side) for s in scales]) for side in ("low", "high"))
        self.start = self.clipped(np.array([s.inside(v) for s, v in zip(scales, start.values(), strict=True)]))

    def clipped(self, points: np.ndarray) -> np.ndarray:
        """Points (..., free) within the bounds."""
        return np.clip(points, self.low + MARGIN, self.high - MARGIN)

    def values(self, point: np.ndarray) -> dict[str, float]:
        """The numbers of a point, by name."""
        return {name: s.outside(u) for name, s, u in zip(self.names, self.scales, point, strict=True)}

    def slopes(self, point: np.ndarray) -> np.ndarray:
        """d value/d coordinate of each, (free,)."""
        return np.array([s.slope(s.outside(u)) for s, u in zip(self.scales, point, strict=True)])

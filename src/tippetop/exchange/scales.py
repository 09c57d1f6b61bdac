"""Coordinates in which free numbers are searched, and their bounds.

Free numbers in SI units go in, coordinates of order one come out, and back again.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..mechanics.contact.surroundings import STEEPEST
from ..mechanics.number import Number


# How far the logarithm of a number may go from where it starts
WIDEST = float(np.log(20))
# Distance of a start from its bounds
MARGIN = 1e-6
# Plausible distance of a number from where it starts, relative
FAR = 0.4
# Of the differences that are derivatives: values are known to 1e-16, and smooth over 1
STEP = 1e-5
# Pairs of numbers that are searched as vectors: a size and an azimuth, with the largest size; and
# after those of the axis, components along its azimuth and across it, for which `Space.values` has
# read the axis before: this order must stay
PAIRS = (
    ("plane.tilt", "plane.azimuth", STEEPEST),
    ("initial.theta", "initial.phi", math.pi),
    ("initial.theta_dot", "initial.phi_dot", None),
    ("initial.nu_x", "initial.nu_y", None),
)


class Scale(NamedTuple):
    """The coordinate of a free number, and its bounds `low` and `high`.

    It is the logarithm of a number whose interval is (0, oo), of others the number over `size` (SI;
    1 of a logarithm, unused). The bounds are coordinates.
    """

    logarithmic: bool
    size: float
    low: float
    high: float

    def inside(self, value: float) -> float:
        """Return the coordinate of a value in SI units."""
        return float(np.log(value)) if self.logarithmic else value / self.size

    def outside(self, inside: Any) -> Any:
        """Return the values, SI, of coordinates: the inverse of `inside`; none overflows."""
        return np.exp(np.clip(inside, -600, 600)) if self.logarithmic else inside * self.size

    def slope(self, value: float) -> float:
        """Return d value/d coordinate at a value, SI."""
        return value if self.logarithmic else self.size


def scale_of(rule: Number, value: float, unit: float = 1.0) -> Scale:
    """Return the coordinate of a number that starts at a value, SI; `unit` is its internal unit.

    Its `size` is |value|, or `unit` for a number that starts at 0. Its bounds are those of the
    number's interval; of a logarithm, a factor of 20 to both sides.
    """
    low = max((b for b in (rule.above, rule.least) if b is not None), default=-np.inf)
    high = min((b for b in (rule.below, rule.most) if b is not None), default=np.inf)
    if rule.nonzero:  # the sign stays that of the start
        low, high = (max(low, 0.0), high) if value > 0 else (low, min(high, 0.0))
    if low == 0 and not np.isfinite(high) and value > 0:
        return Scale(True, 1.0, float(np.log(value)) - WIDEST, float(np.log(value)) + WIDEST)
    size = abs(value) or unit
    return Scale(False, size, low / size, high / size)


class Space:
    """Coordinates of all free numbers: 0 at the start, 1 at a plausible distance from it.

    `Observation.space` makes it.

    Where theta and phi are free, they and the pairs along this azimuth are searched as Cartesian
    components of a vector: near a pole a straight line in these is a detour in the angles. So are a
    tilt and its azimuth, which have no other period then, and may start at 0.

    Parameters
    ----------
    start
        Value of each number by name.
    scales
        Of each number.
    within
        Plausible distance of a number from where it starts, relative.

    Attributes
    ----------
    pairs : list
        Places of the two numbers of a vector, whether the second one multiplies theta, and the
        azimuth at the start of a pair that has one; the pairs along that of the axis are last.
    far : ndarray
        Plausible distances by the start alone, (free,), of logarithms, of numbers in units of
        their `size`, and of components; 0 for a number that starts at 0.
    loose : ndarray
        Whether a distance may also be larger, (free,).
    width : ndarray
        The distances that are 1, (free,); `search.widen` changes them before a search begins.
    """

    def __init__(self, start: dict[str, float], scales: Sequence[Scale], within: float = FAR):
        """Choose the coordinates of single numbers, then of pairs that are searched as vectors."""
        self.names = tuple(start)
        self.scales = tuple(scales)
        pairs = zip(scales, start.values(), strict=True)
        self.origin = np.array([s.inside(v) for s, v in pairs])
        logarithmic, _, self.low, self.high = np.array(scales, float).T
        self.within = within
        self.far = np.where(logarithmic, within, within * np.abs(self.origin))
        self.loose = self.far == 0
        self.pairs: list[tuple[int, int, bool, float | None]] = []
        theta = start.get("initial.theta", 0.0) if "initial.phi" in start else 0.0
        for first, second, most in PAIRS:
            if not {first, second} <= start.keys() or not (theta > 0 or first == "plane.tilt"):
                continue
            places = i, k = [self.names.index(name) for name in (first, second)]
            swept = first == "initial.theta_dot"
            size, other = start[first], start[second]
            vector = (size, other * (theta if swept else 1)) if most is None else (size, 0.0)
            self.origin[places] = vector
            self.far[places] = within * np.hypot(*vector)
            self.high[places] = np.inf if most is None else most / math.sqrt(2)
            self.low[places] = -self.high[places]
            self.loose[places] = True
            self.pairs.append((i, k, swept, None if most is None else other))
        self.width = np.where(self.far > 0, self.far, 1.0)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest coordinates."""
        return (self.low - self.origin) / self.width, (self.high - self.origin) / self.width

    def clipped(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., free) moved inside the bounds, by `MARGIN` more than necessary."""
        low, high = self.bounds
        return np.clip(points, low + MARGIN, high - MARGIN)

    def values(self, points: np.ndarray) -> dict[str, Any]:
        """Return the numbers of points (..., free), SI, (...) by name; floats of a single point.

        The names are in the order of `names`, on which callers that pair them with `scales` rely.
        """
        u = np.moveaxis(self.origin + self.width * points, -1, 0)
        values = [s.outside(x) for s, x in zip(self.scales, u, strict=True)]
        for i, k, swept, azimuth in self.pairs:
            vector = u[i] + 1j * u[k]
            if azimuth is not None:
                r = np.abs(vector)
                turn = np.angle(vector)
                values[i], values[k] = r, azimuth + turn
            else:
                vector = vector * np.exp(-1j * turn)
                values[i], values[k] = vector.real, vector.imag / (r if swept else 1)
        return dict(zip(self.names, values, strict=True))

    def slopes(self, point: np.ndarray) -> np.ndarray:
        """Return d value/d coordinate at a point (free,), as central differences, SI.

        The result is (values, coordinates), both in the order of the free numbers.
        """
        steps = STEP * np.eye(len(point))
        ahead, behind = (np.array([*self.values(point + s).values()]) for s in (steps, -steps))
        return (ahead - behind) / (2 * STEP)

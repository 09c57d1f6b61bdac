"""Weighted residuals of sets of numbers, and their Jacobians.

Points of the space of free numbers go in; residuals, divided by their noise, and their slopes come
out, for `search` and `fitting`.

Symbols
    points    coordinates (points, free), see `scales.Space`; rows: how many of the measurements
    residuals (points, numbers), measured minus predicted, weighted: group by group in the order of
              `Observation.groups`, without gaps
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..arguments import choice
from ..columns import Arrays
from .headers import UNITS
from .lockstep import Lockstep
from .observation import Observation
from .scales import FAR, Space


# Residual of a motion that cannot be computed: radians, or multiples of the size of others
WORST = 10.0
# Error of data and predictions by rounding, of their root mean square: attitudes after 1500 rad of
# spin have 1e-12, and after 9000 rad 2e-11
ROUNDING = 1e-11
# Steps of differences, in plausible distances of 40 %: the first whose halves agree within a tenth
# is taken, as a change of contact may happen in one half of a long one only
STEPS = (1e-6, 1e-7, 1e-8)
AGREE = 0.1
# Effect of a plausible distance, of the measurements, that is rounding
IDLE = 1e-7
# Change of a residual by a step, in those of WORST, beyond which it jumped: an angle, by a turn
JUMP = 0.1
# Medians of the noise beyond which a residual is an outlier
OUTLIER = 5.0
WEIGHTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "linear": np.ones_like,
    "soft_l1": lambda z: 1 / np.sqrt(1 + z),
    "huber": lambda z: 1 / np.sqrt(np.maximum(z, 1)),
    "cauchy": lambda z: 1 / (1 + z),
}
"""Derivatives of the losses of SciPy's `least_squares`; z: squares of residuals in units of their
scale.
"""


class Misfit:
    """Residuals of an observation at points of the space of its free numbers.

    `fitting.fit` makes it.

    Parameters
    ----------
    observation
        Measurements and predictions.
    space
        The free numbers.
    loss
        A name of `WEIGHTS`.
    """

    def __init__(self, observation: Observation, space: Space, loss: str):
        """Give each group the weight 1, and a floor of rounding error by its root mean square."""
        choice("loss", loss, WEIGHTS)
        self.observation = observation
        self.space = space
        self.loss = loss
        self.weights = dict.fromkeys(observation.groups, 1.0)
        self.sizes = {
            group: float(np.sqrt(np.nanmean(seen**2))) or 1.0
            for group, seen in observation.groups.items()
        }
        self.rounding = {group: ROUNDING * size for group, size in self.sizes.items()}
        self.worst = {g: WORST * (size if g in UNITS else 1.0) for g, size in self.sizes.items()}
        self.rows = len(observation.t)
        # Residuals, SI, of another scenario that explains the measurements
        self.rival: Arrays = {}
        # points and rows as a key, then the residuals there, NaN where there is no motion: reset
        # where predictions or weights change
        self.last: Any = (None,)
        # residuals of searches that run together, each with its own copy of the misfit
        self.lockstep = Lockstep(
            lambda points, rows: self.read(self.observation, self.space.values(points), rows)
        )

    def residuals(self, points: np.ndarray, rows: int) -> np.ndarray:
        """Return residuals (points, numbers) of the first rows.

        `points` are (points, free), in the coordinates of the space. Gaps are left out; a motion
        that cannot be computed leaves `WORST`, constant.
        """
        key = points.tobytes(), rows
        if self.last[0] != key:  # a minimiser wants values first, then slopes
            self.last = key, self.lockstep(points, rows)
        _, middle = self.last
        return np.where(np.isfinite(middle), middle, self._worst(rows))

    def at(self, points: np.ndarray, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Return residuals (points, numbers) of the first rows, and their Jacobians.

        Slopes are central differences; 0 for a residual that jumps between the two sides, or is
        NaN on one.
        """
        residuals = self.residuals(points, rows)
        _, middle = self.last
        worst = self._worst(rows)
        free = points.shape[1]
        jacobians = np.zeros((*middle.shape, free))
        bends = np.full(points.shape, np.inf)
        low, high = self.space.bounds
        # a coordinate of 1 is the distance `within`, while STEPS are parts of FAR
        for step in np.multiply(STEPS, FAR / self.space.within):
            p, i = np.nonzero(bends > AGREE)
            if not len(p):
                break
            move = step * np.eye(free)[i]
            sides = np.concatenate([points[p] + move, points[p] - move])
            sides = np.clip(sides, low + step / 2, high - step / 2)  # inside the bounds
            after, before = np.split(self.lockstep(sides, rows), 2)
            change = after - before
            second = after + before - 2 * middle[p]
            smooth = np.isfinite(second) & (np.abs(change) < JUMP * worst)
            size, bend = (np.linalg.norm(np.where(smooth, d, 0), axis=1) for d in (change, second))
            bend /= np.maximum(size, 1e-300)
            distance = np.subtract(*np.split(sides, 2)).sum(axis=1)  # in one coordinate
            slope = np.where(smooth, change, 0) / distance[:, None]
            better = bend < bends[p, i]
            p, i = p[better], i[better]
            jacobians[p, :, i] = slope[better]
            bends[p, i] = bend[better]
        return residuals, jacobians

    def read(self, observation: Observation, points: Mapping[str, Any], rows: int) -> np.ndarray:
        """Return residuals of the first rows, (points, numbers), NaN where there is no motion.

        `points` are values of the free numbers, SI, by name. Gaps are left out. `observation` has
        the same measurements, perhaps with another scenario (`Observation.under`).
        """
        parts = observation.predictions(points, slice(0, rows))
        given = self.observation.given
        found = [off[:, given[g][:rows]] * self.weights[g] for g, off in parts.items()]
        return np.concatenate(found, axis=1)

    def _worst(self, rows: int) -> np.ndarray:
        """Return the substitutes (numbers,) for residuals of a motion that cannot be computed."""
        given = self.observation.given.items()
        return np.concatenate(
            [np.full(every[:rows].sum(), self.worst[g] * self.weights[g]) for g, every in given]
        )

    def refine(self) -> None:
        """Let predictions have the tolerance of the scenario, rather than a coarser one."""
        self.last = (None,)
        self.observation.refine()

    def left(self, point: np.ndarray) -> tuple[Arrays, dict[str, float]]:
        """Return the residuals at a point and their root mean squares, by group, SI, unweighted.

        The residuals are (rows, parts), NaN in gaps.
        """
        found = self.observation.predictions(self.space.values(point))
        parts = {group: off[0] for group, off in found.items()}
        return parts, {group: float(np.sqrt(np.nanmean(off**2))) for group, off in parts.items()}

    def weigh(self, point: np.ndarray) -> None:
        """Set the weight of each kind of measurement to 1/noise, by its residuals at a point."""
        self.last = (None,)
        for group, noise in self.left(point)[1].items():
            self.weights[group] = 1 / max(noise, self.rounding[group])

    def variance(self, residuals: np.ndarray) -> float:
        """Return the variance of the noise from residuals (numbers,) at a minimum.

        To their sum of squares, divided by the degrees of freedom, rounding is added, whose errors
        may all agree.
        """
        weight = self.weight(residuals)
        free = len(self.space.names)
        most = max(self.weights[group] * size for group, size in self.rounding.items())
        squares = float((weight * residuals**2).sum())
        return squares / max(float(weight.sum()) - free, 1.0) + len(residuals) * most**2

    def excess(self, cost: float, rows: int | None = None) -> float:
        """Return by how many variances of the rival's noise a cost is larger than the rival's.

        Both are costs of the first rows, or of all. NaN without a rival, and comparisons of the
        callers are then false.
        """
        if not self.rival:
            return np.nan
        squares = np.hstack([(self.weights[g] * off) ** 2 for g, off in self.rival.items()])
        variance = np.nansum(squares) / self.observation.count
        return float((cost - np.nansum(squares[:rows])) / variance)

    def size(self, residuals: np.ndarray) -> float:
        """Return the residual beyond which a robust loss grows more slowly: the median size."""
        return max(float(np.median(np.abs(residuals))), 1e-12)

    def costs(self, points: np.ndarray, rows: int, like: np.ndarray) -> np.ndarray:
        """Return sums of squares (points,) of the residuals of the first rows.

        Outliers are cut off for a robust loss; `like`, residuals of the noise, have their scale.
        """
        most = np.inf if self.loss == "linear" else OUTLIER * self.size(like)
        return (np.minimum(np.abs(self.residuals(points, rows)), most) ** 2).sum(axis=1)

    def weight(self, residuals: np.ndarray) -> np.ndarray:
        """Return the weight, 0 to 1, that the loss gives to each of the residuals (numbers,)."""
        return WEIGHTS[self.loss]((residuals / self.size(residuals)) ** 2)

"""Weighted residuals of sets of numbers, and their Jacobians."""

from collections.abc import Callable

import numpy as np

from ..arguments import choice
from .observation import Observation
from .scales import Space


# Residual of a motion that cannot be computed
WORST = 10.0
# Error of data and predictions by rounding, of their root mean square: attitudes after 1500 rad of
# spin have 1e-12, and after 9000 rad 2e-11
ROUNDING = 1e-11
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
        choice("loss", loss, WEIGHTS)
        self.observation = observation
        self.space = space
        self.loss = loss
        self.weights = dict.fromkeys(observation.groups, 1.0)
        self.rounding = {
            group: ROUNDING * float(np.sqrt(np.nanmean(seen**2))) or ROUNDING
            for group, seen in observation.groups.items()
        }
        self.rows = len(observation.t)

    def at(
        self, points: np.ndarray, rows: int, *, slopes: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return residuals (points, numbers) of the first rows, and their Jacobians.

        Without `slopes` the Jacobians have no columns. Gaps are left out; a motion that cannot be
        computed leaves `WORST`, constant.
        """
        parts = self.observation.predictions(
            [self.space.values(p) for p in points], slice(0, rows), slopes=slopes
        )
        chain = np.array([self.space.slopes(p) for p in points]) if slopes else np.eye(0)
        residuals = []
        jacobians = []
        for group, (off, moves) in parts.items():
            weight = self.weights[group]
            given = np.isfinite(self.observation.groups[group][:rows])
            if given.shape != off.shape[1:]:  # of an attitude, whose residuals have fewer parts
                given = np.broadcast_to(given.all(axis=1, keepdims=True), off.shape[1:])
            r = off[:, given] * weight
            j = -moves[:, given] * weight @ chain
            known = np.isfinite(r) & np.isfinite(j).all(axis=2)
            residuals.append(np.where(known, r, WORST * weight))
            jacobians.append(np.where(known[:, :, None], j, 0.0))
        return np.concatenate(residuals, axis=1), np.concatenate(jacobians, axis=1)

    def weigh(self, point: np.ndarray) -> None:
        """Weight each kind of measurement by its own noise."""
        for group, (off, _) in self.observation.predictions(
            [self.space.values(point)], slopes=False
        ).items():
            self.weights[group] = 1 / max(float(np.sqrt(np.nanmean(off**2))), self.rounding[group])

    def variance(self, residuals: np.ndarray) -> float:
        """Return the variance of residuals; rounding, whose errors may all agree, adds to it."""
        weight = self.weight(residuals)
        free = len(self.space.names)
        most = max(self.weights[group] * size for group, size in self.rounding.items())
        squares = float((weight * residuals**2).sum())
        return squares / max(float(weight.sum()) - free, 1.0) + len(residuals) * most**2

    def size(self, residuals: np.ndarray) -> float:
        """Return the scale of residuals beyond which a loss bends."""
        return max(float(np.median(np.abs(residuals))), 1e-12)

    def costs(self, residuals: np.ndarray, like: np.ndarray) -> np.ndarray:
        """Return sums of squares (points,) of residuals, with outliers cut off for a robust loss.

        `like`: residuals of the noise, which have the scale of outliers.
        """
        most = np.inf if self.loss == "linear" else OUTLIER * self.size(like)
        return (np.minimum(np.abs(residuals), most) ** 2).sum(axis=1)

    def weight(self, residuals: np.ndarray) -> np.ndarray:
        """Return the weight of each residual."""
        return WEIGHTS[self.loss]((residuals / self.size(residuals)) ** 2)

"""What sets of numbers leave of the measurements: weighted residuals, and what a loss makes of them."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .observation import Observation
from .scales import Space


WORST = 10.0  # the residual of what cannot be computed


class Loss(NamedTuple):
    """A loss of z, the square of a residual in units of its scale, and its derivative by z."""

    of: Callable[[np.ndarray], np.ndarray]
    weight: Callable[[np.ndarray], np.ndarray]


LOSSES = {
    "linear": Loss(lambda z: z, np.ones_like),
    "soft_l1": Loss(lambda z: 2 * (np.sqrt(1 + z) - 1), lambda z: 1 / np.sqrt(1 + z)),
    "huber": Loss(
        lambda z: np.where(z <= 1, z, 2 * np.sqrt(np.maximum(z, 1)) - 1),
        lambda z: np.where(z <= 1, 1.0, 1 / np.sqrt(np.maximum(z, 1))),
    ),
    "cauchy": Loss(np.log1p, lambda z: 1 / (1 + z)),
}
"""As SciPy's `least_squares` defines them; the latter ones hardly see outliers."""


class Misfit:
    """Residuals of an observation at points of the space of its free numbers.

    Parameters
    ----------
    observation
        Measurements, and what is predicted for them.
    space
        The free numbers.
    loss
        A name of `LOSSES`.
    """

    def __init__(self, observation: Observation, space: Space, loss: str):
        if loss not in LOSSES:
            raise InputError([f"the loss must be one of {', '.join(LOSSES)}, but is {loss!r:.40}."])
        self.observation, self.space, self.loss = observation, space, LOSSES[loss]
        self.weights = dict.fromkeys(observation.groups, 1.0)
        self.evaluations = 0

    def at(self, points: np.ndarray, rows: int, *, slopes: bool = True) -> tuple[np.ndarray, Any]:
        """Residuals of the first rows, (points, numbers), and their Jacobians, (points, numbers, free), or None.

        What was not measured is left out; what cannot be computed is `WORST`, and stays."""
        self.evaluations += len(points)
        parts = self.observation.predictions([self.space.values(p) for p in points], slice(0, rows), slopes=slopes)
        residuals, jacobians = [], []
        chain = np.array([self.space.slopes(p) for p in points])[:, None, :] if slopes else None
        for group, (off, moves) in parts.items():
            weight = self.weights[group]
            given = np.isfinite(self.observation.groups[group][:rows]).all(axis=1)
            r = (off[:, given] * weight).reshape(len(points), -1)
            broken = ~np.isfinite(r)
            if slopes:
                j = (-moves[:, given] * weight).reshape(*r.shape, -1) * chain
                broken |= ~np.isfinite(j).all(axis=2)
                jacobians.append(np.where(broken[:, :, None], 0.0, j))
            residuals.append(np.where(broken, WORST * weight, r))
        return np.concatenate(residuals, axis=1), np.concatenate(jacobians, axis=1) if slopes else None

    def rows(self, rows: int) -> np.ndarray:
        """The row of each residual of the first rows."""
        rows_of = []
        for group, seen in self.observation.groups.items():
            given = np.flatnonzero(np.isfinite(seen[:rows]).all(axis=1))
            rows_of.append(np.repeat(given, self.observation.parts(group)))
        return np.concatenate(rows_of)

    def weigh(self, point: np.ndarray) -> None:
        """Weighs each kind of measurement by its own noise."""
        if len(self.weights) > 1:
            for group, (off, _) in self.observation.predictions([self.space.values(point)], slopes=False).items():
                self.weights[group] = 1 / max(float(np.sqrt(np.nanmean(off**2))), 1e-12)

    def size(self, residuals: np.ndarray) -> float:
        """The scale of residuals beyond which a loss bends."""
        return max(float(np.median(np.abs(residuals))), 1e-12)

    def costs(self, residuals: np.ndarray, size: float) -> np.ndarray:
        """What a loss makes of residuals (points, numbers), (points,)."""
        return size**2 * self.loss.of((residuals / size) ** 2).sum(axis=1)

    def weight(self, residuals: np.ndarray, size: float) -> np.ndarray:
        """The weight of each residual."""
        return self.loss.weight((residuals / size) ** 2)

"""The likelihood of measurements under a scenario, and draws of its posterior.

An `Observation` goes in; a function of its free numbers comes out, and draws with weights.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from .headers import UNITS
from .observation import CLOCK, OFFSET, Observation


# Motions that are read at a time
BLOCK = 256
# Degrees of freedom of the distribution from which points are drawn: wider tails than a Gaussian's
FREEDOM = 8
# Step of differences, relative
STEP = 1e-6


class LogLikelihood:
    """The logarithm of the likelihood of measurements, as a function of the free numbers.

    `tippetop.log_likelihood` makes it. Noise is Gaussian and independent. Its standard deviation is
    the stated one where that is given, of angles and directions. Otherwise it is unknown, with a
    density that is uniform in its logarithm, and integrated over.

    Attributes
    ----------
    free : tuple of str
        Dotted names of the numbers, in the order of a point.
    start : ndarray
        Their values in the scenario, (free,).
    """

    def __init__(self, observation: Observation):
        """Prepare the predictions, and keep the start and the unit of each free number."""
        self._observation = observation
        observation.predicted.refine()
        self.free = observation.free
        begin = observation.start()
        self.start = np.array(list(begin.values()))
        rules = [observation.rule(name) for name in self.free]
        self._units = np.array([observation.problem.unit(rule.unit) for rule in rules])

    def __call__(
        self, points: Sequence[float] | np.ndarray, *, gradient: bool = False
    ) -> "float | np.ndarray | tuple[float | np.ndarray, np.ndarray]":
        """Return the logarithm of the likelihood at one point or at many, which run in lanes.

        Parameters
        ----------
        points : array
            Values of the free numbers in SI units, (free,) or (points, free).
        gradient : bool
            Whether the derivatives are returned too, by central differences.

        Returns
        -------
        float or ndarray (points,), or a pair of it and the gradient
            Minus infinity where a number is outside its interval, or there is no motion.
        """
        given = np.asarray(points, float)
        many = np.atleast_2d(given)
        if not gradient:
            values = self._values(many)
            return values if given.ndim > 1 else float(values[0])
        n, free = many.shape
        steps = STEP * np.where(many == 0, self._units, np.abs(many))
        moves = steps[:, :, None] * np.eye(free)
        sides = np.concatenate([many[:, None] + moves, many[:, None] - moves])
        every = self._values(np.concatenate([many, sides.reshape(-1, free)]))
        ahead, behind = every[n:].reshape(2, n, free)
        values = every[:n]
        with np.errstate(invalid="ignore"):
            slopes = (ahead - behind) / (2 * steps)
        return (values, slopes) if given.ndim > 1 else (float(values[0]), slopes[0])

    def _values(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood at each of the points (points, free), (points,).

        It is -inf outside the interval of a number, and where a measured time is before the start.
        """
        observation = self._observation
        found = np.full(len(points), -np.inf)
        inside = np.isfinite(points).all(axis=1)
        for name, column in zip(self.free, points.T, strict=True):
            inside &= ~observation.rule(name).broken(column)
        if OFFSET in self.free:
            first = points[:, self.free.index(OFFSET)]
            scale = points[:, self.free.index(CLOCK)] if CLOCK in self.free else 1.0
            inside &= scale * observation.t[0] + first >= 0
        which = np.flatnonzero(inside)
        for some in np.split(which, range(BLOCK, len(which), BLOCK)):
            if len(some):
                rows = [dict(zip(self.free, p, strict=True)) for p in points[some].tolist()]
                found[some] = self._sums(observation.predictions(rows))
        return found

    def _sums(self, parts: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the logarithms for residuals by group, (points, rows, parts)."""
        total: np.ndarray = np.zeros(1)
        for group, off in parts.items():
            given = self._observation.given[group]
            squares = (off[:, given] ** 2).sum(axis=1)
            n = int(given.sum())
            noise = self._observation.noise if group not in UNITS else None
            if noise is None:
                total = total - n / 2 * np.log(np.maximum(squares, 1e-300))
            else:
                total = total - squares / (2 * noise**2) - n * np.log(noise * np.sqrt(2 * np.pi))
        return np.where(np.isnan(total), -np.inf, total)


def drawn(
    function: LogLikelihood, centre: np.ndarray, covariance: np.ndarray, draws: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (draws, free) of a t distribution, and their weights as draws of a posterior.

    Parameters
    ----------
    function
        The likelihood; the prior is uniform in the free numbers.
    centre, covariance
        Of the distribution from which points are drawn: the fit's.
    draws
        How many.
    seed
        Of the random numbers.
    """
    random = np.random.default_rng(seed)
    free = len(centre)
    normal = random.standard_normal((draws, free))
    wide = normal / np.sqrt(random.chisquare(FREEDOM, draws) / FREEDOM)[:, None]
    points = centre + wide @ np.linalg.cholesky(covariance).T
    density = -(FREEDOM + free) / 2 * np.log1p((wide**2).sum(axis=1) / FREEDOM)
    logarithms = np.asarray(function(points)) - density
    weights = np.exp(logarithms - logarithms.max())
    return points, weights / weights.sum()

"""The likelihood of measurements under a scenario, and draws of its posterior.

An `Observation` goes in; a function of its free numbers comes out, and draws with weights.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import InputError
from .fit_result import Fit
from .observation import Observation


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
        observation.refine()
        self.free = observation.free
        self.start = np.array([*observation.start().values()])
        self._units = np.array(observation.units)

    def __call__(
        self, points: Sequence[float] | np.ndarray, *, gradient: bool = False
    ) -> "float | np.ndarray | tuple[float | np.ndarray, np.ndarray]":
        """Return the logarithm of the likelihood at one point or at many, which run in lanes.

        Parameters
        ----------
        points : array
            Values of the free numbers in SI units, (free,) or (..., free).
        gradient : bool
            Whether the derivatives are returned too, by central differences.

        Returns
        -------
        float or ndarray (...,), or a pair of it and the gradient
            Minus infinity where a number is outside its interval, or there is no motion.
        """
        given = np.asarray(points, float)
        free = len(self.free)
        values = self._values(given.reshape(-1, free)).reshape(given.shape[:-1])[()]
        if not gradient:
            return values
        steps = STEP * np.where(given == 0, self._units, np.abs(given))
        moves = steps[..., None] * np.eye(free)
        sides = given[..., None, :] + np.concatenate([moves, -moves], axis=-2)
        ahead, behind = np.split(np.asarray(self(sides)), 2, axis=-1)
        with np.errstate(invalid="ignore"):
            return values, (ahead - behind) / (2 * steps)

    def _values(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood at each of the points (points, free), (points,).

        It is -inf outside the interval of a number, and where a measured time is before the start.
        """
        observation = self._observation
        found = np.full(len(points), -np.inf)
        named = zip(self.free, points.T, strict=True)
        broken = [observation.rule(name).broken(column) for name, column in named]
        which = np.flatnonzero(~np.any(broken, axis=0))
        for first in range(0, len(which), BLOCK):
            some = which[first : first + BLOCK]
            given = dict(zip(self.free, points[some].T, strict=True))
            found[some] = self._sums(observation.predictions(given))
        return found

    def _sums(self, parts: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the logarithms (points,) for residuals by group, (points, rows, parts).

        Where noise is integrated over, a constant is left out. A motion that cannot be computed has
        NaN, and the logarithm -inf.
        """
        total: np.ndarray = np.zeros(1)
        for group, off in parts.items():
            given = self._observation.given[group]
            squares = (off[:, given] ** 2).sum(axis=1)
            n = int(given.sum())
            noise = self._observation.stated.get(group)
            if noise is None:
                total = total - n / 2 * np.log(np.maximum(squares, 1e-300))
            else:
                total = total - squares / (2 * noise**2) - n * np.log(noise * np.sqrt(2 * np.pi))
        return np.where(np.isnan(total), -np.inf, total)


def drawn(
    function: LogLikelihood, fit: Fit, draws: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (draws, free) of a t distribution, and their weights as draws of a posterior.

    Parameters
    ----------
    function
        The likelihood; the prior is uniform in the free numbers.
    fit
        About which points are drawn, with its covariances; of the numbers of `function`, in their
        order, as `library.posterior` checks.
    draws
        How many.
    seed
        Of the random numbers.

    Raises
    ------
    InputError
        If the fit leaves a number undecided.
    """
    from scipy.stats import multivariate_t

    try:
        shape = multivariate_t(None, fit.correlations, FREEDOM, seed=np.random.default_rng(seed))
    except ValueError:  # not finite, or singular
        raise InputError(
            "the fit must decide every number for draws about it, but does not: free fewer."
        ) from None
    wide = shape.rvs(draws).reshape(draws, -1)
    centre, sigma, *_ = np.transpose([*fit.estimates.values()])
    points = centre + sigma * wide
    logarithms = np.asarray(function(points)) - shape.logpdf(wide)
    weights = np.exp(logarithms - logarithms.max())
    return points, weights / weights.sum()

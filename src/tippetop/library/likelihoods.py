"""The calls on the likelihood of a film, and the posterior of the numbers of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import dotted_keys, instance, names_of, positive_integer, takes
from ..errors import InputError, refuse_without, warn
from ..exchange.likelihood import LogLikelihood, drawn
from ..exchange.observation import observed
from .exchanging import Fitted, _reference, fit
from .plots import saved


if TYPE_CHECKING:
    from matplotlib.figure import Figure


@takes(observed)
def log_likelihood(
    data: str | Path, scenario: Any, free: str | Sequence[str], **film: Any
) -> LogLikelihood:
    """Return the logarithm of the likelihood of a film as a function of some numbers.

    Parameters
    ----------
    data, scenario, free, marker, quaternion, up, track, chip
        As for `fit`.
    noise : float or str, optional
        Standard deviation of measured angles and directions: radians, or a text such as "1.5 deg".
        Noise whose size is not stated is integrated over.

    Returns
    -------
    LogLikelihood
        Call it with values of the free numbers, (free,) or (points, free), and `gradient=True` for
        the derivatives too.

    Raises
    ------
    InputError
        If the table, a name or the scenario is wrong.

    Examples
    --------
    >>> import tippetop as tt
    >>> f = tt.log_likelihood("film.csv", "inverting", ["friction.mu", "initial.omega3"])
    >>> f([0.3, 155.0])
    >>> f([[0.3, 155.0], [0.31, 155.0]])
    """
    problem = _reference("scenario", scenario)
    return LogLikelihood(observed(data, problem, names_of("free", free), **film))


class Posterior:
    """Weighted draws of the numbers of a scenario, given a film. `tippetop.posterior` makes it.

    Attributes
    ----------
    free : tuple of str
        Dotted names of the numbers.
    points : ndarray
        (draws, free), SI.
    weights : ndarray
        (draws,), of sum 1.
    effective : float
        The number of independent draws that are worth as much.
    mean, sigma : dict
        Mean and standard deviation of each number.
    fit : Fitted
        The fit about which the draws are.
    """

    def __init__(self, fitted: Fitted, points: np.ndarray, weights: np.ndarray):
        """Compute mean, standard deviation and effective number of weighted draws.

        The columns of `points` are in the order of the estimates, as `likelihood.drawn` makes them.
        """
        self.fit = fitted
        self.free = tuple(fitted.estimates)
        self.points = points
        self.weights = weights
        self.effective = float(1 / (weights**2).sum())
        mean = weights @ points
        sigma = np.sqrt(weights @ (points - mean) ** 2)
        self.mean = dict(zip(self.free, mean.tolist(), strict=True))
        self.sigma = dict(zip(self.free, sigma.tolist(), strict=True))

    def plot(self, path: str | Path | None = None, *, overwrite: bool = False) -> Figure:
        """Draw the distributions of numbers and pairs, and save that where a path is given.

        The axes are labelled with the names and their units; a line below counts the draws.
        """
        refuse_without("matplotlib")
        from ..figures.corner import corner

        columns = {}
        for name, values in zip(self.free, self.points.T, strict=True):
            unit = self.fit.observation.rule(name).unit.symbol
            columns[name if unit == "1" else f"{name} ({unit})"] = values
        moments = zip(self.mean.values(), self.sigma.values(), strict=True)
        return saved(
            corner(columns, self.weights, moments, self._count_in_words()), path, overwrite
        )

    def _count_in_words(self) -> str:
        """Return the number of draws and of effective ones, in words; with advice below 100."""
        few = " (too few: take more draws, or a sampler of Markov chains)"
        count = len(self.weights)
        return f"{count} draws, {self.effective:.0f} effective{few * (self.effective < 100)}"

    def __str__(self) -> str:
        width = max(map(len, self.free))
        rows = [f"{n:{width}}  {self.mean[n]:.7g} +- {self.sigma[n]:.2g}" for n in self.free]
        return "\n".join([*rows, self._count_in_words()])

    def __repr__(self) -> str:
        return f"<Posterior of {', '.join(self.free)}: {self._count_in_words()}>"


def posterior(
    data: str | Path,
    scenario: Any,
    free: str | Sequence[str],
    *,
    draws: int = 2000,
    seed: int = 0,
    fitted: Fitted | None = None,
    **options: Any,
) -> Posterior:
    """Draw numbers of a scenario from their posterior, given a film, by importance sampling.

    Points are drawn about the fit from a t distribution with 8 degrees of freedom, and weighted by
    their likelihood; the prior is uniform in the free numbers, within their intervals.

    Parameters
    ----------
    data, scenario, free
        As for `fit`.
    draws : int
        Motions that are computed.
    seed : int
        Of the random numbers.
    fitted : Fitted, optional
        A fit of the same numbers to these data, which otherwise is made first. With it `data` and
        `scenario` are not read: only the names `free` are compared with those of the fit.
    options
        `noise` and the others of `fit`, unless `fitted` is given.

    Returns
    -------
    Posterior

    Raises
    ------
    InputError
        If the table, a name or the scenario is wrong, or the fit leaves a number undecided.

    Warns
    -----
    TippetopWarning
        If the residuals of the fit are not noise.

    Examples
    --------
    >>> import tippetop as tt
    >>> print(tt.posterior("film.csv", "inverting", ["friction.mu", "initial.omega3"]))
    """
    if fitted is None:
        fitted = fit(data, scenario, free, **options)
    elif options:
        raise InputError(
            f"`fitted` must be alone, as it has its own options, but `{next(iter(options))}` is "
            "given too."
        )
    instance("fitted", fitted, Fitted, "the result of `fit`")
    names = dotted_keys(names_of("free", free), fitted.observation.problem.rules)
    function = LogLikelihood(fitted.observation)
    if function.free != tuple(names):
        raise InputError(
            f"`fitted` must be a fit of {', '.join(names)}, but is one of "
            f"{', '.join(fitted.estimates)}."
        )
    if not fitted.is_noise:
        warn(
            ["the residuals of the fit are not noise: a posterior of a wrong model is too narrow."],
            3,
        )
    return Posterior(fitted, *drawn(function, fitted, positive_integer("draws", draws), seed))

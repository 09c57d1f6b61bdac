"""A fit: the numbers of a scenario that fit a measured motion best, and what the measurements say of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from .misfit import Misfit
from .observation import CLOCK, OFFSET, Observation
from .periods import walked
from .scales import Scale, Space, scale_of
from .search import RIVAL, End, finished, followed, others


STARTS = 12  # that are followed at most, until one leaves nothing but noise
NOISY = 5.0  # standard deviations of the sum of squared autocorrelations that noise does not reach
LAGS = 12  # of that sum
ALIKE, ROUGH = 0.99, 0.05  # correlation, and one standard error, of numbers that cannot be distinguished
QUANTILE = 0.975
IDLE = 1e-12  # of what is seen: what changes no more by the whole of a number is rounding


class Estimate(NamedTuple):
    """A number that was fitted: its value, standard error and 95 % interval, SI."""

    value: float
    sigma: float
    low: float
    high: float


class Fit(NamedTuple):
    """The result of a fit.

    Parameters
    ----------
    estimates
        By dotted name.
    correlations
        (free, free).
    converged
        Whether the numbers are those that fit best, and the data decide them.
    reason
        A sentence for each thing that must be known; the first says how it ended.
    residuals
        Name of each kind of measurement -> (rows, parts), measured less predicted, SI; of an axis two parts, across it.
    noise
        Name -> its standard deviation.
    t
        (rows,).
    evaluations
        How many motions were computed.
    """

    estimates: dict[str, Estimate]
    correlations: np.ndarray
    converged: bool
    reason: list[str]
    residuals: dict[str, np.ndarray]
    noise: dict[str, float]
    t: np.ndarray
    evaluations: int


def fit(observation: Observation, loss: str = "linear", starts: int = STARTS, seed: int = 0) -> Fit:
    """Fits the free numbers of an observation.

    Parameters
    ----------
    observation
        Measurements and the scenario.
    loss
        linear, or soft_l1, huber, cauchy, which outliers hardly move.
    starts
        How many starts are followed at most, until one leaves nothing but noise: the scenario's own, then the best of
        many others.
    seed
        Of the other starts.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        If there are fewer measurements than numbers, or a number does nothing.
    """
    begin = observation.start()
    space = Space(begin, [scale_of(observation.rule(name), value) for name, value in begin.items()])
    misfit = Misfit(observation, space, loss)
    _refuse(misfit)
    end = followed(misfit, space.start, seed)
    for k in range(starts - 1):
        if end is not None and _excess(misfit, end.point) <= NOISY:
            break
        if k == 0:
            more = others(misfit, starts - 1, seed)
        end = _better(end, followed(misfit, more[k], seed))
    if end is None:
        end = followed(misfit, space.start, seed, to_the_end=True)
    assert end is not None
    if len(observation.groups) > 1:
        misfit.weigh(end.point)
        end = finished(misfit, end.point)
    if OFFSET in space.names:
        end = walked(misfit, end, space.names.index(OFFSET))
    return judged(misfit, end)


def _better(one: End | None, other: End | None) -> End | None:
    if one is None or other is None:
        return one or other
    return min(one, other, key=lambda end: end.cost)


def _refuse(misfit: Misfit) -> None:
    """Raises InputError where there is nothing to fit, and for a number that does nothing to what was measured."""
    observation, space = misfit.observation, misfit.space
    count = sum(int(np.isfinite(rows).sum()) for rows in observation.groups.values())
    if count <= len(space.names):
        raise InputError(
            [f"more measurements than free numbers must be there, but are {count} for {len(space.names)}."]
        )
    predictions = observation.predicted(space.values(space.start))
    if space.values(space.start).get(CLOCK, 1.0) * observation.t[0] + space.values(space.start).get(OFFSET, 0.0) < 0:
        first = f"but begin at {observation.t[0]:.6g} s: shift them, or let `{OFFSET}` be free"
        raise InputError([f"times must begin at 0, the start of the motion, or later, {first}."])
    if not any(np.isfinite(off).any() for off, _ in predictions.values()):
        raise InputError(["the scenario must move over the time of the table, but cannot."])
    moves = np.concatenate([moves.reshape(-1, len(space.names)) for _, moves in predictions.values()])
    sizes = np.sqrt(np.nansum((moves * space.slopes(space.start)) ** 2, axis=0))
    seen = np.sqrt(sum(np.nansum(rows**2) for rows in observation.groups.values()))
    idle = [name for name, size in zip(space.names, sizes, strict=True) if size <= IDLE * max(sizes.max(), seen)]
    if idle:
        raise InputError([f"`{name}` must change what was measured, but does nothing to it." for name in idle])


def _excess(misfit: Misfit, point: np.ndarray) -> float:
    """How far residuals are from noise: their squared autocorrelations, in standard deviations of that of noise."""
    worst = 0.0
    for off, _ in misfit.observation.predictions([misfit.space.values(point)], slopes=False).values():
        for part in off[0].T:
            r = part[np.isfinite(part)]
            n = len(r)
            if n > 2 * LAGS and (r**2).sum() > 0:
                rho = np.array([(r[k:] * r[:-k]).sum() for k in range(1, LAGS + 1)]) / (r**2).sum()
                total = n * (n + 2) * (rho**2 / (n - np.arange(1, LAGS + 1))).sum()  # Ljung and Box 1978
                worst = max(worst, float((total - LAGS) / np.sqrt(2 * LAGS)))
    return worst


def judged(misfit: Misfit, end: End) -> Fit:
    """The result at the end of a search."""
    from scipy.stats import t as student

    observation, space, point = misfit.observation, misfit.space, end.point
    (residual,), (jacobian,) = misfit.at(point[None, :], len(observation.t))
    weight = misfit.weight(residual, misfit.size(residual))
    freedom = max(float(weight.sum()) - len(point), 1.0)
    variance = float((weight * residual**2).sum() / freedom)
    sizes = np.sqrt((jacobian**2 * weight[:, None]).sum(axis=0))
    scaled = jacobian * np.sqrt(weight)[:, None] / np.where(sizes > 0, sizes, 1)
    _, singular, ways = np.linalg.svd(scaled, full_matrices=False)
    covariance = (ways.T / np.maximum(singular, 1e-12) ** 2) @ ways * variance / np.outer(sizes, sizes)
    sigma = np.sqrt(np.diag(covariance))
    correlations = covariance / np.outer(sigma, sigma)
    quantile = float(student.ppf(QUANTILE, freedom))
    estimates = {}
    for name, scale, u, s in zip(space.names, space.scales, point, sigma, strict=True):
        value = scale.outside(u)
        low, high = (scale.outside(_within(scale, u + sign * quantile * s)) for sign in (-1, 1))
        estimates[name] = Estimate(value, float(s * scale.slope(value)), low, high)
    values = space.values(point)
    parts = {group: off[0] for group, (off, _) in observation.predictions([values], slopes=False).items()}
    noise = {group: float(np.sqrt(np.nanmean(off**2))) for group, off in parts.items()}
    reasons = [*_undecided(space, point, sigma, correlations), *_rivals(space, end, jacobian)]
    excess = _excess(misfit, point)
    if excess > NOISY:
        reasons.append(
            f"the residuals are no noise (their autocorrelations are {excess:.0f} standard deviations too large): the "
            "model, or a start, is missing something."
        )
    converged = not reasons
    reasons.insert(0, "the numbers fit: what is left is noise." if converged else "the fit must be read with care:")
    return Fit(estimates, correlations, converged, reasons, parts, noise, observation.t,
               misfit.evaluations)  # fmt: skip


def _within(scale: Scale, u: float) -> float:
    """A coordinate, but no further than the interval of its number; that of a logarithm is all that is positive."""
    return u if scale.logarithmic else min(max(u, scale.low), scale.high)


def _undecided(space: Space, point: np.ndarray, sigma: np.ndarray, correlations: np.ndarray) -> list[str]:
    """Sentences on the numbers that the data do not decide."""
    reasons = []
    for name, scale, u, s in zip(space.names, space.scales, point, sigma, strict=True):
        for side, limit in (("lowest", scale.low), ("highest", scale.high)):
            if np.isfinite(limit) and abs(u - limit) <= 2e-6 * max(1.0, abs(limit)):
                reasons.append(f"`{name}` ran into its {side} value, {scale.outside(limit):.6g}.")
        if (scale.logarithmic and s > 1) or (not scale.logarithmic and s > max(1.0, abs(u))):
            reasons.append(f"the data cannot decide `{name}`: its standard error is as large as itself.")
    for i, name in enumerate(space.names):
        for j, other in enumerate(space.names[:i]):
            if abs(correlations[i, j]) > ALIKE and max(sigma[i], sigma[j]) > ROUGH:
                alike = f"`{other}` and `{name}` cannot be distinguished"
                reasons.append(f"{alike}: correlation {correlations[i, j]:.4f}.")
    return reasons


def _rivals(space: Space, end: End, jacobian: np.ndarray) -> list[str]:
    """A sentence where other numbers fit nearly as well."""
    near = []
    for point, cost in end.rivals:
        apart = jacobian @ (point - end.point)
        if cost - end.cost < RIVAL * end.variance and apart @ apart > end.variance:
            near.append(", ".join(f"{name} = {value:.6g}" for name, value in space.values(point).items()))
    more = f" (and {len(near) - 1} more such sets)" if len(near) > 1 else ""
    return [f"other numbers fit nearly as well: {near[0]}{more}; errors are those of one set."] if near else []


def names_of(text: str | Sequence[str]) -> tuple[str, ...]:
    """Names of free numbers, of a text with commas or a list. Raises InputError."""
    names = [part.strip() for part in text.split(",")] if isinstance(text, str) else list(text)
    if not names or not all(isinstance(name, str) and name for name in names):
        raise InputError(["the free numbers must be names such as friction.mu, parameters.I1, but none is given."])
    return tuple(names)

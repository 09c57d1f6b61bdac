"""A fit of the numbers of a scenario to a measured motion, and how far the data decide them.

An `Observation` goes in, a `Fit` comes out. `search` finds minima of the `misfit`; this module
judges whether they can be trusted, by independent searches, noise, correlations and influences.

Symbols
    misfit    residuals as a function of the free numbers, see `misfit.Misfit`
    end       a `Minimum` over all data; ends: several, best first. Its `searches` are those that
              ended there: 0 where the search was given up, or another minimum is merely near
    parts     residuals of one kind of measurement, by name, (rows, parts)
    sigma     standard errors of the free numbers; changes: of residuals, by influence
"""

import copy
from collections.abc import Sequence

import numpy as np

from ..columns import Arrays
from ..errors import InputError, refuse_without
from ..progress import Report
from . import influences
from .fit_result import Estimate, Fit
from .misfit import IDLE, Misfit
from .observation import CLOCK, OFFSET, Observation
from .periods import RIVAL, walk
from .scales import Space
from .search import WORSE, Minimum, local_minima, merge, search, starts_of, widen, windows


# Searches at most
STARTS = 12
# Searches that must have ended in the best minimum
MET = 3
# Searches that end equally far from data that another scenario explains, or are given up, after
# which the others are left out; without such a scenario `MET`
HOPELESS = 2
# Greatest cost of searches that end equally far from the data, in units of the least one
ALIKE = 1.25
# Standard deviations of the sum of squared autocorrelations, and of the variance, beyond noise
NOISY = 5.0
# Lags of that sum
LAGS = 12
# Correlation beyond which two numbers cannot be distinguished
CORRELATED = 0.99
# Standard error of one of them, in its coordinate, beyond which that is reported
ROUGH = 0.05
# Of a 95 % interval, which has two sides
QUANTILE = 0.975
# Standard errors beyond which a systematic error is named
LARGE = 3.0
# Standard errors from a bound, and at most this coordinate, within which a number is at it
AT_BOUND = 0.01


def fit(
    observation: Observation,
    loss: str,
    starts: int,
    within: float,
    systematic: bool,
    rival: Fit | None,
    progress: Report,
) -> Fit:
    """Fit the free numbers of an observation.

    Parameters
    ----------
    observation
        Measurements and the scenario.
    loss
        linear, or soft_l1, huber, cauchy, which outliers hardly move.
    starts
        Independent searches at most, until `MET` of them have ended in the best minimum.
    within
        Plausible distance of the numbers from those of the scenario, relative.
    systematic
        Whether influences that the scenario lacks are estimated.
    rival
        A fit of another scenario that explains the measurements. Searches end where one explains
        them as well, and sooner where they do not.
    progress
        Called with the numbers of windows that are done and that are expected.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        If there are fewer measurements than numbers, or a number does nothing.
    """
    refuse_without("scipy")
    space = observation.space(within)
    misfit = Misfit(observation, space, loss)
    _refuse(misfit)
    # until the noise is known; of the first kind, and of one alone, the weight stays 1
    first = next(iter(misfit.sizes.values()))
    misfit.weights = {group: first / size for group, size in misfit.sizes.items()}
    misfit.last = (None,)
    widen(misfit)
    misfit.rival = rival.residuals if rival else {}
    hopeless = HOPELESS if rival else MET
    count = len(windows(misfit))
    ends: list[Minimum] = []
    costs: list[float] = []
    lost = False
    points = starts_of(misfit, starts)
    done = np.zeros(starts, int)  # windows of each search
    n = 0

    def searched(k: int) -> list[Minimum]:
        """Return the minima of a search by its number, best first."""

        def report(windows: int) -> None:
            """Report the progress of this search as part of those that have begun."""
            with misfit.lockstep.lock:
                done[k] = windows
                progress(int(done.sum()), n * count)

        part = copy.copy(misfit)
        # the seed is that of this search, so that fits are reproducible
        minima = search(part, points[k], np.random.default_rng((0, k)), report)
        if OFFSET in space.names and minima[0].searches:
            return [*walk(part, minima[0], space.names.index(OFFSET)), *minima[1:]]
        return minima

    while n < starts:
        first = n
        # as many as must still meet, or be hopeless
        n = min(starts, n + max(1, hopeless - (ends[0].searches if ends else 0)))
        progress(int(done.sum()), n * count)
        for minima in misfit.lockstep.map(searched, range(first, n)):
            ends = merge([*ends, *minima])
            costs += [end.cost for end in minima[:1] if end.searches]
        # searches that were given up, and those that ended as far from the data as the best
        failed = n - len(costs) + sum(cost < ALIKE * min(costs) for cost in costs)
        left = misfit.left(ends[0].point)
        is_noise = not _not_noise(misfit, *left)
        lost = failed >= hopeless and not is_noise
        explained = rival is not None and misfit.excess(ends[0].cost) < RIVAL / 2
        if ends[0].searches >= MET or lost or explained:
            break
        if is_noise and not rival:  # further searches are given up where they fit much worse
            misfit.rival = left[0]
    # others cannot fit nearly as well as the best one
    most = ends[0].cost + (0 if lost else WORSE * ends[0].variance)
    ends = [end for end in ends if end.cost <= most]
    misfit.refine()
    if len(observation.groups) > 1:
        misfit.weigh(ends[0].point)
    if ends[0].searches:  # was not given up; a search along a long valley may have ended early
        again = local_minima(misfit, [end.point for end in ends], misfit.rows)
        ends = merge(
            [new._replace(searches=end.searches) for new, end in zip(again, ends, strict=True)]
        )
    return judged(misfit, ends, n, systematic=systematic, hopeless=lost)


def _refuse(misfit: Misfit) -> None:
    """Raise InputError for measurements that cannot be fitted.

    There are too few, they begin before the motion, the scenario cannot move over their time, or a
    free number has no effect on them.
    """
    observation = misfit.observation
    space = misfit.space
    for group, given in observation.given.items():
        # its noise is estimated, and a fit can follow as many numbers as are free
        if given.sum() <= len(space.names):
            raise InputError(
                f"{group} must have more measured numbers than are free ({len(space.names)}), but "
                f"has {given.sum()}: measure more, or leave it out."
            )
    start = np.zeros(len(space.names))
    values = space.values(start)
    _, jacobian = misfit.at(start[None], misfit.rows)
    if values.get(CLOCK, 1.0) * observation.t[0] + values.get(OFFSET, 0.0) < 0:
        first = f"but begin at {observation.t[0]:.6g} s: shift them, or let `{OFFSET}` be free"
        raise InputError(f"times must begin at 0, the start of the motion, or later, {first}.")
    if np.isnan(misfit.read(observation, values, misfit.rows)).all():
        raise InputError("the scenario must move over the time of the table, but cannot.")
    # of the groups, in the order in which `Misfit.read` joins their residuals
    ends = np.cumsum([given.sum() for given in observation.given.values()])[:-1]
    sizes = np.array([np.linalg.norm(some, axis=0) for some in np.split(jacobian[0], ends)])
    seen = np.array([np.sqrt(np.nansum(rows**2)) for rows in observation.groups.values()])
    moves = np.any(sizes > IDLE * seen[:, None], axis=0).tolist()
    idle = [name for name, does in zip(space.names, moves, strict=True) if not does]
    if idle:
        raise InputError(
            [f"`{name}` must change the measurements, but has no effect on them." for name in idle]
        )


def _autocorrelations(parts: Arrays) -> list[np.ndarray]:
    """Return the autocorrelations of each part of the residuals, by lag, (rows,) each.

    Rows with gaps are left out, so that a lag counts given rows; so are parts of zeros or gaps.
    """
    found = []
    for part in (part for off in parts.values() for part in off.T):
        r = part[np.isfinite(part)]
        if (r != 0).any():
            products = np.fft.irfft(np.abs(np.fft.rfft(r, 2 * len(r))) ** 2)[: len(r)]
            found.append(products / products[0])
    return found


def _excess(parts: Arrays) -> float:
    """Return the excess of squared autocorrelations over those of noise, in standard deviations.

    `parts` are residuals by kind of measurement, (rows, parts).
    """
    lags = np.arange(1, LAGS + 1)
    worst = 0.0
    for rho in _autocorrelations(parts):
        n = len(rho)
        if n > 2 * LAGS:
            total = n * (n + 2) * (rho[lags] ** 2 / (n - lags)).sum()  # Ljung and Box 1978
            # of noise it has the mean LAGS and the variance 2 LAGS (chi-squared)
            worst = max(worst, float((total - LAGS) / np.sqrt(2 * LAGS)))
    return worst


def correlation_time(parts: Arrays) -> float:
    """Return over how many rows residuals are correlated: 1 + 2 sum of their autocorrelations.

    The sum ends with the first lag whose autocorrelation is not significant; the largest time of
    all parts counts.
    """
    longest = 1.0
    for rho in _autocorrelations(parts):
        some = rho[1 : len(rho) // 4]
        # two standard deviations of noise; False: an end, where all lags are significant
        end = np.argmin([*(some >= 2 / np.sqrt(len(rho))), False])
        longest = max(longest, 1 + 2 * float(some[:end].sum()))
    return longest


def judged(
    misfit: Misfit,
    ends: Sequence[Minimum],
    searches: int,
    *,
    systematic: bool,
    hopeless: bool,
) -> Fit:
    """Return the `Fit` of searches that ended in these minima, best first.

    `hopeless`: whether they ended early, far from the data; `systematic`: whether influences are
    tried. Variances are multiplied by the time over which residuals are correlated. Where residuals
    are not noise, intervals are NaN, by which `Fit.is_noise` recognises that.
    """
    from scipy.stats import t as student

    space = misfit.space
    point = ends[0].point
    (residual,), (jacobian,) = misfit.at(point[None, :], misfit.rows)
    weight = misfit.weight(residual)
    root = np.sqrt(weight)
    values = space.values(point)
    parts, noise = misfit.left(point)
    rows = correlation_time(parts)
    freedom = max(float(weight.sum()) / rows - len(point), 1.0)
    variance = misfit.variance(residual) * rows
    scaled = jacobian * root[:, None]
    sizes = np.linalg.norm(scaled, axis=0)
    sizes = np.where(sizes > 0, sizes, 1)
    across, singular, ways = np.linalg.svd(scaled / sizes, full_matrices=False)
    slopes = space.slopes(point) / sizes
    # pseudo-inverse, of columns of length 1; a direction without effect has a huge error
    inverse = slopes @ (ways.T / np.maximum(singular, 1e-12)) @ across.T
    covariance = variance * inverse @ inverse.T
    sigma = np.sqrt(np.diag(covariance))
    correlations = covariance / np.outer(sigma, sigma)
    doubts = _not_noise(misfit, parts, noise)
    changes = influences.changes(misfit, values) if systematic else {}
    shifts = {n: np.linalg.norm(inverse @ (root * some).T, axis=1) for n, some in changes.items()}
    beside = np.sqrt(sum((shift**2 for shift in shifts.values()), np.zeros(len(point))))
    quantile = float(student.ppf(QUANTILE, freedom)) if not doubts else np.nan
    # standard errors in the coordinates of the `Scale`s
    widths = sigma / [s.slope(v) for s, v in zip(space.scales, values.values(), strict=True)]
    estimates = {}
    for (name, value), scale, width, *errors in zip(
        values.items(), space.scales, widths, sigma.tolist(), beside.tolist(), strict=True
    ):
        limits = scale.inside(value) + quantile * width * np.array([-1, 1])
        if not scale.logarithmic:
            limits = np.clip(limits, scale.low, scale.high)
        low, high = scale.outside(limits).tolist()
        estimates[name] = Estimate(float(value), errors[0], low, high, errors[1])
    met = ends[0].searches
    reasons = []
    if hopeless and met < MET and doubts:
        reasons.append(
            f"{searches} independent searches found nothing near enough to the data: more `starts` "
            "would hardly help."
        )
    elif met < MET:
        reasons.append(
            f"the minimum is not trustworthy: {met} of {searches} independent searches ended "
            f"there ({MET} are needed), and other numbers may fit better: more `starts` may decide."
        )
    reasons += [*_undecided(space, values, widths, correlations), *_rivals(space, ends), *doubts]
    shares = {name: shift / sigma for name, shift in shifts.items()}
    if not any(share.max() > LARGE for share in shares.values()):
        shares = {"what the scenario lacks, together,": beside / sigma}
    reasons += [
        f"{name} would move `{space.names[share.argmax()]}` by {share.max():.2g} standard errors."
        for name, share in shares.items()
        if share.max() > LARGE
    ]
    if changes and not reasons:
        reasons = _hidden(misfit, ends, changes)
    trustworthy = not reasons
    reasons.insert(
        0,
        "the numbers fit: the residuals are noise."
        if trustworthy
        else "the fit must be read with care:",
    )
    return Fit(
        misfit.observation,
        estimates,
        correlations,
        met >= MET,
        trustworthy,
        reasons,
        parts,
        noise,
        {name: dict(zip(values, shift.tolist(), strict=True)) for name, shift in shifts.items()},
        rows,
    )


def _not_noise(misfit: Misfit, parts: Arrays, noise: dict[str, float]) -> list[str]:
    """Return sentences on residuals that are not noise, or not of the stated size; [] of others.

    `parts` and `noise` are those of `Misfit.left`: the residuals of each kind of measurement, and
    their root mean squares, SI. `fit` calls it too: only with a sentence it gives up searches.
    """
    observation = misfit.observation
    reasons = []
    excess = _excess({g: off for g, off in parts.items() if noise[g] > misfit.rounding[g]})
    if excess > NOISY:
        reasons.append(
            f"the residuals are not noise (their autocorrelations are {excess:.0f} standard "
            "deviations too large): the model, or a start, is missing something."
        )
        if OFFSET not in misfit.space.names and observation.t[0] > observation.reach:
            reasons.append(
                f"the table begins {observation.t[0]:.6g} s after the start of the motion: let "
                f"`{OFFSET}` be free if its clock was started earlier."
            )
    for group, stated in observation.stated.items():
        count = np.isfinite(parts[group]).sum()
        # the variance of `count` residuals has the relative standard deviation sqrt(2/count)
        if noise[group] > stated * np.sqrt(1 + NOISY * np.sqrt(2 / count)):
            reasons.append(
                f"the residuals of {group} are larger than the stated noise: {noise[group]:.3g} "
                f"rad, not {stated:.3g} rad."
            )
    return reasons


def _undecided(
    space: Space, values: dict[str, float], widths: np.ndarray, correlations: np.ndarray
) -> list[str]:
    """Return sentences on the numbers that the data do not decide.

    `values` are in SI, in the order of `space.scales`, the standard errors `widths` (free,) in
    coordinates of these; `correlations` are (free, free).
    """
    reasons = []
    for (name, value), scale, width in zip(values.items(), space.scales, widths, strict=True):
        u = scale.inside(value)
        for side, limit in (("lowest", scale.low), ("highest", scale.high)):
            if np.isfinite(limit) and abs(u - limit) <= min(AT_BOUND * width, AT_BOUND):
                reasons.append(f"`{name}` ran into its {side} value, {scale.outside(limit):.6g}.")
        if width > (1.0 if scale.logarithmic else max(1.0, abs(u))):
            reasons.append(
                f"the data cannot decide `{name}`: its standard error is as large as itself."
            )
    for i, j in np.argwhere(np.tril(np.abs(correlations) > CORRELATED, -1)):
        if max(widths[i], widths[j]) > ROUGH:
            reasons.append(
                f"`{space.names[j]}` and `{space.names[i]}` cannot be distinguished: correlation "
                f"{correlations[i, j]:.4f}."
            )
    return reasons


def _rivals(space: Space, ends: Sequence[Minimum], where: str = "") -> list[str]:
    """Return [] or a sentence, if other numbers than those of the first end fit nearly as well.

    `ends` are minima, the fitted one first; `where` is appended to the sentence. `_hidden` passes
    ends with smaller costs, among which another one may be the best.
    """
    best = ends[0]
    near = [
        space.values(end.point) for end in ends[1:] if end.cost - best.cost < RIVAL * best.variance
    ]
    if not near:
        return []
    numbers = ", ".join(f"{name} = {value:.6g}" for name, value in near[0].items())
    more = f" (and {len(near) - 1} more such sets)" if len(near) > 1 else ""
    return [
        f"other numbers fit nearly as well{where}: {numbers}{more}; errors are those of one set."
    ]


def _hidden(misfit: Misfit, ends: Sequence[Minimum], changes: Arrays) -> list[str]:
    """Return sentences if influences explain the motion better, or make other numbers fit as well.

    `ends` are minima, best first; `changes` those of residuals at the first one, by influence.
    """
    best = ends[0]

    def gain(end: Minimum, changes: Arrays) -> float:
        """Return by how much the cost falls where influences of about their sizes are free too.

        `changes`: the residuals that each influence adds, (directions, residuals).
        """
        if not changes:
            return 0.0
        root = np.sqrt(misfit.weight(end.residual))
        by_numbers, _ = np.linalg.qr(end.jacobian)  # SciPy's, which has the weights of a loss
        left = np.concatenate([*changes.values()]).T * root[:, None]
        left -= by_numbers @ (by_numbers.T @ left)
        slope = left.T @ (root * end.residual)
        known = best.variance * np.eye(len(slope))
        return float(slope @ np.linalg.solve(left.T @ left + known, slope))

    values = [misfit.space.values(end.point) for end in ends[1:]]
    others = [influences.changes(misfit, some) for some in values]
    gains = [gain(end, some) for end, some in zip(ends, [changes, *others], strict=True)]
    freed = [end._replace(cost=end.cost - g) for end, g in zip(ends, gains, strict=True)]
    reasons = _rivals(misfit.space, freed, ", if the scenario lacks something")
    if gains[0] > RIVAL * best.variance:
        name = max(changes, key=lambda name: gain(best, {name: changes[name]}))
        reasons.append(
            f"the residuals are like those of {name}, or of several: let its numbers be free."
        )
    return reasons

"""The numbers that fit best: SciPy's least squares from many starts, over windows that grow.

The misfit of a motion that oscillates has a minimum in nearly every period, and the minima are
wider where the data are shorter. A search begins with several starts and a short first window.
Before the last window the scenario's numbers count as measurements with a standard error of one
plausible distance, so that numbers that a window leaves open stay plausible. Over each window
points about the best one are tried, as far as slow changes leave it open: they are in other
periods. Searches with other starts and other points are independent of each other.
"""

import copy
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from .misfit import Misfit
from .observation import OFFSET
from .scales import FAR, Space


# Measurements of the first window per free number
FEWEST = 3
# Growth of a window to the next, and where the contact may change
GROWTH = 1.5
ROUGH = 2.0
# Starts of a search; fewer in proportion, as points that are tried, where numbers are known better
BATCH = 8
# Different points that continue to the next window
BEAM = 4
# Points that are tried about the best one
CLOUD = 128
# Those of them in other periods that are improved
CHILDREN = 2
# Their distance in standard errors
WIDER = 1.5
# How often they are tried at most, as long as they lead to better ones: from period to period
ROUNDS = 8
# Step of slow changes in plausible distances
COARSE = 0.3
# Growth of the rows over which points about the best one are tried in any case
LOOK = 6
# Growth of the variance from one window to the next, beyond which they are tried again
SURPRISE = 1.1
# Growth of the variance beyond which a window of twice the rows is reached by way of a shorter one
LOST = 2.0
# Variances of the noise by which a dropped point is worse than the best one
WORSE = 60.0
# Variances of the noise between points that are the same
SAME = 1.0
# Plausible distances within which points are the same before the last window
NEAR = 0.03
# Change of the variances of the noise by which a local search ends, and by which the last one does,
# relative to all
ENOUGH = 0.1
EXACT = 1e-8
# Change of a point, relative, by which a local search ends where the contact may change
SMALL = 1e-3
# Multiple of the stated noise, of the residuals of a window, beyond which a search is given up
HOPELESS = 3.0
# Fewest residuals that can end a search: noise rarely makes half of this many so large
SURE = 12
# Ratio of the standard deviation of noise to the median of its size
MEDIAN = 1.4826
# Motions of a local search before the last window
FEW = 12
# Motions of a local search over the last window
MOST = 60


class Minimum(NamedTuple):
    """A minimum over a window, with residuals, Jacobian, cost and variance.

    `local_minimum` makes it, and `search` where it is given up. The residuals are those of `Misfit`
    over the window; of the former, SciPy has multiplied the Jacobian by the weights of the loss.
    `searches` is the number of searches that ended there; 0 of one that was given up, and of
    minima that a search came across.

    Shapes are `point` (free,), `residual` (numbers,), `jacobian` (numbers, free). `cost` is the sum
    of squares of the residuals, as the loss bends them; before the last window with those of the
    scenario's numbers. `variance` is that of the noise, see `Misfit.variance`.
    """

    point: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    cost: float
    variance: float
    searches: int = 0

    def met(self, other: "Minimum", within: float = np.inf) -> bool:
        """Return whether another point is the same to the data, and near in each coordinate.

        Both are minima over the same window; the variance of this one counts. Half the sum of the
        Jacobians follows a curved valley, but leads from one period to the next over the ridge.
        """
        apart = self.point - other.point
        seen = (self.jacobian + other.jacobian) @ apart / 2
        return bool(seen @ seen < SAME * self.variance and np.all(np.abs(apart) < within))


def local_minimum(
    misfit: Misfit, point: np.ndarray, rows: int, size: float | None = None
) -> Minimum:
    """Return the minimum next to a point (free,) over the first `rows` measurements.

    `size` is the scale beyond which a loss bends. None: that of the residuals of the point, and the
    minimum over all rows is exact; it is in a search too where the misfit is smooth. Where the
    contact may change, it is rough, and a motion may take half a second: small steps end a search,
    and the Jacobian is computed at the point only, and corrected by the steps (Broyden 1965).
    """
    from scipy.optimize import least_squares

    def residuals(x: np.ndarray) -> np.ndarray:
        """Return the residuals at a point of the space of free numbers."""
        return misfit.residuals(x[None], rows)[0]

    known: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def slopes(x: np.ndarray) -> np.ndarray:
        """Return the Jacobian of the residuals at a point, below it `keep` times the unit matrix.

        It is computed once if the misfit is rough, and then updated by the steps (Broyden 1965).
        """
        after = residuals(x)
        if is_rough and known:
            point, before, jacobian = known.pop()
            move = x - point
            missed = after - before - jacobian @ move
            jacobian = jacobian + np.outer(missed, move / (move @ move))
        else:
            jacobian = misfit.at(x[None], rows)[1][0]
        known.append((x, after, jacobian))
        return np.vstack([jacobian, keep * np.eye(len(x))])

    last = rows >= misfit.rows
    is_rough = size is not None and misfit.observation.problem.system.is_hybrid
    exact = last and not is_rough
    begin = residuals(point)
    count = len(begin)
    # the scenario's numbers, 0 in these coordinates, count as measurements before the last window
    keep = 0.0 if last else float(np.sqrt(np.mean(begin**2)))
    result = least_squares(
        lambda x: np.append(residuals(x), keep * x),
        point,
        slopes,
        bounds=misfit.space.bounds,
        loss=misfit.loss,
        f_scale=size or misfit.size(begin),
        ftol=EXACT if exact else ENOUGH / count,
        xtol=SMALL if is_rough else EXACT,
        gtol=float(np.finfo(float).eps),  # where nothing moves
        max_nfev=MOST if last else FEW,
    )
    residual = result.fun[:count]
    cost = 2 * result.cost  # SciPy's is half the sum of squares
    variance = misfit.variance(residual)
    return Minimum(result.x, residual, result.jac[:count], cost, variance)


def local_minima(
    misfit: Misfit, points: Iterable[np.ndarray], rows: int, size: float | None = None
) -> list[Minimum]:
    """Return the `local_minimum` next to each of several points; their motions run together."""
    return misfit.lockstep.map(
        lambda point: local_minimum(copy.copy(misfit), point, rows, size), points
    )


def search(
    misfit: Misfit, points: np.ndarray, random: np.random.Generator, progress: Callable[[int], None]
) -> list[Minimum]:
    """Return minima over all of the data, best first, to which starts (starts, free) lead.

    The best one alone counts as an end of the search. A search whose residuals are much larger than
    the stated noise, or than those of the rival, before its last window is given up: it returns its
    best point, which does not count.

    `progress`: called with the number of windows that are done, of those of `windows`.
    """
    rows = windows(misfit)
    stated = [misfit.observation.stated.get(g, np.inf) for g in misfit.observation.groups]
    most = HOPELESS / MEDIAN * max(stated)
    least = np.inf
    looking = True
    reached = rows[0]
    ahead = rows[::-1]
    while ahead:
        window = ahead.pop()
        last = window == rows[-1]
        residuals = misfit.residuals(points, window)
        size = misfit.size(residuals[np.argmin((residuals**2).sum(axis=1))])
        minima = merge(local_minima(misfit, points, window, size), last=last)
        best = minima[0]
        for _ in range(ROUNDS if looking or last else 0):
            more = _cloud(misfit, best, window, random)
            minima = merge([*minima, *local_minima(misfit, more, window, size)], last=last)
            before = best
            best = minima[0]
            if before.cost - best.cost < best.variance:
                break
        is_far = len(best.residual) >= SURE and misfit.size(best.residual) > most
        if not last and (is_far or misfit.excess(best.cost, window) > WORSE):
            (residual,), (jacobian,) = misfit.at(best.point[None], misfit.rows)
            cost = float((residual**2).sum())
            return [Minimum(best.point, residual, jacobian, cost, misfit.variance(residual))]
        # lost on the way: try a window between this one and the last that was reached
        if best.variance > LOST * least and window >= 2 * reached > 2:
            ahead += [window, (reached + window) // 2]
            continue
        kept = [s for s in minima if s.cost < best.cost + WORSE * best.variance][:BEAM]
        points = np.array([s.point for s in kept])
        looking = window < LOOK * rows[0] or len(kept) > 1 or best.variance > SURPRISE * least
        least = min(least, best.variance)
        reached = window
        progress(int(np.searchsorted(rows, window, "right")))
    return [best._replace(searches=1), *kept[1:]]


def widen(misfit: Misfit) -> None:
    """Widen the distances of numbers that start at 0 as the first residuals require, in place.

    This holds for vectors too; the distance of the clock is that within which it is searched. It
    comes before `starts_of`: coordinates of points, but 0, have another meaning afterwards.
    """
    space = misfit.space
    (residual,), (jacobian,) = misfit.at(np.zeros((1, len(space.names))), windows(misfit)[0])
    # the distances whose effects, each alone and linear, are as large as the residuals
    need = (
        space.width
        * np.linalg.norm(residual)
        / np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    )
    space.width = np.where(space.loose, np.maximum(space.far, need), space.far)
    if OFFSET in space.names:
        clock = space.names.index(OFFSET)
        space.width[clock] = misfit.observation.reach / space.scales[clock].size


def windows(misfit: Misfit) -> list[int]:
    """Return the number of rows of each window, growing; the last one has all of them."""
    total = misfit.rows
    fewest = FEWEST * len(misfit.space.names)
    growth = ROUGH if misfit.observation.problem.system.is_hybrid else GROWTH
    rows = [min(total, int(np.ceil(fewest * total / misfit.observation.count)))]
    while rows[-1] < total:
        rows.append(min(total, int(np.ceil(growth * rows[-1]))))
    return rows


def merge(minima: list[Minimum], *, last: bool = True) -> list[Minimum]:
    """Return different minima over one window, best first, with the searches that ended in each.

    Before the `last` window those that are the same to the data, but not `NEAR`, stay different.
    """
    kept: list[Minimum] = []
    for state in sorted(minima, key=lambda s: s.cost):
        n = next(
            (n for n, other in enumerate(kept) if other.met(state, np.inf if last else NEAR)), None
        )
        if n is None:
            kept.append(state)
        else:
            kept[n] = kept[n]._replace(searches=kept[n].searches + state.searches)
    return kept


def _cloud(misfit: Misfit, best: Minimum, rows: int, random: np.random.Generator) -> np.ndarray:
    """Return the best of many points about one, and the best CHILDREN in other periods, (k, free).

    The points are where slow changes allow them; from another period the Jacobian expects residuals
    that are much larger than those there.
    Differences over a coarse step ignore fast oscillations: their derivatives are large, and
    mean nothing far from the point.
    """
    space = misfit.space
    one = np.eye(len(best.point))
    ahead, behind = (space.clipped(best.point + sign * COARSE * one) for sign in (1, -1))
    after, before = (misfit.residuals(side, rows) for side in (ahead, behind))
    slow = (after - before) / np.diag(ahead - behind)[:, None]
    # the unit matrix: the scenario's numbers, known within one plausible distance
    spread = np.linalg.inv(slow @ slow.T / best.variance + one)
    points = space.clipped(
        random.multivariate_normal(
            best.point, WIDER**2 * spread, _share(CLOUD, space, CHILDREN), method="eigh"
        )
    )
    order = np.argsort(misfit.costs(points, rows, best.residual), kind="stable")
    seen = (points[order] - best.point) @ best.jacobian.T
    others = order[(seen**2).sum(axis=1) > WORSE * best.variance]
    return points[np.unique([order[0], *others[:CHILDREN]])]


def starts_of(misfit: Misfit, searches: int) -> np.ndarray:
    """Return the starts of searches, (searches, starts, free), spread about the scenario.

    The first start of the first search is the scenario itself.
    """
    from scipy.stats import qmc

    free = len(misfit.space.names)
    batch = _share(BATCH, misfit.space)
    count = searches * batch
    sobol = qmc.Sobol(free, seed=0).random_base2(int(np.ceil(np.log2(count))))
    points = np.vstack([np.zeros(free), 2 * sobol - 1])[:count]
    # neighbours in the sequence go to different searches
    return misfit.space.clipped(points).reshape(batch, searches, free).swapaxes(0, 1)


def _share(count: int, space: Space, least: int = 1) -> int:
    """Return how many of `count` points are needed in a space, at least `least`.

    They are fewer in proportion where numbers are known better than `FAR`.
    """
    return max(least, round(count * min(1.0, space.within / FAR)))

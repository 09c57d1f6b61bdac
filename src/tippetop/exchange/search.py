"""The numbers that fit best, sought over a window that grows as far as they predict the motion.

A motion that oscillates has a best fit in every period, and only near the start of the data is the right one near. So
the first window is short, and what it does not decide is kept near where the start has it. What it leaves undecided
says how far ahead the motion is predicted to within the noise: so far the window grows, and the fit stays in the valley
that it is in. Fast oscillations that are hardly seen have many shallow valleys beside: points about the best are tried,
as far as earlier windows left them open.
"""

from typing import Any, NamedTuple

import numpy as np

from .misfit import Misfit


FEWEST = 8  # measurements of the first window, per free number
AHEAD = 2.0  # standard deviations of the noise by which a predicted measurement may be uncertain
SLOWEST, FASTEST = 1.1, 1.6  # growth of a window to the next
PRIOR = 0.25  # the standard deviation, in the coordinates of the search, that the start itself has
UNLIKELY = 30.0  # variances of the noise by which other valleys are worse, or have met the best, when it is alone
WRONG, SOME = 1.3, 8  # the growth that tells a wrong valley, of windows of more than so many rows per free number
SURPRISE = 1.05  # growth of what is left, in its variance, that makes a window look about again
CLOUD, FEW, MOST = 30_000, 64, 256  # rows of all points about one; how many points
WIDER = 1.5  # standard errors: how far they are
COARSE = 0.12  # step, in the coordinates of the search
BRANCHES, APART = 3, 6.0  # of them that are improved, and how far apart these are, in standard errors of the window
STEPS, LAST_STEPS = 6, 30  # at most, of an improvement over a window; over all of the data
COARSE_END, LAST_END = 0.05, 1e-7  # variances of the noise by which the last step of these lowers the cost at most
LONGEST = 0.3  # step
FAR = 0.4  # how far off other starts are
RIVAL = 25.0  # variances of the noise by which the cost of another fit exceeds that of the best at most
SAMPLES = 512  # others, of which the best are followed
NEAR = 6  # windows: others are judged by so many times the first one


class End(NamedTuple):
    """Where a start led: the point, (free,), its cost, and the variance of what it leaves; points of other valleys that
    were seen, with their costs."""

    point: np.ndarray
    cost: float
    variance: float
    rivals: tuple[tuple[np.ndarray, float], ...] = ()


def followed(misfit: Misfit, start: np.ndarray, seed: int = 0, *, to_the_end: bool = False) -> End | None:
    """The best point from a start; None as soon as a window leaves much more than the ones before, for then the valley
    is a wrong one, unless it is wanted to the end."""
    random = np.random.default_rng(seed)
    total, free = len(misfit.observation.t), len(start)
    rows, point, least, looking, known = _first(misfit), start, np.inf, True, None
    enough = NEAR * rows
    rivals: list[State] = []
    while True:
        window, last = min(rows, total), rows >= total
        state = improved(misfit, point, start, window, last=last, known=known)
        looking = looking or state.variance > SURPRISE * least
        points = _about(misfit, state, window, random) if looking else [rival.point for rival in rivals]
        states = [state, *(improved(misfit, p, start, window, last=last) for p in points)]
        best, *rivals = sorted(states, key=lambda s: s.cost + s.variance / PRIOR**2 * _square(s.point - start))
        rivals = [r for r in rivals if r.cost - best.cost < UNLIKELY * best.variance and not met(best, r)]
        looking = looking and bool(rivals) and (window < enough or state.cost - best.cost > best.variance)
        state, point = best, best.point
        if state.variance > WRONG * least and rows > SOME * free and not to_the_end:
            return None
        least = min(least, state.variance * (1 + 2 * np.sqrt(2 / max(len(state.residual) - free, 1))))
        if last:
            return End(point, state.cost, state.variance, tuple((r.point, r.cost) for r in rivals))
        ahead = min(total, int(np.ceil(FASTEST * rows)))
        (residual,), (jacobian,) = misfit.at(point[None, :], ahead)
        row = misfit.rows(ahead)
        within = jacobian[row < rows]
        decided = np.linalg.inv(within.T @ within + state.variance / PRIOR**2 * np.eye(free))
        spread = np.einsum("mf,mf->m", jacobian, jacobian @ decided)  # in variances of the noise
        unsure = row[(spread > AHEAD**2) & (row >= rows)]
        rows = min(max(int(unsure.min()) if len(unsure) else ahead, int(np.ceil(SLOWEST * rows))), total)
        known = residual[row < rows], jacobian[row < rows]


def _about(misfit: Misfit, state: "State", rows: int, random: np.random.Generator) -> list[np.ndarray]:
    """The best few of many points about one that lie in other valleys: as far as its slow changes leave open where it
    lies. Differences over a coarse step know nothing of fast oscillations, whose derivatives are large."""
    one = np.eye(len(state.point))
    ahead, behind = (misfit.space.clipped(state.point + sign * COARSE * one) for sign in (1, -1))
    (after, before), width = (
        (misfit.at(side, rows, slopes=False)[0] for side in (ahead, behind)),
        np.diag(ahead - behind),
    )
    slow = (after - before) / width[:, None]
    spread = np.linalg.inv(slow @ slow.T / state.variance + one / PRIOR**2)
    count = int(np.clip(CLOUD / rows, FEW, MOST))
    points = misfit.space.clipped(random.multivariate_normal(state.point, WIDER**2 * spread, count, method="eigh"))
    residuals, _ = misfit.at(points, rows, slopes=False)
    costs = misfit.costs(residuals, misfit.size(state.residual))
    metric = state.jacobian.T @ state.jacobian / state.variance
    known = [state.point]
    for k in np.argsort(costs, kind="stable"):
        if all((points[k] - p) @ metric @ (points[k] - p) > APART**2 for p in known):
            known.append(points[k])
        if len(known) > BRANCHES:
            break
    return known[1:]


def met(one: "State", other: "State") -> bool:
    """Whether two points are one, as far as the data can tell."""
    return _square(one.jacobian @ (one.point - other.point)) < one.variance


def _square(x: np.ndarray) -> float:
    return float(x @ x)


def finished(misfit: Misfit, point: np.ndarray) -> End:
    """The best point near one that fits all of the data already."""
    state = improved(misfit, point, point, len(misfit.observation.t), last=True)
    return End(state.point, state.cost, state.variance)


def others(misfit: Misfit, count: int, seed: int) -> np.ndarray:
    """The best of many other starts, spread evenly about the scenario's own, by the first rows, (count, free)."""
    from scipy.stats import qmc

    space = misfit.space
    sobol = qmc.Sobol(len(space.names), seed=seed).random(SAMPLES)
    points = space.clipped(space.start + FAR * (2 * sobol - 1))
    residuals, _ = misfit.at(points, min(NEAR * _first(misfit), len(misfit.observation.t)), slopes=False)
    costs = misfit.costs(residuals, misfit.size(residuals[np.argmin((residuals**2).sum(axis=1))]))
    return points[np.argsort(costs, kind="stable")[:count]]


def _first(misfit: Misfit) -> int:
    """Rows of the first window."""
    total = len(misfit.observation.t)
    count = len(misfit.rows(total))
    return min(total, int(np.ceil(FEWEST * len(misfit.space.names) * total / count)))


class State(NamedTuple):
    """A point with its residuals and their Jacobian; its cost without the prior, and the variance of the residuals."""

    point: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    cost: float
    variance: float


def improved(
    misfit: Misfit, point: np.ndarray, start: np.ndarray, rows: int, *, last: bool, known: Any = None
) -> State:
    """A point after steps of Levenberg and Marquardt over the first rows; before the last window near the start.

    `known`: residuals and Jacobian of the point over these rows, if they are. A step that promises next to nothing is
    not tried."""
    free = len(point)
    residual, jacobian = known or (part[0] for part in misfit.at(point[None, :], rows))
    size = misfit.size(residual)
    plain = float(misfit.costs(residual[None, :], size)[0])
    damping = 1e-3
    variance = plain / max(len(residual) - free, 1)
    keep = 0.0 if last else variance / PRIOR**2
    cost = plain + keep * _square(point - start)
    for _ in range(LAST_STEPS if last else STEPS):
        new, promised = _step(misfit, point, residual, jacobian, size, damping, keep, start)
        if promised < (LAST_END if last else COARSE_END) * variance or damping > 1e6:
            break
        (residual_there,), (moves,) = misfit.at(new[None, :], rows)
        value = float(misfit.costs(residual_there[None, :], size)[0]) + keep * _square(new - start)
        if value <= cost:
            point, residual, jacobian, cost, damping = new, residual_there, moves, value, damping / 10
        else:
            damping = max(damping, 1e-8) * 10
        plain = cost - keep * _square(point - start)
        variance = plain / max(len(residual) - free, 1)
    return State(point, residual, jacobian, plain, variance)


def _step(
    misfit: Misfit,
    point: np.ndarray,
    residual: np.ndarray,
    jacobian: np.ndarray,
    size: float,
    damping: float,
    keep: float,
    start: np.ndarray,
) -> tuple[np.ndarray, float]:
    """Where a damped step leads, and by how much it would lower the cost if residuals were linear; a number at a bound
    does not go beyond it."""
    space, one = misfit.space, np.eye(len(point))
    weighted = jacobian * misfit.weight(residual, size)[:, None]
    slope = weighted.T @ residual + keep * (point - start)
    square = weighted.T @ jacobian + keep * one
    stuck = ((point <= space.low + 2e-6) & (slope > 0)) | ((point >= space.high - 2e-6) & (slope < 0))
    slope = np.where(stuck, 0.0, slope)
    damped = np.where(stuck[:, None] | stuck[None, :], one, square + damping * np.diag(np.diag(square)))
    scale = np.sqrt(np.maximum(np.diag(damped), 1e-300))
    step = -np.linalg.solve(damped / np.outer(scale, scale) + 1e-14 * one, slope / scale) / scale
    new = space.clipped(point + step * min(1.0, LONGEST / max(float(np.abs(step).max()), 1e-300)))
    step = new - point
    return new, -float(2 * slope @ step + step @ square @ step)

"""Other periods of an oscillation in which a free clock fits nearly as well.

Where a table's clock starts at an unknown time of the motion, and the oscillation that is seen is fast, there is a
valley of the cost for every period, and slow changes alone say which is right. So from the best fit one goes to the
next valley on either side, by the time of the clock alone, and on from there by the step that led there, as far as
valleys are nearly as deep.
"""

import numpy as np

from .misfit import Misfit
from .search import RIVAL, End, State, improved, met


REACH, POINTS = 1 / 8, 128  # of the duration, in which the next valley is looked for, and in how many points
MOST = 12  # valleys on either side
SAME = 1e-3  # variances of the noise: valleys so much alike are of a periodic motion, and the nearest is taken


def walked(misfit: Misfit, end: End, clock: int) -> End:
    """The best of the valleys about an end, with the others as its rivals.

    Parameters
    ----------
    misfit
        What is left of the measurements.
    end
        Of a search over all of the data.
    clock
        The place of the time of the clock among the free numbers.
    """
    first = _settled(misfit, end.point)
    known = [first]
    for side in (1, -1):
        before, here = first, _next(misfit, first, clock, side)
        for _ in range(MOST):
            if here is None or met(before, here) or here.cost - min(s.cost for s in known) > RIVAL * first.variance:
                break
            known.append(here)
            ahead = misfit.space.clipped(2 * here.point - before.point)
            before, here = here, _settled(misfit, ahead)
    least = min(state.cost for state in known)
    alike = [s for s in known if s.cost < least + SAME * first.variance]
    best = min(alike, key=lambda state: abs(state.point[clock] - end.point[clock]))
    others = [(s.point, s.cost) for s in sorted(known, key=lambda state: state.cost) if not met(best, s)]
    old = [(point, cost) for point, cost in end.rivals if cost >= best.cost]
    return End(best.point, best.cost, best.variance, (*others, *old))


def _settled(misfit: Misfit, point: np.ndarray) -> State:
    """The best point of the valley of a point, over all of the data."""
    return improved(misfit, point, point, len(misfit.observation.t), last=True)


def _next(misfit: Misfit, state: State, clock: int, side: int) -> State | None:
    """The valley beside one; None where the cost has none within reach."""
    t, total = misfit.observation.t, len(misfit.observation.t)
    shift = np.zeros((POINTS, len(state.point)))
    shift[:, clock] = side * np.linspace(0, REACH * (t[-1] - t[0]), POINTS) / misfit.space.scales[clock].size
    points = misfit.space.clipped(state.point + shift)
    residuals, _ = misfit.at(points, total, slopes=False)
    costs = misfit.costs(residuals, misfit.size(state.residual))
    lowest = np.flatnonzero((costs[1:-1] < costs[:-2]) & (costs[1:-1] < costs[2:])) + 1
    return _settled(misfit, points[lowest[0]]) if len(lowest) else None

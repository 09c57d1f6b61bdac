"""Other periods of an oscillation in which a free clock fits nearly as well.

Where a table's clock starts at an unknown time of the motion, and the observed oscillation is
fast, the misfit has a minimum in every period, and slow changes alone decide which is right. From
the best fit the next minimum on either side is searched along the time of the clock, and further
ones by the same step, as long as they are nearly as deep.
"""

import numpy as np

from .misfit import Misfit
from .search import Minimum, local_minimum


# Points in which the next minimum is searched
POINTS = 128
# Variances of the noise by which a minimum that is nearly as good is worse: odds of 1 in 1000
RIVAL = 14.0
# Minima on either side
MOST = 12
# Variances of the noise: minima that differ less are those of a periodic motion
SAME = 1e-3


def walk(misfit: Misfit, first: Minimum, clock: int) -> list[Minimum]:
    """Return the minima near one of all of the data, best first; the best alone counts as found.

    Of a periodic motion, whose minima are equal, the best is that nearest to the first.

    Parameters
    ----------
    misfit
        Residuals of the measurements.
    first
        The minimum in which a search ended.
    clock
        The place of the time of the clock among the free numbers.
    """
    known = [first._replace(searches=0)]  # the best of them gets its 1 at the end
    for side in (1, -1):
        before = first
        here = _next(misfit, first, clock, side)
        for _ in range(MOST):
            least = min(s.cost for s in known)
            if here is None or before.met(here) or here.cost - least > RIVAL * first.variance:
                break
            known.append(here)
            further = misfit.space.clipped(2 * here.point - before.point)
            before = here
            here = local_minimum(misfit, further, misfit.rows)
    least = min(s.cost for s in known)
    equal = [s for s in known if s.cost < least + SAME * first.variance]
    best = min(equal, key=lambda s: abs(s.point[clock] - first.point[clock]))
    others = [s for s in sorted(known, key=lambda s: s.cost) if not best.met(s)]
    return [best._replace(searches=1), *others]


def _next(misfit: Misfit, minimum: Minimum, clock: int, side: int) -> Minimum | None:
    """Return the next minimum of all data on one side of another, along the time of the clock.

    `clock` is the place of this time among the free numbers, `side` is +1 or -1. None where the
    cost has none within reach.
    """
    shift = np.zeros((POINTS, len(minimum.point)))
    seconds = misfit.space.width[clock] * misfit.space.scales[clock].size
    shift[:, clock] = side * np.linspace(0, misfit.observation.reach, POINTS) / seconds
    points = misfit.space.clipped(minimum.point + shift)
    costs = misfit.costs(points, misfit.rows, minimum.residual)
    lowest = np.flatnonzero((costs[1:-1] < costs[:-2]) & (costs[1:-1] < costs[2:])) + 1
    return local_minimum(misfit, points[lowest[0]], misfit.rows) if len(lowest) else None

"""How slip begins where nothing slips: at the edge of the cone, and outside it. [contact 2.4, 2.5]

At the edge w = 0 and the direction is that against the force of rolling, but its equation w beta' =
Q is singular, and so stiff nearby that no explicit step begins there. Chebyshev and Picard's sweeps
solve it on a whole interval at once: the direction from Q = w beta', everything else by
integration.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander


NODES, STEP = 12, 1e-5  # of beta, for a slope


class FirstSlip(NamedTuple):
    """The first moments of slip since the edge of the cone; at their end an integrator begins."""

    duration: Any
    coefficients: np.ndarray  # (n, k + 1) of Chebyshev polynomials of time: of state and beta

    def at(self, t: Any) -> np.ndarray:
        """Return state and beta at times t."""
        return chebval(2 * np.asarray(t) / self.duration - 1, self.coefficients)


def first_slip(
    rates: Callable, state: np.ndarray, beta: Any, duration: Any, lasts: Callable
) -> FirstSlip:
    """Return the motion from the edge of the cone, where w = P = Q = 0.

    Parameters
    ----------
    rates
        rates(state, beta) -> (the state's rate, Q) of slip in the direction beta, an angle from a
        fixed axis; of arrays (k, n), (n,). The last of the state is w, whose rate is P.
    state
        At the edge, (k,).
    beta
        The direction of the first slip: against the horizontal force of rolling.
    duration
        How long; 0.03/|omega| is right. It is halved until the sweeps converge and it `lasts`.
    lasts
        lasts(first) -> whether nothing else happens to the contact in a FirstSlip.

    Raises
    ------
    ArithmeticError
        Nothing begins to slip so.
    """
    for _ in range(12):
        first, change = _swept(rates, state, beta, duration)
        if change < 1e4 * np.finfo(state.dtype).eps and lasts(first):
            return first
        duration = duration / 2
    raise ArithmeticError("no slip begins at this edge of the cone")


def _swept(
    rates: Callable, start: np.ndarray, beta0: Any, duration: Any
) -> tuple[FirstSlip, float]:
    """Sweep until nothing changes by more than rounding.

    Return the slip, and the last change of w and beta, relative; infinite if w is not positive.
    """
    pi = np.arccos(-start.dtype.type(1))
    nodes = np.cos(pi * (np.arange(NODES) + 0.5) / NODES)
    fit = chebvander(nodes, NODES - 1).T * 2 / NODES  # to coefficients, (order, node)
    fit[0] /= 2
    integral = chebval(nodes, chebint(fit, lbnd=-1)) * duration / 2
    slope = chebval(nodes, chebder(fit)) * 2 / duration
    state, beta = np.repeat(start[:, None], NODES, 1), np.full(NODES, beta0)
    change = np.inf
    with np.errstate(all="ignore"):
        for sweep in range(40):
            w, old_beta, turn = state[-1], beta, state[-1] * (beta @ slope)
            for _ in range(2):
                below, Q, above = (rates(state, beta + by)[1] for by in (-STEP, 0, STEP))
                beta = beta - (Q - turn) * (2 * STEP) / (above - below)
            state = start[:, None] + rates(state, beta)[0] @ integral
            newer = np.max(np.abs(state[-1] - w)) / np.max(np.abs(state[-1]))
            newer += np.max(np.abs(beta - old_beta))
            if sweep > 6 and not newer < change:  # at first w may be zero by rounding
                break
            change = newer
    slip = FirstSlip(duration, fit @ np.vstack([state, beta]).T)
    return slip, change if np.all(state[-1] > 0) else np.inf


def first_directions(law: Callable, count: int = 360) -> np.ndarray:
    """Return every direction in which slip can begin from rest: Q = 0, P > 0, N > 0.

    There is exactly one outside the cone.
    """
    grid = 2 * np.pi * (np.arange(count + 1) + 1 / np.e) / count
    Q = law(grid)[1]
    low, high = (grid[i + np.flatnonzero((Q[:-1] > 0) != (Q[1:] > 0))] for i in (0, 1))
    above = law(low)[1] > 0
    for _ in range(60):
        middle = (low + high) / 2
        same = (law(middle)[1] > 0) == above
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    P, _, N = law(low)
    return low[(P > 0) & (N > 0)]

"""How slip begins where nothing slips: at the edge of the cone, and outside it. [contact 2.4, 2.5]

At the edge w = 0 and the direction is that against the force of rolling, but its equation w beta' =
Q is singular, and so stiff nearby that no explicit step begins there. Chebyshev and Picard's sweeps
solve it on a whole interval at once: the direction from Q = w beta', everything else by
integration.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander

from ..event import zero_of


NODES, STEP = 12, 1e-5  # of beta, for a slope


def first_slip(
    rates: Callable, state: np.ndarray, beta: Any, duration: Any, lasts: Callable
) -> tuple[Any, Callable]:
    """Return the duration of the motion from the edge of the cone, where w = P = Q = 0, and at(t),
    the state and beta at times t since then: at its end an integrator begins.

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
        lasts(end) -> whether nothing else happens to the contact until this state and beta.

    Raises
    ------
    ArithmeticError
        Nothing begins to slip so.
    """
    for _ in range(12):
        at = _swept(rates, state, beta, duration)
        if at and lasts(at(duration)):
            return duration, at
        duration = duration / 2
    raise ArithmeticError("no slip begins at this edge of the cone")


def _swept(rates: Callable, start: np.ndarray, beta0: Any, duration: Any) -> Callable | None:
    """Return at(t) after sweeps that converge; None if they do not, or nothing slips."""
    pi = np.arccos(-start.dtype.type(1))
    nodes = np.cos(pi * (np.arange(NODES) + 0.5) / NODES)
    fit = chebvander(nodes, NODES - 1).T * 2 / NODES  # to coefficients, (order, node)
    fit[0] /= 2
    integral = chebval(nodes, chebint(fit, lbnd=-1)) * duration / 2
    slope = chebval(nodes, chebder(fit)) * 2 / duration
    state, beta = np.repeat(start[:, None], NODES, 1), np.full(NODES, beta0)
    with np.errstate(all="ignore"):
        for _ in range(40):
            w, turn = state[-1], state[-1] * (beta @ slope)
            below, Q, above = (rates(state, beta + by)[1] for by in (-STEP, 0, STEP))
            change = (turn - Q) * (2 * STEP) / (above - below)
            beta = beta + change
            state = start[:, None] + rates(state, beta)[0] @ integral
            changes = *np.abs(change), *np.abs((state[-1] - w) / np.max(np.abs(state[-1])))
            if max(changes) < 1e4 * np.finfo(start.dtype).eps:
                break
        else:
            return None
    values = fit @ np.vstack([state, beta]).T
    slips = min(state[-1]) > 0
    return (lambda t: chebval(2 * np.asarray(t) / duration - 1, values)) if slips else None


def first_directions(law: Callable) -> Iterator[float]:
    """Yield every direction in which slip can begin from rest: Q = 0, P > 0, N > 0.

    There is exactly one outside the cone.
    """
    grid = np.radians(np.arange(361) + 1 / np.e)
    Q = law(grid)[1]
    for k in np.flatnonzero((Q[:-1] > 0) != (Q[1:] > 0)):
        beta = zero_of(lambda beta, k=k: law(beta)[1] * Q[k], *grid[k : k + 2])
        P, _, N = law(beta)
        if P > 0 and N > 0:
            yield beta

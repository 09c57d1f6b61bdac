"""How a point slides while it is so slow that its direction follows the forces: from rest, at the
edge of the friction cone or outside it, and to the next rest.

The direction has the equation w beta' = Q, which is singular at w = 0, and so stiff nearby that no
explicit step begins there. Its smooth solution is found on a whole interval at once, at the nodes
of Chebyshev: the direction by Newton's rule, everything else by Picard's, by integration.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander

from ..event import zero_of


NODES, STEP = 16, 1e-5  # of beta, for a slope
SWEEPS = 40
HALVINGS = 40

RESOLVED = 1e-17
"""Size of the last coefficients of a series that is resolved, relative to the largest."""

BRIEF = 1e-9
"""Part of the duration within which a slide that stops is due to rounding."""

SLAVED = 100
"""Length of a slide in units of the time in which its direction turns into that of the forces, from
which on an explicit integrator needs a multiple of the steps."""


def first_slip(
    rates: Callable, state: np.ndarray, beta: Any, duration: Any, lasts: Callable
) -> tuple[Any, Callable, bool] | None:
    """Compute a slow slide as a series in time.

    Returns
    -------
    tuple
        Its duration; at(t) -> the state and beta at times t since its start; and whether it is slow
        at its end too, or stops there. None if nothing begins to slide.

    Parameters
    ----------
    rates
        rates(state, beta) -> (the state's rate, Q) of slip in the direction beta, an angle from a
        fixed axis; of arrays (k, n), (n,). The last of the state is the speed w, whose rate is P;
        Q = w beta' (see `exits.pushed`).
    state
        At the start, (k,).
    beta
        About the direction there: the force of rolling points against it, or Q = 0.
    duration
        How long at most. It is halved until the series is resolved and the slide `lasts`.
    lasts
        lasts(end) -> whether nothing else happens to the contact until this state and beta.

    Raises
    ------
    ArithmeticError
        There is no such slide: its direction does not follow the forces.
    """
    for _ in range(HALVINGS):
        found = _swept(rates, state, beta, duration)
        if found:
            at, pace, stiffness = found
            first, *times = BRIEF * duration, *np.linspace(0, duration, 2 * NODES)[1:]
            if not max(pace(first), pace(times[0])) > 0:  # only rounding moves it
                return None
            stop = zero_of(pace, first, *times)
            end = duration if stop is None else stop
            if lasts(at(end)):
                return end, at, stop is not None or stiffness > SLAVED
        duration = duration / 2
    raise ArithmeticError("the direction of a slow slide does not follow the forces")


def _swept(rates: Callable, start: np.ndarray, beta0: Any, duration: Any) -> tuple | None:
    """Return the slide over a whole duration, found by repeated corrections at Chebyshev nodes.

    It is a tuple: at(t), as for `first_slip`; pace(t), the mean acceleration w/t; and the duration
    in units of the time in which the direction follows the forces. None if the corrections do not
    converge, or the series is not resolved.
    """
    pi = np.arccos(-start.dtype.type(1))
    nodes = np.cos(pi * (np.arange(NODES) + 0.5) / NODES)
    fit = chebvander(nodes, NODES - 1).T * 2 / NODES  # to coefficients, (order, node)
    fit[0] /= 2
    integral = chebval(nodes, chebint(fit, lbnd=-1)) * duration / 2
    slope = chebval(nodes, chebder(fit)) * 2 / duration
    state = np.repeat(start[:, None], NODES, 1)
    beta = np.full(NODES, beta0)
    with np.errstate(all="ignore"):
        for _ in range(SWEEPS):
            near = np.concatenate([beta, beta - STEP, beta + STEP])
            by, every = (np.split(one, 3, -1) for one in rates(np.tile(state, 3), near))
            (Q, below, above), w = every, state[-1]
            follows = (below - above) / (2 * STEP)
            equations = np.array(w[:, None] * slope.T + np.diag(follows), float)
            if not np.isfinite(equations).all():
                return None
            rest = np.array(Q - w * (beta @ slope), float)
            change = np.linalg.lstsq(equations, rest)[0]
            beta = beta + change
            state = start[:, None] + by[0] @ integral
            faster = (state[-1] - w) / np.max(np.abs(state[-1]))
            if np.max(np.abs([change, faster])) < 1e4 * np.finfo(start.dtype).eps:  # not if NaN
                break
        else:
            return None
    values = fit @ np.vstack([state, beta]).T
    if not np.max(np.abs(values[-2:, :-1])) < RESOLVED * np.max(np.abs(values)):
        return None
    begin = np.append(start, chebval(-1, values[:, -1]))
    times = duration * (nodes + 1) / 2
    gained = fit @ ((state[-1] - start[-1]) / times)

    def at(t: Any) -> np.ndarray:
        """Return the state and beta at times t since the start, (k + 1, ...)."""
        moved = chebval(2 * np.asarray(t) / duration - 1, values).T - chebval(-1, values)
        return (begin + moved).T  # exactly the start at 0

    def pace(t: Any) -> Any:
        """Return w/t, the mean acceleration since the start."""
        return start[-1] / t + chebval(2 * t / duration - 1, gained)

    return at, pace, follows[0] * duration / w[0]


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

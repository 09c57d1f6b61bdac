"""How a point slides while it is so slow that its direction follows the forces: from rest, at the
edge of the friction cone or outside it, and to the next rest.

The direction has the equation w beta' = Q, which is singular at w = 0, and so stiff nearby that no
explicit step begins there. Its smooth solution is found on a whole interval at once, at the nodes
of Chebyshev: the direction by Newton's rule, everything else by Picard's, by integration.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebint, chebval, chebvander

from ..event import zero_of


NODES, STEP = 16, 1e-5
"""Number of nodes; step of beta [rad] of the difference that is its slope."""

STEPS = np.repeat([0, -STEP, STEP], NODES)
"""Amounts to add to beta in three copies of the nodes, one after another: `_swept` makes the copies
by `tile` and takes them apart by `split`, in this order."""

SWEEPS = 40
"""Most corrections of a slide."""

NEAR = 0.1
"""Change of a correction, of beta and relative of w, after which the next ones keep its slopes."""

HALVINGS = 40
"""Most halvings of the duration of a slide."""

RESOLVED = 1e-17
"""Size of the last coefficients of a series that is resolved, relative to the largest."""

BRIEF = 1e-9
"""Part of the duration within which a slide that stops is due to rounding."""

SLAVED = 100
"""Length of a slide in units of the time in which its direction turns into that of the forces, from
which on an explicit integrator needs a multiple of the steps."""


def first_slip(
    rates: Callable, start: np.ndarray, duration: Any, lasts: Callable
) -> tuple[Any, Callable, bool] | None:
    """Compute a slow slide as a series in time.

    Returns
    -------
    tuple
        The duration of the slide; at(t) -> the state at times t since its start; and whether the
        slide stops at its end, or is still slow there. None if nothing begins to slide.

    Parameters
    ----------
    rates
        rates(states) -> the rates of states (k, n), (k, n); of the last of a state, its direction
        beta, an angle from a fixed axis, Q = w beta'. The one before is the speed w (see
        `exits.pushed`).
    start
        The state at the start, (k,). Its beta is about the direction there: the force of rolling
        points against it, or Q = 0.
    duration
        How long at most. It is halved until the series is resolved and the slide `lasts`.
    lasts
        lasts(end) -> whether nothing else happens to the contact until this state.

    Raises
    ------
    ArithmeticError
        There is no such slide: its direction does not follow the forces.
    """
    for _ in range(HALVINGS):
        found = _swept(rates, start, duration)
        if found:
            at, pace, stiffness = found
            times = np.linspace(0, duration, 2 * NODES)
            times[0] = BRIEF * duration  # not 0, where w/t is 0/0
            moves = pace(times) > 0
            if not moves[:2].any():  # only rounding moves it
                return None
            k = 1 + int(np.argmin(moves[1:]))
            stop = None if moves[k] else zero_of(pace, times[k - 1], times[k])
            end = duration if stop is None else stop
            if lasts(at(end)):
                return end, at, stop is not None or stiffness > SLAVED
        duration = duration / 2
    raise ArithmeticError("the direction of a slow slide does not follow the forces")


def _swept(rates: Callable, start: np.ndarray, duration: Any) -> tuple | None:
    """Return the slide over a whole duration, found by repeated corrections at Chebyshev nodes.

    Arguments, and at(t), are as for `first_slip`. It is a tuple: at(t); pace(t), the mean
    acceleration w/t; and the duration in units of the time in which the direction follows the
    forces. None if the corrections do not converge, or the series is not resolved.
    """
    nodes, fit, integral, slope = _matrices(start.dtype)
    integral = integral * duration / 2
    slope = slope * 2 / duration
    state = np.repeat(start[:, None], NODES, 1)
    is_far = True
    with np.errstate(all="ignore"):
        for _ in range(SWEEPS):
            *_, w, beta = state
            near = np.tile(state, 3 if is_far else 1)
            if is_far:
                near[-1] += STEPS
            by = rates(near)
            if is_far:
                _, below, above = np.split(by[-1], 3)
                follows = (below - above) / (2 * STEP)
                equations = np.array(w[:, None] * slope.T + np.diag(follows), float)
                if not np.isfinite(equations).all():
                    return None
                # as floats: numpy inverts no longdoubles, and a correction need not be exact
                inverse = np.linalg.pinv(equations)  # 0 in a plane
            by = by[:, :NODES]
            change = inverse @ np.array(by[-1] - w * (beta @ slope), float)
            state = start[:, None] + by @ integral
            state[-1] = beta + change
            faster = (state[-2] - w) / np.max(np.abs(state[-2]))
            moves = np.max(np.abs([change, faster]))
            if moves < 1e4 * np.finfo(start.dtype).eps:
                break  # not if NaN
            is_far = not moves < NEAR  # if near, the slopes are kept
        else:
            return None
    values = fit @ state.T
    if not np.max(np.abs(values[-2:, :-1])) < RESOLVED * np.max(np.abs(values)):
        return None
    begin = np.append(start[:-1], chebval(-1, values[:, -1]))
    times = duration * (nodes + 1) / 2
    gained = fit @ ((state[-2] - start[-2]) / times)

    def at(t: Any) -> np.ndarray:
        """Return the state at times t since the start, (k, ...); its last number is beta."""
        moved = chebval(2 * np.asarray(t) / duration - 1, values).T - chebval(-1, values)
        return (begin + moved).T  # exactly the start at 0

    def pace(t: Any) -> Any:
        """Return w/t, the mean acceleration since the start."""
        return start[-2] / t + chebval(2 * t / duration - 1, gained)

    return at, pace, follows[0] * duration / w[0]  # node 0 is the last in time


@cache
def _matrices(kind: np.dtype) -> tuple[np.ndarray, ...]:
    """Return the Chebyshev nodes in [-1, 1], falling, and three matrices for values at the nodes.

    `fit` @ values are the coefficients, (order, node). values @ matrix are the integrals from -1
    and the slopes at the nodes, (node of a value, node of a result).
    """
    pi = np.arccos(-kind.type(1))  # in the precision of `kind`
    nodes = np.cos(pi * (np.arange(NODES) + 0.5) / NODES)
    fit = chebvander(nodes, NODES - 1).T * 2 / NODES  # to coefficients, (order, node)
    fit[0] /= 2
    return nodes, fit, chebval(nodes, chebint(fit, lbnd=-1)), chebval(nodes, chebder(fit))


def first_directions(law: Callable) -> Iterator[float]:
    """Yield every direction in which slip can begin from rest: Q = 0, P > 0, N > 0 [rad].

    law(beta) -> (P, Q, N) at an angle beta from a fixed axis, or at an array of them; see
    `exits.pushed`. There is exactly one direction outside the cone. In a plane, where Q is 0
    everywhere, it is 0 or pi.
    """
    grid = np.radians(np.arange(361) + 1 / np.e)  # off round angles, where Q may be exactly 0
    Q = law(grid)[1]
    turns = np.flatnonzero((Q[:-1] > 0) != (Q[1:] > 0))
    # times Q[k], as `zero_of` takes a function that is positive at the lower end
    zeros = (zero_of(lambda beta, k=k: law(beta)[1] * Q[k], *grid[k : k + 2]) for k in turns)
    for beta in zeros if Q.any() else (0.0, np.pi):
        P, _, N = law(beta)
        if P > 0 and N > 0:
            yield beta

"""A body on its ball under exact Coulomb friction, integrated independently of the package.

Newton's and Euler's equations in space; a slide has its speed and angle as variables, and is
integrated by Radau's implicit method.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tilted import cross


class Ball(NamedTuple):
    """A body of revolution; its centre of mass is c below that of the ball, at theta = 0."""

    m: float
    R: float
    c: float
    I1: float
    I3: float
    g: float
    mu: float = 0.0


def turned(u: Any, L: Any, b: Any) -> Any:
    """I^-1 L."""
    return L / b.I1 + (1 / b.I3 - 1 / b.I1) * (u[0] * L[0] + u[1] * L[1] + u[2] * L[2]) * u


def arm(u: Any, b: Any) -> Any:
    a = b.c * u
    a[2] -= b.R
    return a


def accelerated(u: Any, L: Any, F: Any, b: Any) -> Any:
    """Rates of V + omega x a and of L by a force at the contact."""
    omega, torque = turned(u, L, b), cross(arm(u, b), F)
    spin = turned(u, torque - cross(omega, L), b)
    G = F / b.m + cross(spin, arm(u, b)) + b.c * cross(omega, cross(omega, u))
    G[2] -= b.g
    return G, torque


def held(u: Any, L: Any, b: Any) -> Any:
    """The force that keeps the contact at rest."""
    free, K = accelerated(u, L, np.zeros(3), b)[0], np.empty((3, 3))
    for k in range(3):
        K[:, k] = accelerated(u, L, np.eye(3)[k], b)[0] - free
    return np.linalg.solve(K, -free)


def pushed(u: Any, L: Any, beta: float, b: Any) -> Any:
    """Acceleration along beta and across it, normal force and L' of sliding along beta."""
    C, S = np.cos(beta), np.sin(beta)
    push = np.array([-b.mu * C, -b.mu * S, 1.0])
    free = accelerated(u, L, np.zeros(3), b)[0]
    N = free[2] / (free[2] - accelerated(u, L, push, b)[0][2])
    G, torque = accelerated(u, L, N * push, b)
    return C * G[0] + S * G[1], C * G[1] - S * G[0], N, torque


def rates(y: Any, b: Any) -> Any:
    """Of 3hat and L, which may be followed by angle and speed of a slide."""
    u, L, rate = y[:3], y[3:6], np.empty(len(y))
    rate[:3] = cross(L, u) / b.I1
    if len(y) == 6:
        rate[3:] = cross(arm(u, b), held(u, L, b))
    else:
        P, Q, _, torque = pushed(u, L, y[6], b)
        rate[3:6], rate[6], rate[7] = torque, Q / y[7], P
    return rate


def margin(y: Any, b: Any) -> Any:
    """By how much friction exceeds what rolling needs."""
    F = held(y[:3], y[3:6], b)
    return b.mu * F[2] - np.hypot(F[0], F[1])


def first_direction(y: Any, b: Ball) -> Any:
    grid = np.linspace(0.003, 0.003 + 2 * np.pi, 721)
    across = lambda beta: pushed(y[:3], y[3:], beta, b)[1]  # noqa: E731
    signs = np.diff(np.sign([across(beta) for beta in grid]))
    zeros = [brentq(across, *grid[k : k + 2], xtol=1e-15) for k in np.flatnonzero(signs)]
    ways = [(*pushed(y[:3], y[3:], beta, b)[::2][:2], beta) for beta in zeros]
    return max((P, beta) for P, N, beta in ways if N > 0)[1]


def event(function: Any) -> Any:
    def at(t: float, y: Any) -> Any:
        return function(y)

    at.terminal, at.direction = True, -1  # type: ignore[attr-defined]
    return at


def axes(b: Ball, u: Any, L: Any, times: Any, slow: float = 1e-13) -> np.ndarray:
    """3hat at times of a body whose contact is at rest at first; until it lifts off.

    `slow` is the speed [m/s] with which slides begin.
    """
    y, t, until, gives, rows = np.array([*u, *L]), 0.0, times[-1], False, []
    sizes = np.linalg.norm(L) + 1e-3 * b.m * b.R * np.sqrt(b.g * b.R)
    sizes = np.array([1, 1, 1, *[sizes] * 3])
    while t < until:
        h, left = 1e-3 * until, margin(y, b)
        falls = margin(y + h * rates(y + h / 2 * rates(y, b), b), b) < left
        slides = gives or (left < 0 and (left < -1e-11 * b.m * b.g or falls))
        if slides:
            start = np.array([*y, first_direction(y, b), slow])
            stop = event(lambda y: y[7] - slow / 2)
            events = stop, event(lambda y: pushed(y[:3], y[3:6], y[6], b)[2])
            how = {"method": "Radau", "rtol": 1e-12, "first_step": min(1e-14, h)}
            how["atol"] = np.array([*1e-12 * sizes, 1e-12, 1e-17])
        else:
            start, events = y, (event(lambda y: margin(y, b)),)
            how = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14 * sizes, "max_step": 3 * h}
        how |= {"events": events, "dense_output": True}
        s = solve_ivp(lambda t, y: rates(y, b), (t, until), start, **how)
        end = s.t[-1]
        rows += [s.sol(one)[:3] for one in times if t <= one < end or one == end == until]
        t, y, gives = end, s.y[:6, -1], not slides
        if slides and s.status and len(s.t_events[1]):
            break
    return np.array(rows)

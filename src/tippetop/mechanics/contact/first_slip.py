"""How sliding begins from rest: at the edge of the friction cone, and outside of it. [contact 2.4, 2.5]

Directions are angles from the x axis of space; numbers are float or longdouble.
"""

from typing import Any, NamedTuple

import numpy as np

from ..operand import Vector, cos, cross, sin
from .ball import Ball, angular_velocity, arm, axis_rate, bias_vector, contact_acceleration_vector
from .coulomb import along_and_across, reaction_of_rolling_vector, slip_force_vector


NODES, SWEEPS = 12, 16
SPAN = 0.03  # of 1/|omega|: the time over which sliding is begun
DIRECTIONS = 360


class Push(NamedTuple):
    """What sliding in a direction leads to."""

    P: Any  # rate of the speed
    Q: Any  # speed times the rate of the direction
    force: Vector


def push(u: Vector, L: Vector, beta: Any, ball: Ball) -> Push:
    """P, Q and the force of sliding in the direction beta; of numbers or arrays."""
    n = Vector(cos(beta), sin(beta), 0 * beta)
    b = bias_vector(u, L, ball)
    F = slip_force_vector(u, b, n, ball)
    P, Q = along_and_across(contact_acceleration_vector(u, b, F, ball), n)
    return Push(P, Q, F)


def first_direction(u: Vector, L: Vector, ball: Ball) -> Vector | None:
    """The direction in which a contact at rest begins to slide, whose rolling force lies outside the friction cone.

    Parameters
    ----------
    u, L
        3hat, and the angular momentum about the centre of mass.
    ball
        The ball in contact.

    Returns
    -------
    Vector or None
        A horizontal unit vector: there Q = 0, P > 0 and N > 0; None if there is no such direction.
    """
    at = 2 * np.pi * np.arange(DIRECTIONS + 1) / DIRECTIONS
    values = push(u, L, at, ball)
    signs = np.sign(np.asarray(values.Q, float))
    best: tuple[Any, Any] | None = None
    for k in np.flatnonzero(signs[1:] * signs[:-1] <= 0):
        low, high = (at[k] + 0 * u.z, at[k + 1] + 0 * u.z)
        rising = signs[k] <= 0 and signs[k + 1] >= 0
        while (middle := (low + high) / 2) not in (low, high):
            below = (push(u, L, middle, ball).Q < 0) == rising
            low, high = (middle, high) if below else (low, middle)
        found = push(u, L, low, ball)
        if found.P > 0 and found.force.z > 0 and (best is None or best[0] < found.P):
            best = found.P, low
    return None if best is None else Vector(cos(best[1]), sin(best[1]), 0 * best[1])


class Begun(NamedTuple):
    """Sliding that has begun, at Chebyshev's nodes of the time that it took; arrays (NODES,).

    `integrate` gives integrals from the start to each node, by the fraction of that time."""

    u: Vector
    L: Vector
    v: Vector  # of the contact
    time: Any
    integrate: Any


def leave_rolling(u: Vector, L: Vector, ball: Ball, span: float = SPAN) -> Begun:
    """The sliding that begins where rolling needs just the friction that there is, over the time span/|omega|.

    The direction is attracted to Q = w beta' from the first moment on, which no explicit step follows: Picard's sweeps
    on Chebyshev's nodes solve for it at every node, and integrate the rest.
    """
    zero = 0 * u.z
    w = angular_velocity(u, L, ball)
    time = span / np.sqrt(w.x * w.x + w.y * w.y + w.z * w.z)
    x, integrate, differentiate = _chebyshev(np.result_type(zero).type)
    F = reaction_of_rolling_vector(u, bias_vector(u, L, ball), ball)
    n = np.ones_like(x)
    state = np.array([value * n for value in (*u, *L)])
    start, w_nodes, beta_dot = state[:, :1], zero * n, zero * n
    beta = np.arctan2(-F.y, -F.x) * n
    for _ in range(SWEEPS):
        at_u, at_L = Vector(*state[:3]), Vector(*state[3:])
        for _ in range(3):
            beta = beta - _miss(at_u, at_L, beta, w_nodes, beta_dot, ball)
        pushed = push(at_u, at_L, beta, ball)
        rates = np.array([*axis_rate(at_u, at_L, ball), *cross(arm(at_u, ball), pushed.force)])
        state = start + time * (rates @ integrate.T)
        w_nodes = time * (integrate @ pushed.P)
        beta_dot = differentiate @ beta / time
    v = Vector(w_nodes * np.cos(beta), w_nodes * np.sin(beta), zero * n)
    return Begun(Vector(*state[:3]), Vector(*state[3:]), v, time, integrate)


def between_nodes(values: Any, x: Any) -> Any:
    """Values (..., NODES) at Chebyshev's nodes, at other fractions x, (n,), of the time: (..., n)."""
    nodes, *_ = _chebyshev(np.result_type(values).type)
    weights = (-1.0) ** np.arange(NODES)
    weights[[0, -1]] /= 2
    apart = np.asarray(x)[:, None] - nodes[None, :]
    exact = apart == 0
    terms = weights / np.where(exact, 1, apart)
    whole = (values[..., None, :] * terms).sum(axis=-1) / terms.sum(axis=-1)
    at_node = exact.any(axis=1)
    whole[..., at_node] = values[..., exact[at_node].argmax(axis=1)]
    return whole


def _miss(u: Vector, L: Vector, beta: Any, w: Any, beta_dot: Any, ball: Ball) -> Any:
    """Newton's correction of Q(beta) = w beta'."""
    small = 1e-5
    slope = (push(u, L, beta + small, ball).Q - push(u, L, beta - small, ball).Q) / (2 * small)
    return (push(u, L, beta, ball).Q - w * beta_dot) / slope


def _chebyshev(number: Any) -> tuple[Any, Any, Any]:
    """Chebyshev's nodes in [0, 1], and the matrices that integrate from 0, and differentiate, values at them."""
    k = np.arange(NODES).astype(number)
    x = (1 - np.cos(np.pi * k / (NODES - 1))) / 2
    weights = (-1.0) ** np.arange(NODES)
    weights[[0, -1]] /= 2
    apart = x[:, None] - x[None, :] + np.eye(NODES, dtype=number)
    differentiate = weights[None, :] / weights[:, None] / apart
    np.fill_diagonal(differentiate, 0)
    np.fill_diagonal(differentiate, -differentiate.sum(axis=1))
    basis = np.polynomial.chebyshev
    values = basis.chebvander(2 * x.astype(float) - 1, NODES - 1)
    integrals = np.array(
        [basis.chebval(2 * x.astype(float) - 1, basis.chebint(row, lbnd=-1)) / 2 for row in np.eye(NODES)]
    )
    return x, (integrals.T @ np.linalg.inv(values)).astype(number), differentiate

"""How a slide begins from rest, with the integrals that pass meanwhile."""

from typing import Any

import numpy as np

from ...mechanics.contact.body import Touch, angular_velocity, arm, axis_rate
from ...mechanics.contact.coulomb import reaction_of_rolling_vector, slip_motion
from ...mechanics.contact.first_slip import FirstSlip, first_directions, first_slip
from ...mechanics.contact.phases.legs import Kind
from ...mechanics.contact.response import bias_vector
from ...mechanics.operand import Vector, cross


SPAN = 0.03  # of 1/|omega|: the time over which sliding begins
SLOW = 0.5  # of the time in which gravity swings the body: that of one that hardly turns
MOST_HALVINGS = 10


def pushed(u: Vector, L: Vector, beta: Any, b: Touch) -> tuple[Vector, Any, Any]:
    """The force of sliding in the direction beta, and P, Q; of numbers or arrays."""
    return slip_motion(u, L, Vector(np.cos(beta), np.sin(beta), 0 * beta), b)


def direction(u: Vector, L: Vector, b: Touch) -> Vector | None:
    """The direction in which a contact at rest begins to slide, whose rolling force lies outside the friction cone;
    None if there is none."""

    def law(beta: np.ndarray) -> tuple[Any, Any, Any]:
        F, P, Q = pushed(u, L, beta, b)
        return P, Q, F.z

    angles = first_directions(law)
    if not len(angles):
        return None
    return Vector(np.cos(angles[0]), np.sin(angles[0]), 0 * u.z)


def slide_from_cone(kind: Kind, b: Touch, u: Vector, L: Vector, carried: np.ndarray, rates_of: Any) -> FirstSlip:
    """The first moments of a slide that begins at the edge of the friction cone.

    Parameters
    ----------
    kind, b
        The slide, and the body seen from the ball that slides.
    u, L
        3hat and the angular momentum.
    carried
        The integrals (k,), not scaled.
    rates_of
        rates_of(q, carried) -> rates of the integrals, (k, n).

    Returns
    -------
    FirstSlip
        Its state is u, L and the integrals.
    """

    sliding: Any = kind.sliding

    def rates(state: np.ndarray, w: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, Any, Any]:
        at_u, at_L = Vector(*state[:3]), Vector(*state[3:6])
        F, P, Q = pushed(at_u, at_L, beta, b)
        moved = [*axis_rate(at_u, at_L, b), *cross(arm(at_u, b), F)]
        return np.concatenate([np.array(moved), rates_of(sliding(at_u, at_L, w, beta, b), state[6:])]), P, Q

    def turning(state: np.ndarray, beta: np.ndarray) -> Any:
        return pushed(Vector(*state[:3]), Vector(*state[3:6]), beta, b)[2]

    F = reaction_of_rolling_vector(u, bias_vector(u, L, b), b)
    omega = angular_velocity(u, L, b)
    swing = np.sqrt(b.I1 / (b.m * b.g * b.R))
    duration = min(SPAN / np.sqrt(omega.x * omega.x + omega.y * omega.y + omega.z * omega.z), SLOW * swing)
    state = np.array([*u, *L, *carried])
    for _ in range(MOST_HALVINGS):  # short enough for nothing else to happen to the contact
        first = first_slip(rates, turning, state, np.arctan2(-F.y, -F.x), duration)
        end = states(kind, b, first, first.time[-1:])
        last = type(kind.form.units)(*end[:, 0][: len(kind.form.units)])
        height = getattr(last, "uz", getattr(last, "z", 0))
        if float(kind.says(last, b).force.z) > 0 and float(b.clearance + b.lever * height) > 0:
            break
        duration = duration / 2
    return first


def states(kind: Kind, body: Touch, first: FirstSlip, t: np.ndarray) -> np.ndarray:
    """The states (variables, n) of the slide at times t since its beginning; then its integrals, not scaled."""
    state, w, beta = first.at(t)
    sliding: Any = kind.sliding
    q = sliding(Vector(*state[:3]), Vector(*state[3:6]), w, beta, body)
    return np.array([*(np.broadcast_to(x, w.shape) for x in q), *state[6:]])

"""How slip begins at the edge of the cone and outside it: against integrations, expansions and a
second precision.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import response
from tippetop.mechanics.contact.body import Touch, Turning
from tippetop.mechanics.contact.contact_phases import smooth_friction
from tippetop.mechanics.contact.first_slip import first_directions, first_slip
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector, cross


BODY = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.3))


class Edge(NamedTuple):
    """A rolling state on the edge of its cone, which it leaves."""

    ball: Touch
    state: np.ndarray  # 3hat, L, x and y of the centre of mass
    beta: float
    omega: float


def turning(state: Any) -> Turning:
    """3hat and L."""
    return Turning(Vector(*state[:3]), Vector(*state[3:6]))


def slid(x: Turning, n: Vector, ball: Touch) -> tuple:
    """P, Q and the force of sliding along n."""
    F, torque = response.sliding(x, smooth_friction, n, ball)
    G = response.contact_acceleration(x, F, torque, ball)
    Q, P = response.across_and_along(G, n)
    return P, Q, F


def rate(x: Turning, F: Vector, slip: Vector, ball: Touch) -> np.ndarray:
    """Rates of 3hat, L and the place of the centre of mass under a force."""
    V = contact.centre_velocity(x, slip, ball)
    return np.array([*contact.axis_rate(x, ball), *cross(contact.arm(x.u, ball), F), V.x, V.y])


def slip_rates(ball: Touch) -> Callable:
    """rates(state, beta) of 3hat, L, the place of the centre of mass and the speed of slip."""

    def rates(state: np.ndarray, beta: np.ndarray) -> tuple:
        x, n, w = turning(state), Vector(np.cos(beta), np.sin(beta), 0), state[-1]
        P, Q, F = slid(x, n, ball)
        return np.array([*rate(x, F, Vector(w * n.x, w * n.y, 0), ball), P]), Q

    return rates


def slipped(edge: "Edge") -> Any:
    """Duration and motion of the first slip from an edge, and whether it is slow; None inside."""
    start = np.append(edge.state, 0.0).astype(np.longdouble)
    span = 0.03 / edge.omega
    return first_slip(slip_rates(edge.ball), start, edge.beta, span, lambda end: True)


def rolling_rate(state: np.ndarray, ball: Touch) -> np.ndarray:
    return rate(turning(state), reaction(state, ball), Vector(0, 0, 0), ball)


def reaction(state: np.ndarray, ball: Touch) -> Vector:
    return response.resting(turning(state), ball)[0]


def edges(rng: np.random.Generator, count: int) -> list[Edge]:
    """Random rolling states; mu is such that they are on the edge, and time is reversed if they
    would enter.
    """
    found: list[Edge] = []
    while len(found) < count:
        u = rng.normal(0, 1, 3)
        u /= np.sqrt(u @ u)
        state = np.concatenate([u, 3e-6 * rng.normal(0, 60, 3), [0.1, 0.2]])
        for sign in (1, -1):
            state = np.concatenate([state[:3], sign * state[3:6], state[6:]])
            F = reaction(state, BODY)
            mu = np.hypot(F.x, F.y) / F.z
            ball = BODY._replace(friction=SetValued._make((mu,)))
            later = response.cone(reaction(state + 1e-7 * rolling_rate(state, ball), ball), ball)
            if F.z > 0.05 and 0.05 < mu < 0.8 and later < 0:
                omega = contact.angular_velocity(turning(state), ball)
                found.append(
                    Edge(
                        ball,
                        state,
                        float(np.arctan2(-F.y, -F.x)),
                        float(np.sqrt(np.dot(omega, omega))),
                    )
                )
                break
    return found


def test_the_start_goes_on_as_an_integration_of_the_same_equations(
    rng: np.random.Generator,
) -> None:
    for edge in edges(rng, 3):
        rates = slip_rates(edge.ball)
        duration, at, _ = slipped(edge)

        def rate(t: float, y: Any, rates: Callable = rates) -> Any:
            state_rate, Q = rates(y[:-1], y[-1])
            return np.array([*state_rate, Q / y[-2]])

        times = 0.7 * duration, duration
        begin, last = at(times).T
        end = solve_ivp(rate, times, begin, "DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
        assert duration == 0.03 / edge.omega
        size = np.array([1, 1, 1, 1e-3, 1e-3, 1e-3, 1, 1])
        assert np.max(np.abs(last[:-2] - end[:-2]) / size) < 2e-15
        assert last[-2] == pytest.approx(end[-2], rel=1e-10)
        assert last[-1] == pytest.approx(end[-1], abs=1e-10)
        start = np.array([*edge.state, 0, edge.beta])
        np.testing.assert_allclose(at(0.0), start, rtol=1e-12, atol=1e-17)


def test_slip_begins_where_its_rate_is_zero_by_rounding(rng: np.random.Generator) -> None:
    for edge in edges(rng, 15):
        duration, at, _ = slipped(edge)
        assert np.all(at(duration * np.linspace(0.01, 1, 12))[-2] > 0)


def test_inside_the_cone_nothing_begins_to_slip(rng: np.random.Generator) -> None:
    (edge,) = edges(rng, 1)
    state = np.concatenate([edge.state[:3], -edge.state[3:6], edge.state[6:]])  # it comes in
    F = reaction(state, edge.ball)
    assert slipped(edge._replace(state=state, beta=float(np.arctan2(-F.y, -F.x)))) is None


def test_outside_the_cone_there_is_one_first_direction_and_inside_none(
    rng: np.random.Generator,
) -> None:
    counts = {True: 0, False: 0}
    for _ in range(60):
        u = rng.normal(0, 1, 3)
        x = turning([*(u / np.sqrt(u @ u)), *(3e-6 * rng.normal(0, 60, 3))])
        ball = BODY._replace(friction=SetValued(rng.uniform(0.05, 1.4)))
        F = response.resting(x, ball)[0]
        if response.bias_vector(x, ball).z > 0:
            continue  # the contact opens

        def law(beta: np.ndarray, x: Turning = x, ball: Touch = ball) -> tuple:
            P, Q, F = slid(x, Vector(np.cos(beta), np.sin(beta), 0), ball)
            return P, Q, F.z

        rolls = bool(F.z > 0 and response.cone(F, ball) >= 0)
        found = [*first_directions(law)]
        assert len(found) == (0 if rolls else 1)
        counts[rolls] += 1
        for beta in found:
            P, Q, N = law(np.array([beta, beta + 1e-14, beta - 1e-14]))
            assert Q[1] * Q[2] <= 0 or abs(Q[0]) < 1e-12
            assert P[0] > 0
            assert N[0] > 0
    assert min(counts.values()) > 5

"""Mobility, bias and reactions at a contact, against the equations of Newton and Euler solved as
linear ones.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
import pytest

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import response
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector


DIGITS = 40


class State(NamedTuple):
    """A ball in contact or in the air, everything of 40 digits: Euler angles, and the same in space
    axes as columns.
    """

    ball: Touch
    theta: Any
    phi: Any
    rates: tuple  # theta', phi', omega_3
    e: Any  # unit vectors
    t: Any
    u: Any
    omega: Any
    n: Any  # a slip direction


def column(*x: Any) -> Any:
    return mp.matrix([mp.mpf(y) for y in x])


def cross(a: Any, b: Any) -> Any:
    return column(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Any, b: Any) -> Any:
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def vector(a: Any) -> Vector:
    return Vector(*a)


Z = column(0, 0, 1)


def axes(theta: Any, phi: Any, rates: Any) -> tuple:
    """Return e, t, 3hat and the angular velocity of Euler angles and theta', phi', omega_3."""
    e, t = column(mp.cos(phi), mp.sin(phi), 0), column(-mp.sin(phi), mp.cos(phi), 0)
    u = mp.sin(theta) * e + mp.cos(theta) * Z
    first = mp.cos(theta) * e - mp.sin(theta) * Z
    return e, t, u, -rates[1] * mp.sin(theta) * first + rates[0] * t + rates[2] * u


def random_state(rng: np.random.Generator, theta: float | None = None) -> State:
    """A body of any sensible shape: stems have an offset greater than the radius, others a negative
    one.
    """
    low, high = (0.5, 0.1, -2, 0.2, 0.2, 9.82), (2, 1, 2, 1, 1, 9.82)
    ball = Touch(*map(mp.mpf, rng.uniform(low, high)), SetValued(mp.mpf(0.3)))
    theta = mp.mpf(rng.uniform(0.1, 3)) if theta is None else mp.mpf(theta)
    phi, direction = map(mp.mpf, rng.uniform(-3, 3, 2))
    rates = tuple(map(mp.mpf, rng.normal(0, 3, 3)))
    n = column(mp.cos(direction), mp.sin(direction), 0)
    return State(ball, theta, phi, rates, *axes(theta, phi, rates), n)


def inertia(x: State) -> Any:
    return x.ball.I1 * mp.eye(3) + (x.ball.I3 - x.ball.I1) * x.u * x.u.T


def momentum(x: State) -> Any:
    return inertia(x) * x.omega


def acceleration(x: State, F: Any, torque: Any = None) -> Any:
    """Of the contact point with the force F there and a torque, by the equations of Newton and
    Euler.
    """
    a = x.ball.c * x.u - x.ball.R * Z
    turn = mp.lu_solve(
        inertia(x), cross(a, F) + (torque or column(0, 0, 0)) - cross(x.omega, momentum(x))
    )
    return (
        F / x.ball.m
        - x.ball.g * Z
        + cross(turn, a)
        + cross(x.omega, x.ball.c * cross(x.omega, x.u))
    )


def forced(x: State, conditions: Callable) -> Any:
    """The force for which conditions(F, acceleration), which are linear, vanish: from their values
    at four forces.
    """
    at = [
        conditions(F, acceleration(x, F))
        for F in (column(0, 0, 0), *(mp.eye(3)[:, i] for i in range(3)))
    ]
    matrix = mp.matrix(3, 3)
    for i in range(3):
        matrix[:, i] = at[i + 1] - at[0]
    return mp.lu_solve(matrix, -at[0])


def turning(x: State) -> contact.Turning:
    """3hat and L."""
    return contact.Turning(vector(x.u), vector(momentum(x)))


def slipping(x: State) -> Any:
    """Rising keeps v_n = 0; friction is -mu N n."""
    mu = x.ball.friction.mu
    return forced(
        x, lambda F, G: column(G[2], F[0] + mu * F[2] * x.n[0], F[1] + mu * F[2] * x.n[1])
    )


def rolling(x: State) -> Any:
    return forced(x, lambda F, G: G)


def assert_close(found: Any, expected: Any, tolerance: float = 1e-33) -> None:
    size = max(1, *(abs(y) for y in expected))
    for a, b in zip(found, expected, strict=True):
        assert abs(a - b) < tolerance * size, (found, expected)


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(DIGITS):
        yield


@pytest.fixture
def states(rng: np.random.Generator) -> list[State]:
    with mp.workdps(DIGITS):
        return [random_state(rng) for _ in range(20)]


@pytest.fixture
def every_state(states: list[State], rng: np.random.Generator) -> list[State]:
    """Also theta = 0, and so near to pi that the formulas by angles would lose all digits."""
    with mp.workdps(DIGITS):
        return states + [
            random_state(rng, theta)
            for theta in (0, "3.14159265358979323846264338327950288")
            for _ in range(4)
        ]


def test_the_bias_is_that_of_a_free_body_in_euler_angles(states: list[State]) -> None:
    """Differences of the velocity of the contact point of a body that falls and turns freely."""
    for x in states:
        theta_dot, phi_dot, omega3 = x.rates
        s, z, spin = mp.sin(x.theta), mp.cos(x.theta), x.ball.I3 / x.ball.I1 * omega3
        theta_ddot = (phi_dot * z - spin) * phi_dot * s
        phi_ddot = (spin - 2 * phi_dot * z) * theta_dot / s

        def velocity(time: Any, x: State = x, changes: tuple = (theta_ddot, phi_ddot, 0)) -> Any:
            rates = [rate + time * change for rate, change in zip(x.rates, changes, strict=True)]
            middle = [(old + new) / 2 for old, new in zip(x.rates, rates, strict=True)]
            theta, phi = x.theta + time * middle[0], x.phi + time * middle[1]
            _, _, u, omega = axes(theta, phi, rates)
            return cross(omega, x.ball.c * u - x.ball.R * Z) - x.ball.g * time * Z

        found = response.bias_vector(turning(x), x.ball)
        step = mp.mpf("1e-12")
        assert_close(found, (velocity(step) - velocity(-step)) / (2 * step), 1e-20)


def test_the_vector_forms_are_those_of_newton_and_euler_at_the_poles_too(
    every_state: list[State],
) -> None:
    for x in every_state:
        u, b = vector(x.u), response.bias_vector(turning(x), x.ball)
        assert_close(b, acceleration(x, column(0, 0, 0)))
        for force in (column(1, 0, 0), column(0, 1, 0), column(1, -2, 3)):
            F = vector(force)
            torque = column(0.03, 0.02, -0.05)
            found = response.contact_acceleration(turning(x), F, vector(torque), x.ball)
            assert_close(found, acceleration(x, force, torque))
            there_and_back = response.mobility_inverse_times(
                u, response.gains(u, F, Vector(0, 0, 0), x.ball)[0], x.ball
            )
            assert_close(there_and_back, force)


def test_velocities_of_the_contact_point(every_state: list[State]) -> None:
    for x in every_state:
        V = column(0.1, 0.2, -0.3)
        expected = V + cross(x.omega, x.ball.c * x.u - x.ball.R * Z)
        v, omega = contact.velocities(contact.Moving(*turning(x), vector(V), 0), x.ball)
        assert_close(v, expected)
        assert_close(omega, x.omega)
        assert_close(contact.centre_velocity(turning(x), v, x.ball), V)


def test_the_forces_of_slip_are_those_of_newton_and_euler(every_state: list[State]) -> None:
    for x in every_state:
        F = slipping(x)
        per = Vector(*(F / F[2])), Vector(0, 0, 0)
        found, torque = response.sliding(turning(x), lambda *of, per=per: per, x.n, x.ball)
        assert_close(found, F)
        assert_close(torque, column(0, 0, 0))
        G = response.contact_acceleration(turning(x), found, torque, x.ball)
        across = dot(cross(Z, x.n), acceleration(x, F))
        assert_close(
            response.across_and_along(G, vector(x.n)), (across, dot(x.n, acceleration(x, F)))
        )


def test_the_normal_force_with_a_torque_keeps_the_contact_closed(every_state: list[State]) -> None:
    for x in every_state:
        force, tau, u = column(-0.2, 0.1, 1), column(0.03, 0.02, -0.05), vector(x.u)
        per = vector(force), vector(tau)
        made = response.sliding(turning(x), lambda *of, per=per: per, u, x.ball)
        N = made[0].z
        assert_close(made[0], N * force)
        G = acceleration(x, N * force, N * tau)
        assert_close([G[2]], [0])
        given, _ = response.gains(u, Vector(0, 0, 0), vector(tau), x.ball)
        assert_close(
            given, acceleration(x, column(0, 0, 0), tau) - acceleration(x, column(0, 0, 0))
        )


def test_the_forces_of_rolling_are_those_of_newton_and_euler(every_state: list[State]) -> None:
    for x in every_state:
        F = rolling(x)
        assert_close(response.resting(turning(x), x.ball)[0], F)
        assert_close(
            [response.cone(vector(F), x.ball)],
            [(x.ball.friction.mu * F[2]) ** 2 - F[0] ** 2 - F[1] ** 2],
        )

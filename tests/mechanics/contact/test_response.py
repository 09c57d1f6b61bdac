"""Mobility, bias and reactions at a contact, against the equations of Newton and Euler."""

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
    """A ball in contact or in the air, everything of 40 digits, in space axes."""

    ball: Touch
    u: Any  # 3hat
    omega: Any
    n: Any  # a horizontal direction


def column(*x: Any) -> Any:
    """Return an array of numbers of 40 digits."""
    return np.array([mp.mpf(y) for y in x])


Z = column(0, 0, 1)


def random_state(rng: np.random.Generator, theta: Any = None) -> State:
    """A body of any sensible shape: stems have an offset greater than the radius, others a negative
    one.
    """
    low, high = (0.5, 0.1, -2, 0.2, 0.2, 9.82), (2, 1, 2, 1, 1, 9.82)
    ball = Touch(*map(mp.mpf, rng.uniform(low, high)), SetValued(mp.mpf(0.3)))
    theta = mp.mpf(rng.uniform(0.1, 3) if theta is None else theta)
    level = [column(mp.cos(phi), mp.sin(phi), 0) for phi in rng.uniform(-3, 3, 2)]
    u = mp.sin(theta) * level[0] + mp.cos(theta) * Z
    return State(ball, u, column(*rng.normal(0, 3, 3)), level[1])


def inertia(x: State) -> Any:
    return x.ball.I1 * np.eye(3, dtype=int) + (x.ball.I3 - x.ball.I1) * np.outer(x.u, x.u)


def momentum(x: State) -> Any:
    return inertia(x) @ x.omega


def acceleration(x: State, F: Any, torque: Any = 0) -> Any:
    """Of the contact point with the force F there and a torque, by the equations of Newton and
    Euler.
    """
    a = x.ball.c * x.u - x.ball.R * Z
    torques = np.cross(a, F) + torque - np.cross(x.omega, momentum(x))
    turn = column(*mp.lu_solve(mp.matrix(inertia(x)), mp.matrix(torques)))
    return (
        F / x.ball.m
        - x.ball.g * Z
        + np.cross(turn, a)
        + np.cross(x.omega, x.ball.c * np.cross(x.omega, x.u))
    )


def turning(x: State) -> contact.Turning:
    """3hat and L."""
    return contact.Turning(Vector(*x.u), Vector(*momentum(x)))


def assert_close(found: Any, expected: Any, tolerance: float = 1e-33) -> None:
    size = max(1, *(abs(y) for y in expected))
    for a, b in zip(found, expected, strict=True):
        assert abs(a - b) < tolerance * size, (found, expected)


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(DIGITS):
        yield


@pytest.fixture
def every_state(rng: np.random.Generator) -> list[State]:
    """Also theta = 0, and so near to pi that formulas by angles would lose all digits."""
    poles = (0, "3.14159265358979323846264338327950288")
    with mp.workdps(DIGITS):
        return [random_state(rng, theta) for theta in [*[None] * 20, *poles * 4]]


def test_the_vector_forms_are_those_of_newton_and_euler_at_the_poles_too(
    every_state: list[State],
) -> None:
    for x in every_state:
        u, b = Vector(*x.u), response.bias_vector(turning(x), x.ball)
        assert_close(b, acceleration(x, column(0, 0, 0)))
        for force in (column(1, 0, 0), column(0, 1, 0), column(1, -2, 3)):
            F = Vector(*force)
            torque = column(0.03, 0.02, -0.05)
            found = response.contact_acceleration(turning(x), F, Vector(*torque), x.ball)
            assert_close(found, acceleration(x, force, torque))
            there_and_back = response.mobility_inverse_times(
                u, response.gains(u, F, Vector(0, 0, 0), x.ball)[0], x.ball
            )
            assert_close(there_and_back, force)


def test_velocities_of_the_contact_point(every_state: list[State]) -> None:
    for x in every_state:
        V = column(0.1, 0.2, -0.3)
        expected = V + np.cross(x.omega, x.ball.c * x.u - x.ball.R * Z)
        v, omega = contact.velocities(contact.Moving(*turning(x), Vector(*V), 0), x.ball)
        assert_close(v, expected)
        assert_close(omega, x.omega)
        assert_close(contact.centre_velocity(turning(x), v, x.ball), V)


def test_a_contact_that_rolls_stays_at_rest(every_state: list[State]) -> None:
    for x in every_state:
        F = column(*response.resting(turning(x), x.ball)[0])
        assert_close(acceleration(x, F), column(0, 0, 0))
        room = (x.ball.friction.mu * F[2]) ** 2 - F[0] ** 2 - F[1] ** 2
        assert_close([response.cone(Vector(*F), x.ball)], [room])

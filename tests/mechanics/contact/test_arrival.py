"""What arrives at an impact, and the body after it: against vectors, matrices and the equations of
Newton and Euler.
"""

import numpy as np
import pytest

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.impact import after_impact, arrival
from tippetop.mechanics.contact.response import mobility
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector


Z = np.array([0.0, 0.0, 1.0])
AXES = {
    "slanted": None,
    "upright, sliding": (0.0, 0.0, 1.0),
    "inverted, sliding": (0.0, 0.0, -1.0),
    "upright, falling": (0.0, 0.0, 1.0),
}


class Body:
    """A random ball: its axis, tensor of inertia, L, the velocity of its centre of mass, and the
    arm of its contact.
    """

    def __init__(self, axis: str, rng: np.random.Generator):
        I1, I3 = rng.uniform(0.3, 0.6, 2)
        self.ball = Touch(
            *rng.uniform((0.5, 0.5, -1.5), (2, 1.5, 1.5)), I1, I3, 9.8, SetValued(0.3)
        )
        u = rng.normal(size=3)
        self.u = np.array(AXES[axis]) if AXES[axis] else u / np.linalg.norm(u)
        self.inertia = I1 * np.eye(3) + (I3 - I1) * np.outer(self.u, self.u)
        self.L, self.V = rng.normal(size=3), rng.normal(size=3)
        if axis.endswith("falling"):
            self.L, self.V = self.L * Z, self.V * Z
        self.a = self.ball.c * self.u - self.ball.R * Z

    def omega(self, L: np.ndarray) -> np.ndarray:
        """Angular velocity."""
        return np.linalg.solve(self.inertia, L)

    def of_contact(self, L: np.ndarray, V: np.ndarray) -> np.ndarray:
        """Velocity of the contact point."""
        return V + np.cross(self.omega(L), self.a)

    def energy(self, L: np.ndarray, V: np.ndarray) -> float:
        """That of motion."""
        return float(self.ball.m * V @ V + self.omega(L) @ L) / 2


@pytest.fixture(params=AXES)
def body(request: pytest.FixtureRequest, rng: np.random.Generator) -> Body:
    return Body(request.param, rng)


def test_what_arrives_is_the_velocity_of_the_contact_in_its_frame(body: Body) -> None:
    a = arrival(Vector(*body.u), Vector(*body.L), Vector(*body.V), body.ball)
    v, e = body.of_contact(body.L, body.V), np.array(a.e)
    assert np.array(a.v) == pytest.approx(v, rel=1e-12, abs=1e-14)
    assert (np.linalg.norm(e), e[2]) == pytest.approx((1, 0), abs=1e-15)
    leads = next((x for x in (body.u, v) if np.hypot(x[0], x[1]) > 1e-9), e)
    assert e @ leads == pytest.approx(np.hypot(leads[0], leads[1]), rel=1e-12)
    assert (a.along, a.sideways) == pytest.approx((v @ e, v @ np.cross(Z, e)), rel=1e-12, abs=1e-14)
    assert a.s == pytest.approx(np.hypot(body.u[0], body.u[1]), rel=1e-12)
    assert mobility(a.s, body.u[2], body.ball) == a.K


def test_an_impulse_and_a_twist_change_the_body_so(body: Body, rng: np.random.Generator) -> None:
    u, L, V = Vector(*body.u), Vector(*body.L), Vector(*body.V)
    a = arrival(u, L, V, body.ball)
    components = rng.normal(size=(2, 3))
    made = after_impact(u, L, V, a, *(Vector(*x) for x in components), body.ball)
    p, twist = components @ [a.e, np.cross(Z, a.e), Z]
    L_end, V_end = body.L + np.cross(body.a, p) + twist, body.V + p / body.ball.m
    assert np.array(made.p) == pytest.approx(p, rel=1e-12, abs=1e-14)
    assert np.array(made.L) == pytest.approx(L_end, rel=1e-12, abs=1e-14)
    assert np.array(made.velocity) == pytest.approx(V_end, rel=1e-12, abs=1e-14)
    assert np.array(made.v) == pytest.approx(body.of_contact(L_end, V_end), rel=1e-12, abs=1e-13)
    assert made.gained == pytest.approx(
        body.energy(L_end, V_end) - body.energy(body.L, body.V), rel=1e-12
    )

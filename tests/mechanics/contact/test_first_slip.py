"""The directions in which slip may begin; slides that begin are followed in
attacks/test_edges_of_cones.py.
"""

from typing import Any

import numpy as np
from examples import GLIDING

from tippetop.mechanics.contact import response
from tippetop.mechanics.contact.body import Touch, Turning
from tippetop.mechanics.contact.contact_phases import smooth_friction
from tippetop.mechanics.contact.first_slip import first_directions
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector


def turning(state: Any) -> Turning:
    """3hat and L."""
    return Turning(Vector(*state[:3]), Vector(*state[3:6]))


def slid(x: Turning, n: Vector, ball: Touch) -> tuple:
    """P, Q and the force of sliding along n."""
    F, torque = response.sliding(x, smooth_friction, n, ball)
    G = response.contact_acceleration(x, F, torque, ball)
    Q, P = response.across_and_along(G, n)
    return P, Q, F


def test_outside_the_cone_there_is_one_first_direction_and_inside_none(
    rng: np.random.Generator,
) -> None:
    counts = {True: 0, False: 0}
    for _ in range(60):
        u = rng.normal(0, 1, 3)
        x = turning([*(u / np.sqrt(u @ u)), *(3e-6 * rng.normal(0, 60, 3))])
        ball = GLIDING._replace(friction=SetValued(rng.uniform(0.05, 1.4)))
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

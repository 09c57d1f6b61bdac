"""What a row says of a body, and the row that angles make: against vectors and the tensor of
inertia.
"""

import numpy as np
import pytest
from touching import inertia

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.rows import Row, row_scalars
from tippetop.mechanics.friction import Viscous


Z = np.array([0.0, 0.0, 1.0])


def body(rng: np.random.Generator) -> Touch:
    return Touch(*rng.uniform(0.5, 2.0, 6), Viscous(0.3), 0.0, 0.0)


def contact_velocity(q: Row, b: Touch) -> np.ndarray:
    """Of the lowest point of the ball that the row names."""
    u, L = np.array([q.ux, q.uy, q.uz]), np.array([q.Lx, q.Ly, q.Lz])
    omega = np.linalg.solve(inertia(u, b), L)
    return np.array([q.rx_dot, q.ry_dot, q.rz_dot]) + np.cross(omega, q.offset * u - q.radius * Z)


def test_scalars_of_a_row_are_those_of_vectors(rng: np.random.Generator) -> None:
    for _ in range(20):
        b, q = body(rng), Row._make(rng.uniform(-1, 1, len(Row._fields)))
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        q = q._replace(ux=u[0], uy=u[1], uz=u[2])
        found, v = row_scalars(q, b), contact_velocity(q, b)
        given = (found.v_u, found.v_n, found.v2, found.rise, found.gap, found.power)
        wanted = (
            u[:2] @ v[:2],
            np.cross(u, v)[2],
            v[:2] @ v[:2],
            v[2],
            q.height - (q.radius * Z - q.offset * u)[2],
            q.drilled - v[:2] @ [q.Fx, q.Fy],
        )
        assert given == pytest.approx(wanted, rel=1e-11, abs=1e-13)

"""The cylinder under exact Coulomb friction: its formulas."""

import numpy as np
import pytest

from tippetop.mechanics.contact import planar
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import SetValued


BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.1))


def test_slip_is_what_the_torque_and_the_constraint_ask_for(rng: np.random.Generator) -> None:
    """In lengths and moments of a free body: m x'' = F_x, m s_z'' = N - m g, I theta''
    = (a x F)_y.
    """
    for sigma in (-1, 1):
        theta, theta_dot = rng.uniform(-7, 7), rng.normal(0, 20)
        s, z = np.sin(theta), np.cos(theta)
        made = planar.signed(type(planar.SIGNED)(s, z, theta_dot, 0.0, sigma), BALL)
        (F_x, _, N), turn, nu_dot = made.force, made.turn.y / BALL.I1, sigma * made.P
        lever, H = BALL.c * s, BALL.R - BALL.c * z
        assert F_x == -0.1 * sigma * N
        assert pytest.approx(-(lever * N + H * F_x), rel=1e-12) == BALL.I1 * turn
        height_dot2 = BALL.c * (z * theta_dot**2 + s * turn)
        assert pytest.approx(BALL.m * (BALL.g + height_dot2), rel=1e-12) == N
        assert nu_dot == pytest.approx(F_x / BALL.m - H * turn - lever * theta_dot**2, rel=1e-12)

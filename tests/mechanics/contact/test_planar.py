"""The cylinder under exact Coulomb friction: its formulas, and the states of the reference run."""

import json
from pathlib import Path

import numpy as np
import pytest

from tippetop.mechanics.contact import planar
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import SetValued


CASE = json.loads((Path(__file__).parents[2] / "reference" / "caseC6_cylinder_coulomb.json").read_text())
BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.1))


def test_slip_is_what_the_torque_and_the_constraint_ask_for(rng: np.random.Generator) -> None:
    """In lengths and moments of a free body: m x'' = F_x, m s_z'' = N - m g, I theta'' = (a x F)_y."""
    for sigma in (-1, 1):
        theta, theta_dot = rng.uniform(-7, 7), rng.normal(0, 20)
        s, z = np.sin(theta), np.cos(theta)
        F_x, N, turn, nu_dot = planar.slip(s, z, theta_dot, sigma, BALL)
        lever, H = BALL.c * s, BALL.R - BALL.c * z
        assert F_x == -0.1 * sigma * N
        assert pytest.approx(-(lever * N + H * F_x), rel=1e-12) == BALL.I1 * turn
        height_dot2 = BALL.c * (z * theta_dot**2 + s * turn)
        assert pytest.approx(BALL.m * (BALL.g + height_dot2), rel=1e-12) == N
        assert nu_dot == pytest.approx(F_x / BALL.m - H * turn - lever * theta_dot**2, rel=1e-12)


def test_rolling_keeps_the_contact_at_rest(rng: np.random.Generator) -> None:
    for theta, theta_dot in zip(rng.uniform(-7, 7, 20), rng.normal(0, 20, 20), strict=True):
        s, z = np.sin(theta), np.cos(theta)
        F_x, N, turn, nu_dot = planar.roll(s, z, theta_dot, BALL)
        lever, H = BALL.c * s, BALL.R - BALL.c * z
        assert nu_dot == pytest.approx(0, abs=1e-12 * (1 + theta_dot**2))
        assert pytest.approx(-(lever * N + H * F_x), rel=1e-10, abs=1e-12) == BALL.I1 * turn
        assert pytest.approx(BALL.m * (H * turn + lever * theta_dot**2), rel=1e-10, abs=1e-12) == F_x


def test_the_reference_has_these_normal_forces() -> None:
    slip = [i for i, phase in enumerate(CASE["phase"]) if phase == "slip" and CASE["g_n"][i]]
    for i in slip:
        theta, theta_dot, nu, N = (float(CASE[k][i]) for k in ("theta_unwrapped", "thetadot", "nu_x", "g_n"))
        made = planar.slip(np.sin(theta), np.cos(theta), theta_dot, np.sign(nu), BALL)
        assert pytest.approx(N, rel=1e-13) == made.N
    assert len(slip) > 10
    at = CASE["phase"].index("roll")
    theta, theta_dot, N = (float(CASE[k][at]) for k in ("theta_unwrapped", "thetadot", "g_n"))
    assert pytest.approx(N, rel=1e-13) == planar.roll(np.sin(theta), np.cos(theta), theta_dot, BALL).N


def test_the_reference_reverses_and_sticks_as_the_force_of_rolling_says() -> None:
    """Outside the cone it slips on against that force; inside it rolls; it leaves the cone at its edge."""
    for event in CASE["events"]:
        theta, theta_dot = float(event["theta_unwrapped"]), float(event["thetadot"])
        force = planar.roll(np.sin(theta), np.cos(theta), theta_dot, BALL)
        ratio = abs(force.F_x) / (BALL.friction.mu * force.N)
        expected = {"reversal": ratio > 1, "stick": ratio < 1, "slip": ratio == pytest.approx(1, abs=1e-13)}
        assert expected[event["kind"]], (event["kind"], ratio)

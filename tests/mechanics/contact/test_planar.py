"""The cylinder under exact Coulomb friction: its formulas, and the states of the reference run."""

import json
from pathlib import Path

import numpy as np
import pytest
from components import Components, bias, reaction_of_rolling

from tippetop.mechanics.contact import planar
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.coulomb import Slide
from tippetop.mechanics.contact.response import mobility
from tippetop.mechanics.friction import SetValued


CASE = json.loads(
    (Path(__file__).parents[2] / "reference" / "caseC6_cylinder_coulomb.json").read_text()
)
BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.1))


def slide(theta: float, theta_dot: float, sigma: float) -> Slide:
    q = type(planar.SIGNED)(np.sin(theta), np.cos(theta), theta_dot, 0.0, sigma)
    return planar.signed(q, BALL)


def rolling(theta: float, theta_dot: float) -> Components:
    s, z = np.sin(theta), np.cos(theta)
    return reaction_of_rolling(bias(s, z, theta_dot, 0, 0, BALL), mobility(s, z, BALL))


def test_slip_is_what_the_torque_and_the_constraint_ask_for(rng: np.random.Generator) -> None:
    """In lengths and moments of a free body: m x'' = F_x, m s_z'' = N - m g, I theta''
    = (a x F)_y.
    """
    for sigma in (-1, 1):
        theta, theta_dot = rng.uniform(-7, 7), rng.normal(0, 20)
        s, z = np.sin(theta), np.cos(theta)
        made = slide(theta, theta_dot, sigma)
        (F_x, _, N), turn, nu_dot = made.force, made.turn.y / BALL.I1, sigma * made.P
        lever, H = BALL.c * s, BALL.R - BALL.c * z
        assert F_x == -0.1 * sigma * N
        assert pytest.approx(-(lever * N + H * F_x), rel=1e-12) == BALL.I1 * turn
        height_dot2 = BALL.c * (z * theta_dot**2 + s * turn)
        assert pytest.approx(BALL.m * (BALL.g + height_dot2), rel=1e-12) == N
        assert nu_dot == pytest.approx(F_x / BALL.m - H * turn - lever * theta_dot**2, rel=1e-12)


def test_the_reference_has_these_normal_forces() -> None:
    slip = [i for i, phase in enumerate(CASE["phase"]) if phase == "slip" and CASE["g_n"][i]]
    for i in slip:
        theta, theta_dot, nu, N = (
            float(CASE[k][i]) for k in ("theta_unwrapped", "thetadot", "nu_x", "g_n")
        )
        assert pytest.approx(N, rel=1e-13) == slide(theta, theta_dot, np.sign(nu)).force.z
    assert len(slip) > 10
    at = CASE["phase"].index("roll")
    theta, theta_dot, N = (float(CASE[k][at]) for k in ("theta_unwrapped", "thetadot", "g_n"))
    assert pytest.approx(N, rel=1e-13) == rolling(theta, theta_dot).z


def test_the_reference_reverses_and_sticks_as_the_force_of_rolling_says() -> None:
    """Outside the cone it slips on against that force; inside it rolls; it leaves the cone at its
    edge.
    """
    for event in CASE["events"]:
        theta, theta_dot = float(event["theta_unwrapped"]), float(event["thetadot"])
        force = rolling(theta, theta_dot)
        ratio = abs(force.e) / (BALL.friction.mu * force.z)
        expected = {
            "reversal": ratio > 1,
            "stick": ratio < 1,
            "slip": ratio == pytest.approx(1, abs=1e-13),
        }
        assert expected[event["kind"]], (event["kind"], ratio)

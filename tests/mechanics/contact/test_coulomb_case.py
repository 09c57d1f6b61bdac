"""The formulas of slip, integrated as they stand, lead where the references do: sticking in
time-changed variables.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from components import bias, reaction_of_rolling, slip_force
from scipy.integrate import solve_ivp

from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact import coulomb
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.response import bias_vector, mobility
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector, cross, dot, times


FOLDER = Path(__file__).parents[2] / "reference"
BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.3))
STOP = 1e-12  # [m/s]


def test_the_canonical_top_sticks_when_the_reference_does() -> None:
    """dt = w dtau, log w and the direction: regular where the slip ends; then t + w/|P|.

    [contact 2.2]
    """
    case = json.loads((FOLDER / "caseC1_coulomb_slip_to_roll.json").read_text())
    event = {
        k: float(v)
        for k, v in case["events"][0].items()
        if isinstance(v, str) and k not in ("kind", "contact")
    }
    u = Vector(np.sin(0.1), 0.0, np.cos(0.1))
    L = times(155 * BALL.I3, u)
    v = contact.contact_velocity(u, L, Vector(0.0, 0.0, 0.0), BALL)

    def parts(y: np.ndarray) -> tuple:
        u, L, n = Vector(*y[:3]), Vector(*y[3:6]), Vector(np.cos(y[6]), np.sin(y[6]), 0)
        by = coulomb.slip_motion(u, L, n, BALL)
        return u, L, by.force, by.P, by.Q

    def rate(tau: float, y: np.ndarray) -> np.ndarray:
        u, L, F, P, Q = parts(y)
        w = np.exp(y[7])
        turn, twist = contact.axis_rate(u, L, BALL), cross(contact.arm(u, BALL), F)
        return np.array([*(w * np.array([*turn, *twist])), Q, P, w])

    def stops(tau: float, y: np.ndarray) -> float:
        return y[7] - np.log(STOP)

    stops.terminal = True  # type: ignore[attr-defined]
    start = [*u, *L, np.arctan2(v.y, v.x), np.log(np.hypot(v.x, v.y)), 0.0]
    end = solve_ivp(rate, (0, 1e3), start, "DOP853", events=stops, rtol=1e-13, atol=1e-17).y[:, -1]
    u, L, _, P, _ = parts(end)
    assert end[8] - STOP / P == pytest.approx(event["t"], abs=1e-14)
    assert np.arctan2(np.hypot(u.x, u.y), u.z) == pytest.approx(event["theta"], abs=1e-13)
    F = coulomb.reaction_of_rolling_vector(u, bias_vector(u, L, BALL), BALL)
    assert np.hypot(F.x, F.y) / (BALL.friction.mu * F.z) == pytest.approx(
        event["cone_ratio"], rel=1e-10
    )
    assert contact.jellett_of(L.z, dot(L, u), BALL) == pytest.approx(event["lambda"], rel=1e-13)


def test_normal_forces_of_the_references_are_these() -> None:
    """By angles and by vectors, in slip and in rolling."""
    compared = {"slip": 0, "roll": 0}
    for name in ("caseC1_coulomb_slip_to_roll", "caseC3_liftoff_flight_plastic_landing"):
        case = json.loads((FOLDER / f"{name}.json").read_text())
        for i, phase in enumerate(case["phase"]):
            if phase not in compared or not case["g_n"][i]:
                continue
            theta, *rates = (float(case[k][i]) for k in ("theta", "thetadot", "phidot", "omega3"))
            s, z = np.sin(theta), np.cos(theta)
            b, K = bias(s, z, *rates, BALL), mobility(s, z, BALL)
            nu = [float(case[k][i]) for k in ("nu_x", "nu_y")]
            n_e = nu[0] / np.hypot(*nu) if phase == "slip" else 0
            F = (
                slip_force(b, K, n_e, 0, BALL.friction.mu)
                if phase == "slip"
                else reaction_of_rolling(b, K)
            )
            assert float(case["g_n"][i]) == pytest.approx(F.z, rel=1e-12)
            compared[phase] += 1
    assert min(compared.values()) >= 3


def test_the_set_valued_law_pulls_with_mu_at_every_speed() -> None:
    """k |v| = mu: the law that regularised Coulomb friction tends to."""
    speeds = np.array([1e-6, 0.1, 3.0])
    k = SetValued.coefficient(speeds**2, 0.3, SetValued(0.4))
    np.testing.assert_allclose(k * speeds, 0.4, rtol=1e-15)

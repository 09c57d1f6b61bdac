"""Impacts: against integrations, the reference, closed forms; they never make energy."""

import itertools
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nightly import at_night
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.response import Mobility, jumps, mobility
from tippetop.mechanics.contact.struck import RESTITUTIONS, Impact, struck
from tippetop.mechanics.contact.uniqueness import painleve_bound
from tippetop.mechanics.friction import SetValued
from tippetop.mechanics.operand import Vector


CASE = json.loads(
    (
        Path(__file__).parents[2] / "reference" / "caseC3_liftoff_flight_plastic_landing.json"
    ).read_text()
)
BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, SetValued(0.3))
STEM = Touch(0.006, 0.005, 0.016, 8e-7, 7e-7, 9.81, SetValued(0.3))
BOUNDS = {ball: painleve_bound(ball.m, ball.I1, ball.c, ball.R) for ball in (BALL, STEM)}

every_law = pytest.mark.parametrize("law", RESTITUTIONS)


def at(theta: float, ball: Touch = BALL) -> Mobility:
    return mobility(np.sin(theta), np.cos(theta), ball)


def random_impact(rng: np.random.Generator, most: float = 1.0) -> tuple:
    """Velocities of mixed sizes, a mobility, mu below Painleve's bound."""
    ball = (BALL, STEM)[rng.integers(2)]
    v = rng.normal(0, 1, 3) * 10 ** rng.uniform(-1, 1, 3)
    return (
        v[0],
        v[1],
        -abs(v[2]),
        at(rng.uniform(0, np.pi), ball),
        rng.uniform(0.02, most * min(1, BOUNDS[ball])),
    )


def impact_rates(beta: float, log_w: float, v_n: float, K: Mobility, mu: float) -> tuple:
    """The equations of an impact that slips, by sigma, dp = w dsigma: direction, log w, v_n,
    impulse and work.
    """
    C, S, w = np.cos(beta), np.sin(beta), np.exp(log_w)
    along, across = K.ez - mu * C * K.ee, -(mu * S * K.tt)
    return C * across - S * along, C * along + S * across, w * (K.zz - mu * C * K.ez), w, w * v_n


def balanced(v: tuple, K: Mobility, made: Impact) -> None:
    """The velocity jumps by K p, and the energy by p.(v- + v+)/2."""
    p, after = (made.p_e, made.p_2, made.p_z), (made.v_e, made.v_2, made.v_n)
    size = max(np.abs([*v, *after]))
    jump = (K.ee * p[0] + K.ez * p[2], K.tt * p[1], K.ez * p[0] + K.zz * p[2])
    np.testing.assert_allclose(np.subtract(after, v), jump, rtol=0, atol=4e-15 * size)
    energy = np.dot(p, np.add(v, after)) / 2
    assert made.energy == pytest.approx(
        energy, rel=0, abs=1e-14 * np.dot(np.abs(p), np.abs(v) + np.abs(after))
    )


def slipped(y: Any, K: Mobility, mu: float, end: Callable) -> np.ndarray:
    """Return direction, log w, v_n, impulse and work of an impact that slips until `end` rises
    through zero.
    """
    end.terminal, end.direction = True, 1  # type: ignore[attr-defined]
    made = solve_ivp(
        lambda s, y: impact_rates(*y[:3], K, mu),
        (0, 1e4),
        y,
        "DOP853",
        events=end,
        rtol=1e-12,
        atol=1e-13,
    )
    return made.y[:, -1]


def impacts(mode: str, e_n: float, law: str, rng: np.random.Generator) -> Iterator[tuple]:
    """Yield five random impacts that end in a mode, and their starts for `slipped`."""
    count = 0
    while count < 5:
        *v, K, mu = random_impact(rng)
        if (made := struck(*v, K, mu, e_n, law)).mode == mode:
            count += 1
            start = np.arctan2(v[1], v[0]), np.log(np.hypot(v[0], v[1])), v[2], 0, 0
            yield made, v, K, mu, start


@every_law
def test_an_impact_that_slips_follows_its_equations(law: str, rng: np.random.Generator) -> None:
    for made, v, K, mu, start in impacts("slip", 0.6, law, rng):
        pressed = slipped(start, K, mu, lambda s, y: y[2])
        ends = {
            "energetic": lambda s, y, work=pressed[4]: y[4] - 0.64 * work,
            "poisson": lambda s, y, impulse=pressed[3]: y[3] - 1.6 * impulse,
            "newton": lambda s, y, v_n=v[2]: y[2] + 0.6 * v_n,
        }
        beta, log_w, v_n, impulse, work_n = slipped(pressed, K, mu, ends[law])
        along, across = np.exp(log_w) * np.cos(beta), np.exp(log_w) * np.sin(beta)
        expected = pytest.approx((along, across, v_n), abs=1e-9 * np.abs(v).max())
        assert (made.v_e, made.v_2, made.v_n) == expected
        assert (made.p_z, made.work_n) == pytest.approx((impulse, work_n), rel=1e-9)
        balanced(tuple(v), K, made)


def test_an_impact_that_stops_goes_on_straight(rng: np.random.Generator) -> None:
    for made, v, K, mu, start in impacts("stick", 0.0, "energetic", rng):
        _, _, v_n, impulse, work_n = slipped(start, K, mu, lambda s, y, w=start[1]: w - 23 - y[1])
        lift = K.zz - K.ez**2 / K.ee
        assert v_n < 0
        assert made.p_z == pytest.approx(impulse - v_n / lift, rel=1e-8)
        assert made.work_n == pytest.approx(work_n - v_n**2 / lift / 2, rel=1e-8)
        balanced(tuple(v), K, made)


def test_the_reference_impact() -> None:
    before, after = CASE["events"][1:3]
    K = at(float(before["theta"]))
    v = tuple(float(before[k]) for k in ("nu_x", "nu_y", "nu_z"))
    made = struck(*v, K, 0.3, 0.0)
    pairs = {
        "v_e": "nu_x",
        "v_2": "nu_y",
        "p_z": "pn",
        "work_n": "Wn",
        "work_t": "Wt",
        "energy": "dE",
    }
    for name, theirs in pairs.items():
        assert getattr(made, name) == pytest.approx(float(after[theirs]), rel=3e-15), name
    assert made.v_n == 0
    assert made.mode == after["end_mode"]
    theta = float(before["theta"])
    s, z = np.sin(theta), np.cos(theta)
    _, dL = jumps(Vector(s, 0.0, z), Vector(made.p_e, made.p_2, made.p_z), BALL)
    dL3 = dL.x * s + dL.z * z
    added = {
        "thetadot": dL.y / BALL.I1,
        "phidot": (dL.z - dL3 * z) / (BALL.I1 * s**2),
        "omega3": dL3 / BALL.I3,
    }
    for name, jump in added.items():
        assert jump == pytest.approx(float(after[name]) - float(before[name]), rel=1e-12)


def planar(v_x: float, v_n: float, K: Mobility, mu: float, e_n: float, law: str) -> tuple:
    """The impact in a plane, phase by phase with exact fractions of pi: p_x, p_z, v_x, v_n, by
    small steps of logic.
    """
    pieces = []  # (pi, slope of v_n, slope of v_x)
    sigma, stop = np.sign(v_x), np.inf
    stuck = (np.inf, K.zz - K.ez**2 / K.ee, 0.0)
    turned = (np.inf, K.zz - mu * abs(K.ez), K.ez - mu * np.sign(K.ez) * K.ee)
    after = stuck if abs(K.ez) <= mu * K.ee else turned
    if sigma:
        slope = K.ez - mu * sigma * K.ee
        stop = -v_x / slope if sigma * slope < 0 else np.inf
        pieces.append((stop, K.zz - mu * sigma * K.ez, slope))
    pieces += [after] if stop < np.inf or not sigma else []

    def velocity(pi: float) -> tuple[float, float]:
        x, n, left = v_x, v_n, pi
        for length, up, along in pieces:
            part = min(left, length)
            x, n, left = x + along * part, n + up * part, left - part
        return x, n

    def work(pi: float) -> float:
        knots = [0.0, min(stop, pi), pi]
        return sum(
            (b - a) * (velocity(a)[1] + velocity(b)[1]) / 2 for a, b in itertools.pairwise(knots)
        )

    pressed = brentq(lambda pi: velocity(pi)[1], 0, 1e3, xtol=1e-18)
    end = {
        "energetic": lambda pi: work(pi) - (1 - e_n**2) * work(pressed),
        "poisson": lambda pi: pi - (1 + e_n) * pressed,
        "newton": lambda pi: velocity(pi)[1] + e_n * v_n,
    }[law]
    pi = brentq(end, pressed, 1e3, xtol=1e-18)
    return (*velocity(pi), pi)


@every_law
def test_a_planar_impact_is_made_of_straight_pieces(law: str, rng: np.random.Generator) -> None:
    modes = set()
    for _ in range(60):
        v_x, _, v_n, K, mu = random_impact(rng)
        v_x = 0.0 if rng.random() < 0.1 else v_x
        made = struck(v_x, 0.0, v_n, K, mu, 0.7, law)
        expected = planar(v_x, v_n, K, mu, 0.7, law)
        size = max(abs(v_x), abs(v_n))
        assert (made.v_e, made.v_n) == pytest.approx(expected[:2], rel=0, abs=1e-12 * size)
        assert made.p_z == pytest.approx(expected[2], rel=1e-12)
        assert (made.v_2, made.p_2) == (0, 0)
        balanced((v_x, 0, v_n), K, made)
        modes.add(made.mode)
    assert modes == {"slip", "stick", "reverse"}


def test_newton_can_make_energy_and_is_caught() -> None:
    """Kane's paradox: +0.166 of v_n^2/(2 K_zz)."""
    K = at(1.66)
    unit = 1 / (2 * K.zz)
    made = struck(-0.66, 0, -1, K, 0.31, 1, "newton")
    assert made.energy / unit == pytest.approx(0.166, abs=5e-4)
    assert made.makes_energy
    for law in ("energetic", "poisson"):
        other = struck(-0.66, 0, -1, K, 0.31, 1, law)
        assert other.energy < 0
        assert not other.makes_energy


@every_law
@pytest.mark.parametrize("count", [100, at_night(33_334)])
def test_impacts_never_make_energy(law: str, count: int, rng: np.random.Generator) -> None:
    """But for Newton's law, which is caught."""
    for _ in range(count):
        *v, K, mu = random_impact(rng)
        made = struck(*v, K, mu, rng.uniform(0, 1), law)
        balanced(tuple(v), K, made)
        assert made.makes_energy == (made.energy > 1e-12 * abs(made.compression))
        assert law == "newton" or not made.makes_energy
        assert made.work_t <= 0


@pytest.mark.parametrize("wrong", [{"v_n": 0.1}, {"e_n": 1.2}, {"mu": 50}, {"restitution": "no"}])
def test_what_is_no_impact_is_refused(wrong: dict) -> None:
    right = {"v_e": 0.1, "v_2": 0.1, "v_n": -0.1, "K": at(1.0), "mu": 0.3, "e_n": 0.5}
    with pytest.raises(ValueError, match="no impact"):
        struck(**right | wrong)

"""Impacts: against an integration of 30 digits, the reference, closed forms; they never make
energy.
"""

import itertools
import json
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from nightly import at_night
from scipy.integrate import solve_ivp

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


def compare(
    made: Impact, after: Any, p: Any, work_n: Any, work_t: Any, size: float, stiffest: float
) -> None:
    for found, expected in zip((made.v_e, made.v_2, made.v_n), after, strict=True):
        assert abs(found - expected) < 1e-14 * size
    for found, expected in zip((made.p_e, made.p_2, made.p_z), p, strict=True):
        assert abs(found - expected) < 1e-14 * max(p[2], size / stiffest)
    assert made.work_n == pytest.approx(float(work_n), rel=1e-13)
    assert made.work_t == pytest.approx(float(work_t), rel=1e-13)


one_or_many = pytest.mark.parametrize(
    ("law", "count"), [("energetic", 2), *(at_night(law, 10) for law in RESTITUTIONS)]
)


@one_or_many
def test_impacts_have_the_digits_of_25(law: str, count: int, rng: np.random.Generator) -> None:
    """The same function with numbers of 25 digits, of which the reference tests one impact."""
    compared = 0
    with mp.workdps(25):
        while compared < count:
            *v, K, mu = random_impact(rng)
            v[2] *= 3
            made = struck(*v, K, mu, 0.6, law)
            exact_K = Mobility(*(mp.mpf(float(k)) for k in K))
            exact = struck(*(mp.mpf(float(x)) for x in v), exact_K, mp.mpf(mu), mp.mpf(0.6), law)
            compare(
                made, exact[3:6], exact[:3], exact.work_n, exact.work_t, np.abs(v).max(), max(K)
            )
            assert exact.mode == made.mode
            compared += 1


def test_an_impact_that_stops_is_that_of_the_rates_and_then_straight(
    rng: np.random.Generator,
) -> None:
    compared = 0
    while compared < 10:
        *v, K, mu = random_impact(rng)
        made = struck(*v, K, mu, 0)
        if made.mode != "stick":
            continue
        beta, log_w = np.arctan2(v[1], v[0]), np.log(np.hypot(v[0], v[1]))
        stops = lambda s, y, start=log_w: y[1] - start + 23  # noqa: E731
        stops.terminal = True  # type: ignore[attr-defined]
        rates = lambda s, y, K=K, mu=mu: impact_rates(*y[:3], K, mu)  # noqa: E731
        start = (beta, log_w, v[2], 0, 0)
        end = solve_ivp(rates, (0, 1e4), start, "DOP853", events=stops, rtol=1e-11, atol=1e-12)
        _, _, v_n, impulse, work_n = end.y[:, -1]
        if v_n > 0:  # it stopped in restitution, of which there is none here
            continue
        lift = K.zz - K.ez**2 / K.ee
        assert made.p_z == pytest.approx(impulse - v_n / lift, rel=1e-8)
        assert made.work_n == pytest.approx(work_n - v_n**2 / lift / 2, rel=1e-8)
        balanced(tuple(v), K, made)
        compared += 1


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
    with mp.workdps(25):
        exact = Touch(
            *map(mp.mpf, ("0.02", "0.02", "0.006", "131", "1", "9.82")), SetValued(mp.mpf("0.3"))
        )
        exact = exact._replace(I1=exact.I1 / 43750000, I3=exact.I3 / 312500)
        theta = mp.mpf(before["theta"])
        K = mobility(mp.sin(theta), mp.cos(theta), exact)
        made = struck(
            *(mp.mpf(before[k]) for k in ("nu_x", "nu_y", "nu_z")), K, mp.mpf("0.3"), mp.mpf(0)
        )
        for name, theirs in pairs.items():
            assert abs(getattr(made, name) / mp.mpf(after[theirs]) - 1) < 1e-23


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
        knots = sorted({0.0, pi, *(x for x in (stop,) if x < pi)})
        return sum(
            (b - a) * (velocity(a)[1] + velocity(b)[1]) / 2 for a, b in itertools.pairwise(knots)
        )

    def solved(f: Any) -> float:
        low, high = 0.0, 1e3
        for _ in range(200):
            low, high = (
                ((low + high) / 2, high) if f((low + high) / 2) < 0 else (low, (low + high) / 2)
            )
        return high

    pressed = solved(lambda pi: velocity(pi)[1])
    end = {
        "energetic": lambda pi: -1 if pi < pressed else work(pi) - (1 - e_n**2) * work(pressed),
        "poisson": lambda pi: pi - (1 + e_n) * pressed,
        "newton": lambda pi: velocity(pi)[1] + e_n * v_n,
    }[law]
    pi = solved(end)
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


def test_slip_that_swings_round_tends_to_a_reversal(rng: np.random.Generator) -> None:
    """Where sticking is impossible, v_2 = 0 reverses; a small v_2 turns the direction without a
    stop.
    """
    K, mu = at(1.9, STEM), 0.3
    assert abs(K.ez) > mu * K.ee
    v_e = -0.3 * np.sign(K.ez)
    exact = struck(v_e, 0, -1, K, mu, 0.5)
    assert exact.mode == "reverse"
    errors = []
    for v_2 in (1e-3, 1e-6, 1e-9, 1e-12):
        made = struck(v_e, v_2, -1, K, mu, 0.5)
        assert made.mode == "slip" or v_2 < 1e-8
        errors.append(abs(made.v_e - exact.v_e) + abs(made.p_z - exact.p_z))
    assert all(b < max(a / 1000, 1e-15) for a, b in itertools.pairwise(errors)), errors
    assert struck(v_e, 1e-25, -1, K, mu, 0.5)[:6] == pytest.approx(exact[:6], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("count", [100, at_night(3_000)])
@every_law
def test_impacts_never_make_energy(law: str, count: int, rng: np.random.Generator) -> None:
    for _ in range(count):
        *v, K, mu = random_impact(rng)
        e_n = rng.uniform(0, 1)
        made = struck(*v, K, mu, e_n, law)
        balanced(tuple(v), K, made)
        if law == "newton":
            assert made.makes_energy == (made.energy > 1e-12 * abs(made.compression))
        else:
            assert not made.makes_energy
            assert made.energy < 0
        assert made.work_t <= 0


@pytest.mark.parametrize("wrong", [{"v_n": 0.1}, {"e_n": 1.2}, {"mu": 50}, {"restitution": "no"}])
def test_what_is_no_impact_is_refused(wrong: dict) -> None:
    right = {
        "v_e": 0.1,
        "v_2": 0.1,
        "v_n": -0.1,
        "K": at(1.0),
        "mu": 0.3,
        "e_n": 0.5,
        "restitution": "energetic",
    }
    with pytest.raises(ValueError, match="no impact"):
        struck(**{**right, **wrong})

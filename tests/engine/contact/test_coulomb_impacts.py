"""Impacts under Coulomb's law: against more digits, integrations, closed forms;
they never make energy.
"""

import itertools
from typing import Any

import numpy as np
import pytest
from nightly import at_night
from scipy.integrate import solve_ivp
from touching import gained, mobility, struck

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.restitution import RESTITUTIONS
from tippetop.mechanics.contact.uniqueness import painleve_bound
from tippetop.mechanics.friction import SetValued


BALL = Touch(1.0, 1.0, 0.3, 131 / 350, 0.4, 1.0, SetValued(0.3))
STEM = Touch(1.0, 1 / 3, 16 / 15, 0.6, 0.5, 1.0, SetValued(0.3))
BOUNDS = {ball: painleve_bound(ball) for ball in (BALL, STEM)}

every_law = pytest.mark.parametrize("law", RESTITUTIONS)


def hit(
    v: Any, theta: Any, mu: float = 0.3, e_n: float = 0.0, law: str = "energetic", ball: Any = BALL
) -> Any:
    ball = ball._replace(friction=SetValued(mu))
    return struck(v, np.sin(theta), np.cos(theta), ball, e_n, law)


def at(theta: float, ball: Touch = BALL) -> Any:
    return mobility(np.sin(theta), np.cos(theta), ball)


def random_impact(rng: np.random.Generator, most: float = 1.0) -> tuple:
    """Velocities of mixed sizes, an angle, mu below Painleve's bound, and a ball."""
    ball = (BALL, STEM)[rng.integers(2)]
    v = rng.normal(0, 1, 3) * 10 ** rng.uniform(-1, 1, 3)
    mu = rng.uniform(0.02, most * min(1, BOUNDS[ball]))
    return (v[0], v[1], -abs(v[2])), rng.uniform(0, np.pi), float(mu), ball


def balanced(v: tuple, K: Any, made: Any) -> None:
    """The velocity jumps by K p, and the energy by p.(v- + v+)/2."""
    p, after = made.p, (made.v_e, made.v_2, made.v_n)
    size = max(np.abs([*v, *after]))
    jump = (K.ee * p[0] + K.ez * p[2], K.tt * p[1], K.ez * p[0] + K.zz * p[2])
    np.testing.assert_allclose(np.subtract(after, v), jump, rtol=0, atol=1e-14 * size)
    scale = np.dot(np.abs(p), np.abs(v) + np.abs(after))
    assert made.energy == pytest.approx(gained(v, made), rel=0, abs=1e-13 * scale)


def test_an_impact_that_stops_is_that_of_the_rates_and_then_straight(
    rng: np.random.Generator,
) -> None:
    compared = 0
    while compared < 10:
        v, theta, mu, ball = random_impact(rng)
        made, K = hit(v, theta, mu, ball=ball), at(theta, ball)
        if made.mode != "stick":
            continue

        def rates(s: float, y: Any, K: Any = K, mu: float = mu) -> tuple:
            """By sigma, dp = w dsigma: direction, log w, v_n, impulse and work."""
            C, S, w = np.cos(y[0]), np.sin(y[0]), np.exp(y[1])
            along, across = K.ez - mu * C * K.ee, -(mu * S * K.tt)
            turn = C * across - S * along
            return turn, C * along + S * across, w * (K.zz - mu * C * K.ez), w, w * y[2]

        beta, log_w = np.arctan2(v[1], v[0]), np.log(np.hypot(v[0], v[1]))
        stops = lambda s, y, start=log_w: y[1] - start + 23  # noqa: E731
        stops.terminal = True  # type: ignore[attr-defined]
        start = (beta, log_w, v[2], 0, 0)
        end = solve_ivp(rates, (0, 1e4), start, "DOP853", events=stops, rtol=1e-11, atol=1e-12)
        _, _, v_n, impulse, work_n = end.y[:, -1]
        if v_n > 0:  # it stopped in restitution, of which there is none here
            continue
        lift = K.zz - K.ez**2 / K.ee
        assert made.p_z == pytest.approx(impulse - v_n / lift, rel=1e-8)
        assert made.work_n == pytest.approx(work_n - v_n**2 / lift / 2, rel=1e-8)
        balanced(v, K, made)
        compared += 1


def planar(v_x: float, v_n: float, K: Any, mu: float, e_n: float, law: str) -> tuple:
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
        (v_x, _, v_n), theta, mu, ball = random_impact(rng)
        v_x = 0.0 if rng.random() < 0.1 else v_x
        made, K = hit((v_x, 0.0, v_n), theta, mu, 0.7, law, ball), at(theta, ball)
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
    made = hit((-0.66, 0, -1), 1.66, 0.31, 1.0, "newton")
    assert made.energy * 2 * at(1.66).zz == pytest.approx(0.166, abs=5e-4)
    assert made.makes_energy
    for law in ("energetic", "poisson"):
        other = hit((-0.66, 0, -1), 1.66, 0.31, 1.0, law)
        assert other.energy < 0
        assert not other.makes_energy


def test_slip_that_swings_round_tends_to_a_reversal(rng: np.random.Generator) -> None:
    """Where sticking is impossible, v_2 = 0 reverses; a small v_2 turns the direction without a
    stop.
    """
    K, mu = at(1.9, STEM), 0.3
    assert abs(K.ez) > mu * K.ee
    v_e = -0.3 * np.sign(K.ez)
    exact = hit((v_e, 0, -1), 1.9, mu, 0.5, ball=STEM)
    assert exact.mode == "reverse"
    errors = []
    for v_2 in (1e-3, 1e-6, 1e-9, 1e-12):
        made = hit((v_e, v_2, -1), 1.9, mu, 0.5, ball=STEM)
        assert made.mode == "slip" or v_2 < 1e-8
        errors.append(abs(made.v_e - exact.v_e) + abs(made.p_z - exact.p_z))
    assert all(b < max(a / 1000, 1e-15) for a, b in itertools.pairwise(errors)), errors


@pytest.mark.parametrize("count", [100, at_night(3_000)])
@every_law
def test_impacts_never_make_energy(law: str, count: int, rng: np.random.Generator) -> None:
    """The energy after an impact is at most that before it."""
    for _ in range(count):
        v, theta, mu, ball = random_impact(rng)
        made = hit(v, theta, mu, float(rng.uniform(0, 1)), law, ball)
        balanced(v, at(theta, ball), made)
        if law == "newton":
            assert made.makes_energy == (made.energy > 1e-12 * abs(made.compression))
        else:
            assert not made.makes_energy
            assert made.energy < 0
        assert made.work_t <= 0

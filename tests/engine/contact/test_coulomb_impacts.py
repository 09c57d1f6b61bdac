"""Impacts under Coulomb's law: limits, and balances of random ones, which never make energy."""

import itertools
from typing import Any

import numpy as np
import pytest
from limits import assert_near
from nightly import at_night
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
    assert_near(np.subtract(after, v), jump, 1e-14 * size)
    scale = np.dot(np.abs(p), np.abs(v) + np.abs(after))
    assert made.energy == pytest.approx(gained(v, made), rel=0, abs=1e-13 * scale)


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

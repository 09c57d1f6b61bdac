"""Painleve's bound and that of the hand-over: published values, and dense scans."""

import math

import numpy as np
import pytest

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.response import mobility
from tippetop.mechanics.contact.uniqueness import both_touch_at, hand_over_bound, painleve_bound


CANONICAL = (0.02, 131 / 43750000, 0.006, 0.02)
LEINE = 0.006, 8e-7
BODY, STEM = (0.003, 0.015), (0.016, 0.005)


def scanned(m: float, I1: float, offset: float, radius: float) -> float:
    theta = np.linspace(0, np.pi, 100_001)[1:-1]
    K = mobility(np.sin(theta), np.cos(theta), Touch(m, radius, offset, I1, I1, 9.8, None))
    with np.errstate(divide="ignore"):
        return float(np.min(K.zz / np.abs(K.ez)))


def test_published_bounds() -> None:
    assert painleve_bound(*CANONICAL) == pytest.approx(1.4595, abs=5e-5)
    assert painleve_bound(*LEINE, *BODY) == pytest.approx(3.096, abs=5e-4)
    assert painleve_bound(*LEINE, *STEM) == pytest.approx(1.303, abs=5e-4)
    assert hand_over_bound(*LEINE, BODY, STEM) == pytest.approx(4.609, abs=6e-4)
    assert hand_over_bound(*LEINE, STEM, BODY) == pytest.approx(0.864, abs=5e-4)
    assert math.degrees(math.acos(both_touch_at(BODY, STEM))) == pytest.approx(140.285, abs=5e-4)


def test_most_of_the_coupling_is_as_published() -> None:
    """max |K_ez|/K_ee over theta: with more friction than this a contact that stops inside an impact sticks."""
    theta = np.linspace(0, np.pi, 100_001)
    for body, expected in ((CANONICAL, 0.2203), ((*LEINE, *BODY), 0.126), ((*LEINE, *STEM), 0.652)):
        m, I1, offset, radius = body
        K = mobility(np.sin(theta), np.cos(theta), Touch(m, radius, offset, I1, I1, 9.8, None))
        assert np.max(np.abs(K.ez) / K.ee) == pytest.approx(expected, abs=6e-4)


def test_the_bound_is_the_least_of_a_dense_scan(rng: np.random.Generator) -> None:
    for m, I1, offset, radius in zip(
        *rng.uniform(0.1, 2, (2, 30)), rng.normal(0, 1, 30), [*rng.uniform(0, 1, 28), 0, 0], strict=True
    ):
        bound, least = painleve_bound(m, I1, offset, radius), scanned(m, I1, offset, radius)
        assert least * (1 - 1e-7) <= bound <= least * (1 + 1e-12)
    assert painleve_bound(1, 1, 0, 1) == math.inf


def test_an_impact_of_the_new_ball_lifts_the_old_one_below_the_bound() -> None:
    """The velocity of the old contact point after an impulse on the new one, from the motion of the free body."""
    for old, new in ((BODY, STEM), (STEM, BODY)):
        (m, I1), z = LEINE, both_touch_at(old, new)
        s = math.sqrt(1 - z * z)
        bound = hand_over_bound(*LEINE, old, new)

        def lifted(mu: float, m=m, I1=I1, s=s, z=z, old=old, new=new) -> float:
            """Of p = (p_e, 1) with the worse of both directions of friction."""
            H = new[1] - new[0] * z
            return min(1 / m - old[0] * s * -(new[0] * s + H * p_e) / I1 for p_e in (mu, -mu))

        assert lifted(bound * (1 - 1e-9)) > 0 > lifted(bound * (1 + 1e-9))
    assert math.isnan(hand_over_bound(1, 1, (0.3, 1), (0.5, 0.2)))
    assert hand_over_bound(1, 1, (0, 1), (1, 0.5)) == math.inf

"""Painleve's bound: published values, and dense scans."""

import math

import numpy as np
import pytest
from examples import GLIDING
from touching import mobility

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.uniqueness import painleve_bound


def ball(m: float, I1: float, offset: float, radius: float) -> Touch:
    return Touch(m, radius, offset, I1, I1, 9.8, None)


LEINE = 0.006, 8e-7
BODY, STEM = ball(*LEINE, 0.003, 0.015), ball(*LEINE, 0.016, 0.005)


def scanned(b: Touch) -> float:
    theta = np.linspace(0, np.pi, 100_001)[1:-1]
    K = mobility(np.sin(theta), np.cos(theta), b)
    with np.errstate(divide="ignore"):
        return float(np.min(K.zz / np.abs(K.ez)))


def test_published_bounds() -> None:
    assert painleve_bound(GLIDING) == pytest.approx(1.4595, abs=5e-5)
    assert painleve_bound(BODY) == pytest.approx(3.096, abs=5e-4)
    assert painleve_bound(STEM) == pytest.approx(1.303, abs=5e-4)


def test_the_bound_is_the_least_of_a_dense_scan(rng: np.random.Generator) -> None:
    for m, I1, offset, radius in zip(
        *rng.uniform(0.1, 2, (2, 30)),
        rng.normal(0, 1, 30),
        [*rng.uniform(0, 1, 28), 0, 0],
        strict=True,
    ):
        b = ball(m, I1, offset, radius)
        bound, least = painleve_bound(b), scanned(b)
        assert bound == pytest.approx(least, rel=1e-5)
    assert painleve_bound(ball(1, 1, 0, 1)) == math.inf

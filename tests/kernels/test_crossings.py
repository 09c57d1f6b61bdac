"""Sign changes and extremes of polynomials, against polynomials made of known roots and dense scans."""

import numpy as np
import pytest

from tippetop_kernels.crossings import crossings, extremes, value


def found(p: np.ndarray, positive: bool) -> tuple[np.ndarray, bool]:
    out = np.empty(16)
    n, now = crossings(p, positive, out, np.empty_like(p))
    return out[:n].copy(), now


def test_known_roots_are_found_and_no_others(rng: np.random.Generator) -> None:
    """Roots inside, outside, near the ends and in near pairs; coefficients up to order 19 as a step has them."""
    for trial in range(300):
        inside = np.sort(rng.uniform(0.001, 0.999, rng.integers(0, 6)))
        if trial % 3 == 0 and len(inside):
            inside = np.sort(np.append(inside, inside[0] + 0.004))
        inside = inside[inside < 1]
        outside = rng.choice([-1, 1], 4) * rng.uniform(1.2, 4, 4)
        p = np.zeros(20)
        series = np.polynomial.polynomial.polyfromroots([*inside, *outside])
        p[: len(series)] = series
        zeros, now = found(p, bool(p[0] > 0))
        assert len(zeros) == len(inside), (inside, zeros)
        np.testing.assert_allclose(zeros, inside, atol=1e-9)
        assert now == (value(p, 1.0) > 0)


def test_a_zero_between_two_steps_counts_once() -> None:
    """The step before ended negative, this one starts positive: rounding put the zero between them."""
    p = np.array([1e-17, 1.0, 0.0])
    np.testing.assert_array_equal(found(p, False)[0], [0.0])
    assert len(found(p, True)[0]) == 0


def test_nothing_has_no_zeros() -> None:
    assert len(found(np.zeros(20), False)[0]) == 0


def test_extremes_are_those_of_a_dense_scan(rng: np.random.Generator) -> None:
    x, nodes = np.linspace(0, 1, 20_001), np.empty(9)
    for _ in range(100):
        a, b = rng.uniform(0, 6.3), rng.uniform(0.2, 2.5)
        k = np.arange(20)
        p = np.cos(a + k * np.pi / 2) * b**k / np.cumprod(np.maximum(k, 1))  # cos(a + b x)
        low, high = extremes(p, np.inf, -np.inf, nodes)
        scan = np.polynomial.polynomial.polyval(x, p)
        assert (low, high) == (pytest.approx(scan.min(), abs=1e-8), pytest.approx(scan.max(), abs=1e-8))
        assert low <= scan.min() + 1e-14
        assert high >= scan.max() - 1e-14
        assert extremes(p, low - 0.5, high + 0.5, nodes) == (low - 0.5, high + 0.5)
        assert extremes(p, low + 1e-9, high - 1e-9, nodes) == (low, high)

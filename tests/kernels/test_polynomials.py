"""Sign changes and extremes of polynomials, against polynomials made of known roots and dense scans."""

import numpy as np
import pytest

from tippetop_kernels.polynomials import crossings, extremes, jet, ranges, value


def found(p: np.ndarray, positive: bool) -> tuple[np.ndarray, bool]:
    out = np.empty(16)
    n, now = crossings(p, positive, out, np.empty_like(p), False)
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
        low, high = extremes(p, np.inf, -np.inf, nodes, False)
        scan = np.polynomial.polynomial.polyval(x, p)
        assert (low, high) == (pytest.approx(scan.min(), abs=1e-8), pytest.approx(scan.max(), abs=1e-8))
        assert low <= scan.min() + 1e-14
        assert high >= scan.max() - 1e-14
        assert extremes(p, low - 0.5, high + 0.5, nodes, False) == (low - 0.5, high + 0.5)
        assert extremes(p, low + 1e-9, high - 1e-9, nodes, False) == (low, high)


def test_ranges_hold_what_they_bound(rng: np.random.Generator) -> None:
    """Sines of all phases and lengths: no value of a dense scan lies outside, and what is called monotone is; then
    zeros and extremes by the short way are those by the long one."""
    lanes, n = 64, 21
    k, h = np.arange(n + 1), rng.uniform(0.1, 2, lanes)
    a = rng.uniform(0, 6.3, lanes)
    c = np.cos(a + k[:, None] * np.pi / 2) / np.cumprod(np.maximum(k, 1))[:, None]
    for shift in (0, 1):
        factors = h ** k[:, None] * (k[:, None] + 1) ** shift
        low, high, monotone = np.empty((3, lanes))
        ranges(c, shift, factors, low, high, monotone, np.empty((3, lanes)))
        p = c[shift:] * factors[: n + 1 - shift]
        scan = np.polynomial.polynomial.polyval(np.linspace(0, 1, 2001), p)
        assert np.all(low <= scan.min(axis=1) + 1e-14)
        assert np.all(high >= scan.max(axis=1) - 1e-14)
        rises = np.diff(scan, axis=1)
        steady = (rises > 0).all(axis=1) | (rises < 0).all(axis=1)
        assert np.all(steady[monotone > 0])
        assert np.mean(monotone[steady]) > 0.6  # it is worth having
        for i in np.flatnonzero(monotone):
            q, out, work, nodes = p[:, i].copy(), np.empty(n), np.empty(len(p)), np.empty(9)
            long, now = crossings(q, q[0] > 0, out, work, False)
            at = out[0]
            assert (long, now) == crossings(q, q[0] > 0, out, work, True)
            assert long == 0 or out[0] == pytest.approx(at, abs=1e-15)
            short = extremes(q, np.inf, -np.inf, nodes, True)
            assert short == pytest.approx(extremes(q, np.inf, -np.inf, nodes, False), abs=1e-15)


@pytest.mark.parametrize("n", [1, 2, 5, 20, 21])
def test_jet_is_value_and_derivatives(n: int, rng: np.random.Generator) -> None:
    p, x = rng.normal(size=n), 0.7
    q = np.polynomial.Polynomial(p)
    expected = q(x), q.deriv()(x), q.deriv(2)(x) / 2
    np.testing.assert_allclose(jet(p, x), expected, rtol=1e-12, atol=1e-12)

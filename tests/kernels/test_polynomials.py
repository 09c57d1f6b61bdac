"""Sign changes and extremes of polynomials, against polynomials made of known roots and dense
scans.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from limits import assert_near
from numpy.polynomial.polynomial import polyval
from polynomials import crossings, extremes, ranges


def test_two_zeros_that_nearly_meet_are_crossings(rng: np.random.Generator) -> None:
    """Where a function just dips beyond zero, as v^2 - 1e-12 does: both zeros, to what rounding
    leaves of them; none where they are nearer than a millionth.
    """
    for gap in (1e-1, 1e-3, 1e-5, 3e-6, 6e-7, 1e-8):
        for sign in (1.0, -1.0):
            middle = rng.uniform(0.05, 0.95)
            others = np.polynomial.polynomial.polyfromroots(
                rng.choice([-1, 1], 4) * rng.uniform(1.5, 4, 4)
            )
            pair = np.array([middle**2 - gap**2 / 4, -2 * middle, 1.0])
            p = np.zeros(20)
            p[:7] = sign * np.polynomial.polynomial.polymul(pair, others / abs(others[0]))
            zeros, now = crossings(p, bool(p[0] > 0))
            assert now == (p[0] > 0)
            assert len(zeros) == (2 if gap > 1e-6 else 0), gap
            if len(zeros):
                assert_near(zeros, middle + np.array([-0.5, 0.5]) * gap, 1e-15 / gap + 1e-15)


def test_a_zero_between_two_steps_counts_once() -> None:
    """The step before ended negative, this one starts positive: rounding put the zero
    between them.
    """
    p = np.array([1e-17, 1.0, 0.0])
    np.testing.assert_array_equal(crossings(p, False)[0], [0.0])
    assert len(crossings(p, True)[0]) == 0


@pytest.mark.parametrize("n", [20, 33, 46, 47])
def test_polynomials_of_the_highest_orders_are_searched(n: int, rng: np.random.Generator) -> None:
    """cos(a + 3 x) to as many coefficients as quadruple precision has: no table ends
    before them.
    """
    k = np.arange(n)
    for a in rng.uniform(0, 6.3, 40):
        p = np.cos(a + k * np.pi / 2) * 3.0**k / np.cumprod(np.maximum(k, 1.0))
        out, _ = crossings(p, bool(p[0] > 0))
        zeros = (np.arange(-3, 6) + 0.5) * np.pi - a
        inside = zeros[(zeros > 0) & (zeros < 3)] / 3
        assert_near(out, inside, 1e-14 if n > 20 else 1e-8)
        low, high, *_ = extremes(p, np.inf, -np.inf)
        turns = np.arange(-3, 6) * np.pi - a
        at = np.cos(a + np.concatenate([[0.0, 3.0], turns[(turns > 0) & (turns < 3)]]))
        assert (low, high) == pytest.approx((at.min(), at.max()), abs=1e-14 if n > 20 else 1e-8)


def test_ranges_hold_what_they_bound(rng: np.random.Generator) -> None:
    """Sines of all phases and lengths: no value of a dense scan lies outside, and most bounds are
    near one.
    """
    lanes, n = 32, 21
    k, h = np.arange(n + 1), rng.uniform(0.1, 2, lanes)
    a = rng.uniform(0, 6.3, lanes)
    c = np.cos(a + k[:, None] * np.pi / 2) / np.cumprod(np.maximum(k, 1))[:, None]
    for shift in (0, 1):
        factors = h ** k[:, None] * (k[:, None] + 1) ** shift
        low, high = ranges(c, shift, h)
        p = c[shift:] * factors[: n + 1 - shift]
        scan = np.polynomial.polynomial.polyval(np.linspace(0, 1, 2001), p)
        least, most = scan.min(axis=1), scan.max(axis=1)
        assert np.all(low <= least + 1e-14)
        assert np.all(high >= most - 1e-14)
        assert np.median((high - low) / (most - least)) < 1.5


@settings(max_examples=200, deadline=None)
@given(arrays(float, 21, elements=st.floats(width=32)), st.booleans())
def test_zeros_and_extremes_of_any_numbers_lie_within_the_step(
    p: np.ndarray, positive: bool
) -> None:
    """NaN and infinities too; the last sign follows from the number of zeros."""
    zeros, now = crossings(p, positive)
    assert np.all(np.diff(zeros) >= 0)
    assert np.all((zeros >= 0) & (zeros <= 1))
    _, _, *places = extremes(p, 0.0, 0.0)
    assert all(np.isnan(at) or 0 <= at <= 1 for at in places)
    if np.isfinite(p).all() and abs(end := polyval(1.0, p)) > 1e-12 * np.abs(p).sum():
        assert now == (end > 0)

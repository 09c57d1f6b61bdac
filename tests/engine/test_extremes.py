"""Extremes of a rate and the moment it falls below zero, on steps whose polynomials are known."""

from math import factorial

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from tippetop.engine.extremes import Extremes, falls_below_zero, rate_extremes


ORDER = 20
TIMES = np.array([0.0, 0.4, 0.5, 1.1, 1.25, 2.0])
"""Steps of different lengths: extremes and zeros lie inside them and at their ends."""


def integral_of(rate: Polynomial, times: np.ndarray = TIMES) -> np.ndarray:
    """Taylor coefficients of an integral of the rate, in time since the start of each step, (n, ORDER + 1)."""
    whole = rate.integ(k=7.0)
    powers = [whole.deriv(k) if k else whole for k in range(ORDER + 1)]
    return np.array([[p(start) / factorial(k) for k, p in enumerate(powers)] for start in times[:-1]])


def places_of_extremes(stationary: np.ndarray, times: np.ndarray = TIMES) -> np.ndarray:
    """Where a rate can have its extremes: at both ends, and where its slope is known to vanish."""
    return np.concatenate([times[[0, -1]], stationary[(stationary > times[0]) & (stationary < times[-1])]])


def test_extremes_are_where_the_slope_has_its_roots(rng: np.random.Generator) -> None:
    """Rates made of the roots of their slopes: the extremes are at a root or at an end, whichever step that is in."""
    for _ in range(100):
        roots = rng.uniform(-0.5, 2.5, rng.integers(1, 6))
        rate = Polynomial.fromroots(roots).integ(k=rng.normal()) * rng.choice([-1, 1])
        values = rate(places_of_extremes(roots))
        found, size = rate_extremes(TIMES, integral_of(rate)), np.abs(values).max()
        assert found.least == pytest.approx(values.min(), abs=1e-13 * size)
        assert found.most == pytest.approx(values.max(), abs=1e-13 * size)
        assert rate(found.t_least) == pytest.approx(values.min(), abs=1e-12 * size)
        assert rate(found.t_most) == pytest.approx(values.max(), abs=1e-12 * size)
        assert np.all((TIMES[0] <= found[1]) & (found[3] <= TIMES[-1]))


def test_a_dip_between_the_nodes_is_refined() -> None:
    """A narrow dip whose bottom is at no node of any scan: its time too, to the root of the rounding."""
    bottom = 0.5 + 0.6 * 0.4142135623730951
    rate = 1.0 + 300.0 * Polynomial([-bottom, 1.0]) ** 2
    found = rate_extremes(TIMES, integral_of(rate))
    assert found.least == pytest.approx(1.0, abs=1e-12)
    assert found.t_least == pytest.approx(bottom, abs=1e-7)


def test_extremes_of_two_stretches_are_those_of_both(rng: np.random.Generator) -> None:
    """Whichever way the steps are cut in two; nothing, joined, changes nothing."""
    rate = Polynomial.fromroots([0.2, 0.9, 1.7]).integ()
    coefficients = integral_of(rate)
    whole = rate_extremes(TIMES, coefficients)
    for cut in range(1, len(TIMES) - 1):
        early, late = (
            rate_extremes(TIMES[: cut + 1], coefficients[:cut]),
            rate_extremes(TIMES[cut:], coefficients[cut:]),
        )
        assert early.joined(late) == late.joined(early)
        np.testing.assert_allclose(early.joined(late), whole, rtol=0, atol=1e-12)
        assert early.joined(Extremes()) == Extremes().joined(early) == early


@pytest.mark.parametrize("zero", [0.13, 0.4, 0.77, 1.9])
def test_a_rate_falls_below_zero_at_its_first_falling_root(zero: float) -> None:
    """Inside a step and between two; a later root does not count."""
    rate = Polynomial.fromroots([zero, zero + 2.0])
    assert rate(TIMES[0]) > 0
    assert falls_below_zero(TIMES, integral_of(rate)) == pytest.approx(zero, abs=1e-14)


def test_a_rate_that_is_negative_from_the_start_falls_there() -> None:
    assert falls_below_zero(TIMES, integral_of(Polynomial([-1.0, 0.1]))) == TIMES[0]


def test_a_rate_that_stays_positive_does_not_fall() -> None:
    """Nor one that comes down to a positive bottom, nor one that is zero."""
    assert falls_below_zero(TIMES, integral_of(1e-9 + Polynomial([-0.77, 1.0]) ** 2)) is None
    assert falls_below_zero(TIMES, np.zeros((len(TIMES) - 1, ORDER + 1))) is None


def test_steps_whose_rate_is_no_double_are_passed_over() -> None:
    """Of a run in longdouble whose steps shrink to nothing; before, a traceback."""
    rate = Polynomial([1.0, -2.0, 3.0])
    coefficients = integral_of(rate).astype(np.longdouble)
    whole = rate_extremes(TIMES[:4], coefficients[:3])
    coefficients[3:, -1] = np.longdouble("1e400")
    with np.errstate(over="ignore"):
        assert rate_extremes(TIMES, coefficients) == whole
        assert rate_extremes(TIMES[3:], coefficients[3:]) == Extremes()

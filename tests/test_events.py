"""The event log: which turnings are rounding, and what their amplitudes are."""

import numpy as np
import pytest

import tippetop
from tippetop.events import NOISE_FLOOR, amplitudes, significance


def test_all_large_swings_count() -> None:
    theta, sign = np.array([0.3, 0.1, 0.35, 0.08]), np.array([-1, 1, -1, 1])
    assert significance(theta, sign, end=0.2).tolist() == [True] * 4


def test_a_decay_that_ends_in_rounding_counts_nothing() -> None:
    theta, sign = np.pi - np.array([1e-16, 0.0, 2e-16, 0.0]), np.array([-1, 1, -1, 1])
    assert not significance(theta, sign, end=np.pi).any()


def test_a_turning_that_rounding_splits_into_three_counts_once() -> None:
    theta = np.array([0.1, 0.5, 0.5 - 1e-16, 0.5 + 1e-16, 0.1])
    sign = np.array([1, -1, 1, -1, 1])
    assert significance(theta, sign, end=0.4).tolist() == [True, False, False, True, True]


def test_the_last_turning_counts_only_if_theta_comes_back_from_it() -> None:
    theta, sign = np.array([0.5, 0.1]), np.array([-1, 1])
    assert significance(theta, sign, end=0.1 + NOISE_FLOOR / 10).tolist() == [True, False]
    assert significance(theta, sign, end=0.1 + NOISE_FLOOR * 10).tolist() == [True, True]


def test_amplitude_is_the_swing_since_the_turning_before() -> None:
    theta, turning = np.array([0.3, 1.57, 0.1, 0.35]), np.array([True, False, True, True])
    found = amplitudes(theta, turning, start=0.25)
    np.testing.assert_allclose(found, [0.05, np.nan, 0.2, 0.25], rtol=1e-14)


@pytest.mark.parametrize("assignments", [[], ["initial.phi=1.0"]])
def test_a_run_released_at_rest_does_not_log_its_start(assignments: list[str]) -> None:
    events = tippetop.run("inverting", assignments, until=0.5).events
    assert events.time[0] > 1e-3
    assert np.all(np.diff(events.theta_dot_sign) != 0), "minima and maxima alternate"


def test_settling_noise_is_marked_and_the_moment_is_logged_once() -> None:
    events = tippetop.run("inverting", ["run.output_step=1.0"], until=300).events
    turning = events.of("turning")
    assert len(events.of("settled").time) == 1
    assert turning.significant.sum() == 395
    assert (~turning.significant).sum() > 100
    assert turning.time[turning.significant].max() < 10 < turning.time[~turning.significant].min()


def test_sliding_that_dies_for_a_moment_has_not_settled() -> None:
    """In planar motion the contact velocity passes through zero at every swing."""
    run = tippetop.run("inverting", ["initial.omega3=0.0"], until=1.0)
    assert len(run.events.of("settled").time) == 0

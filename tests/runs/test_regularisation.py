"""With a regularised Coulomb law eps decides when a top inverts."""

import examples
import numpy as np
import pytest

from tippetop.runs.regularisation import inversion_sensitivity
from tippetop.scenario.build import load


def test_published_times_of_the_leine_glocker_top() -> None:
    """90 degrees at 1.05 s for eps = 1e-2 m/s."""
    found = inversion_sensitivity(load("leine-glocker", until=3.0))
    times = found["inversion_time"]
    assert times[0.01] == pytest.approx(1.05, abs=0.005)
    assert times[0.005] > times[0.01] > times[0.02]
    line = np.polyfit(np.log([0.005, 0.02]), np.log([times[0.005], times[0.02]]), 1)
    assert found["exponent"] == pytest.approx(line[0], rel=1e-12)
    assert -1 < found["exponent"] < 0, "a smaller eps inverts later, and not in proportion"


def test_a_top_that_does_not_invert_in_time_has_no_exponent() -> None:
    """Between 1.05 s and 1.25 s, where eps = 0.005 m/s has not inverted yet."""
    found = inversion_sensitivity(load("leine-glocker", until=1.1))
    assert found["inversion_time"][0.005] is None
    assert found["inversion_time"][0.01] == pytest.approx(1.05, abs=0.005)
    assert found["exponent"] is None


@pytest.mark.slow
def test_published_times_for_smaller_eps() -> None:
    """2.71 s for eps = 1e-3 m/s."""
    found = inversion_sensitivity(load("leine-glocker", ["friction.eps=0.001"], until=6.0), factor=10.0)
    assert found["inversion_time"][0.001] == pytest.approx(2.71, abs=0.01)
    assert found["inversion_time"][0.01] == pytest.approx(1.05, abs=0.005)


def test_viscous_friction_has_no_eps() -> None:
    made = examples.problem("tippe-top", examples.CANONICAL, {"theta": 0.1}, 1.0, ("viscous", {"mu": 0.3}))
    assert inversion_sensitivity(made) == {}

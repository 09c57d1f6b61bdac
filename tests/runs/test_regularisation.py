"""With a regularised Coulomb law eps decides when a top inverts."""

import examples
import numpy as np
import pytest

from tippetop.runs import forecast, regularisation
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
    found = inversion_sensitivity(
        load("leine-glocker", ["friction.eps=0.001"], until=6.0), factor=10.0
    )
    assert found["inversion_time"][0.001] == pytest.approx(2.71, abs=0.01)
    assert found["inversion_time"][0.01] == pytest.approx(1.05, abs=0.005)


def test_viscous_friction_has_no_eps() -> None:
    made = examples.problem(
        "tippe-top", examples.CANONICAL, {"theta": 0.1}, 1.0, ("viscous", {"mu": 0.3})
    )
    assert inversion_sensitivity(made) == {}


STIFF = ["friction.eps=1e-6"]  # 0.001 mm/s: 30 slices of steps, and theta = pi/2 is not reached


def test_the_steps_of_its_runs_are_bounded_and_what_was_not_found_out_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A top of which eps is so small that its steps are short: no time is given, and no `never`."""
    monkeypatch.setattr(regularisation, "MOST_STEPS", 1)  # to a slice
    problem = load("leine-glocker", STIFF, until=3.0)
    found = inversion_sensitivity(problem)
    assert found["unknown"] == [5e-7, 1e-6, 2e-6]
    assert found["inversion_time"] == {}
    assert found["exponent"] is None
    said = forecast.assessment(problem)
    assert "eps = 0.0005, 0.001, 0.002 mm/s was not found out" in said["regularisation"]
    assert "inversion_by_eps" not in said


def test_no_run_goes_on_when_the_time_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first theta = pi/2 of a run of 300 s is that of one of 3 s, and the rest of it is not
    integrated.
    """
    short = inversion_sensitivity(load("leine-glocker", until=3.0))
    monkeypatch.setattr(regularisation, "MOST_STEPS", 1)
    assert inversion_sensitivity(load("leine-glocker", until=300.0)) == short

"""Every reference trajectory, in every form that can follow it."""

import dataclasses

import examples
import numpy as np
import pytest
from limits import assert_near

from tippetop.engine.status import Status
from tippetop.runs.run import solve


# double precision; the inversion amplifies rounding a thousandfold, the cylinder turns over sixteen
# times
CASES = [
    ("case1_inverting", "tippe-top", "vector", 2e-12),
    ("case3_noninverting_low", "tippe-top", "vector", 1e-14),
    ("case3_noninverting_low", "tippe-top", "euler", 1e-13),
    ("case4_gliding_hst", "gliding-heavy-top", "vector", 1e-13),
    ("case4_gliding_hst", "gliding-heavy-top", "euler", 1e-13),
    ("case5_cylinder", "gliding-cylinder", "angle", 1e-12),
    ("case5b_cylinder_round", "gliding-cylinder", "angle", 1e-13),
    ("case6_rolling", "rolling-tippe-top", "vector", 1e-12),
    ("case6_rolling", "rolling-tippe-top", "contact", 3e-13),
    ("case6_rolling", "rolling-tippe-top", "euler", 2e-12),
    ("case7_hst", "heavy-top", "vector", 1e-13),
    ("case7_hst", "heavy-top", "euler", 1e-13),
]


@pytest.mark.parametrize(("name", "system", "form", "tolerance"), CASES)
def test_reference(name: str, system: str, form: str, tolerance: float) -> None:
    case = examples.reference(name, system, form)
    made = solve(case.problem)
    assert made.status is Status.FINISHED
    found = examples.columns(made)
    for column in found.keys() & case.values.keys():
        least = 1.0 if column in ("theta", "axis", "x") else 0.0
        size = max(least, np.abs(case.values[column]).max()) or 1.0
        error = np.abs(found[column] - case.values[column]).max() / size
        assert error < tolerance, f"{column}: {error:.1e}"
    turning = made.events.of("turning", significant=True)
    assert len(turning.time) == len(case.turnings)
    assert_near(turning.time, case.turnings, 1e-12)
    assert_near(turning.theta, case.turning_angles, 10 * tolerance)
    assert np.all(
        np.diff(turning.theta_dot_sign) != 0
    )  # minima and maxima alternate: none missed, none twice


def test_the_inversion_crosses_the_equator_when_it_should() -> None:
    """Three crossings of pi/2, and pi - 0.1 at 6.94384761678 s."""
    case = examples.reference("case1_inverting", "tippe-top", "vector")
    made = solve(case.problem)
    expected = [t for level, t in case.crossings if level == "pi/2"]
    assert_near(made.events.of("equator").time, expected, 1e-10)
    assert made.report["inversion"]["inverted_at"] == pytest.approx(6.943847616774212, abs=1e-10)
    assert made.report["normal_force"]["min"] == pytest.approx(0.286874 * 0.1964, rel=1e-5)
    assert made.report["normal_force"]["max"] == pytest.approx(1.756894 * 0.1964, rel=1e-5)


@pytest.mark.parametrize("precision", ["longdouble", "quad"])
def test_more_digits_agree_with_the_reference(precision: str) -> None:
    """Half a second of the inversion, to what 80 bits can show."""
    case = examples.reference("case1_inverting", "tippe-top", "vector", precision)
    until = 0.5
    made = solve(
        dataclasses.replace(case.problem, until=until, times=case.times[case.times <= until])
    )
    n = len(made.times)
    assert np.abs(examples.columns(made)["theta"] - case.values["theta"][:n]).max() < 3e-16
    t = made.events.of("turning").time
    assert_near(t, case.turnings[case.turnings < until], 2e-16)

"""How near a top comes to a pole: the closest approach from V and E~ against integration in vector
form.
"""

import math

import examples
import numpy as np
import pytest

from tippetop.mechanics.theory.poles import closest_approach
from tippetop.problem import Problem, Problems
from tippetop.runs.run import solve


def distances(problem: Problem | Problems) -> np.ndarray:
    """(2,) or (2, n): least theta and least pi - theta."""
    problems = problem.alone if isinstance(problem, Problem) else problem
    scalars = problems.base.form.scalars(problems.record(problems.start), problems.internal_body)
    return np.squeeze(closest_approach(problems.base.system, scalars, problems.internal_body))


STARTS = [
    (
        "rolling-tippe-top",
        examples.CANONICAL,
        {"theta": 1e-3, "theta_dot": 2.0, "omega3": 50.0},
        2.0,
    ),
    (
        "rolling-tippe-top",
        examples.CANONICAL,
        {"theta": 0.5, "theta_dot": 30.0, "phi_dot": 1e-3, "omega3": 1e-3},
        1.0,
    ),
    (
        "rolling-tippe-top",
        examples.CANONICAL,
        {"theta": 2.5, "phi_dot": -8.0, "omega3": 155.0},
        2.0,
    ),
    ("rolling-tippe-top", examples.CANONICAL, {"theta": 3.14, "phi_dot": 4.0, "omega3": 3.0}, 2.0),
    ("heavy-top", examples.HEAVY, {"theta": 0.4, "phi_dot": 5.0, "omega3": 300.0}, 2.0),
    (
        "heavy-top",
        examples.HEAVY,
        {"theta": 1e-3, "theta_dot": 1.0, "phi_dot": 3.0, "omega3": 30.0},
        2.0,
    ),
]


@pytest.mark.parametrize(("system", "parameters", "start", "until"), STARTS)
def test_the_turning_angles_nearest_to_the_poles(
    system: str, parameters: dict, start: dict, until: float
) -> None:
    """Of the vector form, which knows no poles."""
    run = solve(examples.problem(system, parameters, start, until))
    theta = run.events.of("turning").theta
    assert len(theta) > 1
    found = distances(run.problem)
    np.testing.assert_allclose(found, [theta.min(), math.pi - theta.max()], rtol=1e-5)


def test_a_swing_through_a_pole_reaches_it() -> None:
    """No spin and no azimuth: the axis passes the vertical."""
    made = examples.problem(
        "rolling-tippe-top", examples.CANONICAL, {"theta": 0.3, "theta_dot": -5.0}, 1.0
    )
    assert distances(made)[0] == 0
    assert distances(made)[1] > 0.1


def test_next_to_a_pole_the_wall_is_the_centrifugal_one() -> None:
    """sin(theta) = |phi' sin(theta)^2| over the speed of the axis, whichever top of many."""
    base = examples.problem(
        "rolling-tippe-top", examples.CANONICAL, {"theta": 1e-4, "theta_dot": 2.0}, 1.0
    )
    varied = {"initial.theta": [1e-4, 1e-5, 1e-6], "initial.theta_dot": [2.0, 3.0, -4.0]}
    problems = Problems.vary(
        base, {**varied, "initial.phi_dot": [2e3, -2e4, 1e5], "initial.omega3": [0.0, 10.0, 20.0]}
    )
    scalars = base.form.scalars(problems.record(problems.start), problems.internal_body)
    expected = np.abs(scalars.phi_dot_s2) / np.sqrt(scalars.axis_speed2)
    np.testing.assert_allclose(distances(problems)[0], expected, rtol=1e-3)

"""Periods of the motions whose theta is periodic: by quadrature in 30 digits, theory and runs."""

import examples
import pytest

from tippetop.runs.run import solve


ROUND = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 4e-6, "g": 9.82}
FAST = {"theta": 1.0, "phi_dot": 10.0, "omega3": 100.0}
SLIM = {"theta": 0.5, "phi_dot": 5.0, "omega3": 300.0}
PERIODS = [
    ("rolling-cylinder", ROUND, {"theta": 0.5}, 0.5329210375359308, -0.5),
    ("rolling-cylinder", ROUND, {"theta": 2.0}, 0.8321650553406782, -2.0),
    ("heavy-top", examples.SLENDER, SLIM, 0.08332549321234158, 0.46196524721933895),
    ("rolling-tippe-top", examples.CANONICAL, FAST, 0.05405845287215864, 0.83867185863810919),
    ("tippe-top", examples.CANONICAL, FAST, 0.06011604153899423, 0.79505511802680335),
    ("gliding-heavy-top", examples.SLENDER, SLIM, 0.04697105057746059, 0.48028100380708158),
]


@pytest.mark.parametrize(("system", "parameters", "initial", "period", "other"), PERIODS)
def test_the_period_is_that_of_quadrature(
    system: str, parameters: dict, initial: dict, period: float, other: float
) -> None:
    """`other` is the angle of the first turning; the motion begins at the second."""
    made = examples.problem(system, parameters, initial, 3.2 * period)
    turning = solve(made).events.of("turning", significant=True)
    assert turning.time[2] - turning.time[0] == pytest.approx(period, rel=1e-12)
    assert turning.theta[0] == pytest.approx(other, rel=1e-12)

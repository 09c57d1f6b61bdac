"""Periods of the motions whose theta is periodic: by quadrature in 30 digits, theory and runs."""

import math
from typing import Any

import examples
import laws
import pytest

from tippetop.mechanics.theory import nutation
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
    b, start, used = examples.si(made), examples.at_start(made), made.system
    inertia: Any = lambda z: used.theta_inertia(z, b)  # noqa: E731
    V: Any = lambda z: used.potential(z, *(start[name] for name in used.momenta), b)  # noqa: E731
    if used.frictional:
        Lz, L3 = spin(initial, b)
        inertia, V = (
            lambda z: laws.vertical_inertia(z, b),
            lambda z: laws.vertical_potential(z, Lz, L3, b),
        )
    limits = (-math.pi, math.pi) if "cylinder" in system else (0.0, math.pi)
    energy = V(math.cos(initial["theta"]))  # theta' = 0
    found = nutation.nutation(inertia, V, energy, initial["theta"], limits)
    assert found.period == pytest.approx(period, rel=1e-12)
    assert min(abs(found.theta_min - other), abs(found.theta_max - other)) < 1e-13
    turning = solve(made).events.of("turning", significant=True)
    assert turning.time[2] - turning.time[0] == pytest.approx(period, rel=1e-12)
    assert turning.theta[0] == pytest.approx(other, rel=1e-12)


def spin(initial: dict[str, float], b: Any) -> tuple[float, float]:
    """Return L_z and L_3 of a start about the centre of mass."""
    s, z, L3 = math.sin(initial["theta"]), math.cos(initial["theta"]), b.I3 * initial["omega3"]
    return b.I1 * initial["phi_dot"] * s**2 + L3 * z, L3

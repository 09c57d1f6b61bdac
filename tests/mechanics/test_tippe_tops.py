"""The rolling and gliding tippe top: what only they have."""

import math

import examples
import laws
import numpy as np
import pytest

from tippetop.engine.status import Status
from tippetop.mechanics.contact import body as contact
from tippetop.mechanics.contact.gliding import euler as gliding_euler
from tippetop.mechanics.systems import SYSTEMS, tippe_top
from tippetop.mechanics.theory import nutation
from tippetop.runs.run import solve


VISCOUS = ("viscous", {"mu": 0.3})
FAST = {
    "theta": 1.0,
    "phi_dot": 10.0,
    "omega3": 100.0,
}  # periods below: computed by quadrature in 30 digits


def significant_turnings(made) -> tuple[np.ndarray, np.ndarray]:
    turning = made.events.of("turning", significant=True)
    return turning.time, turning.theta


def test_period_of_the_rolling_tippe_top() -> None:
    made = examples.problem("rolling-tippe-top", examples.CANONICAL, FAST, 0.2)
    b, start = examples.si(made), examples.at_start(made)
    found = nutation.nutation(
        lambda z: tippe_top.theta_inertia(z, b),
        lambda z: tippe_top.potential(z, start["routh"], start["jellett"], b),
        start["energy"],
        1.0,
    )
    assert found.period == pytest.approx(0.05405845287215864, rel=1e-13)
    assert found.theta_min == pytest.approx(0.83867185863810919, rel=1e-13)
    times, angles = significant_turnings(solve(made))
    assert times[2] - times[0] == pytest.approx(0.05405845287215864, rel=1e-12)
    assert angles[0] == pytest.approx(0.83867185863810919, rel=1e-12)


@pytest.mark.parametrize(
    ("system", "parameters", "initial", "period", "other"),
    [
        ("tippe-top", examples.CANONICAL, FAST, 0.06011604153899423, 0.79505511802680335),
        (
            "gliding-heavy-top",
            examples.SLENDER,
            {"theta": 0.5, "phi_dot": 5.0, "omega3": 300.0},
            0.04697105057746059,
            0.48028100380708158,
        ),
    ],
)
def test_period_without_friction(
    system: str, parameters: dict, initial: dict, period: float, other: float
) -> None:
    made = examples.problem(system, parameters, initial, 3.2 * period)
    b, s, z = examples.si(made), math.sin(initial["theta"]), math.cos(initial["theta"])
    start = SYSTEMS[system].start(initial, s, z, b)
    scalars = gliding_euler.euler_scalars(start._replace(theta=initial["theta"]), b)
    found = nutation.nutation(
        lambda z: laws.vertical_inertia(z, b),
        lambda z: laws.vertical_potential(z, scalars.Lz, scalars.L3, b),
        contact.energy(scalars, b) - b.m * scalars.speed2 / 2,
        initial["theta"],
    )
    assert found.period == pytest.approx(period, rel=1e-12)
    assert min(abs(found.theta_min - other), abs(found.theta_max - other)) < 1e-13
    times, angles = significant_turnings(solve(made))
    assert times[2] - times[0] == pytest.approx(period, rel=1e-12)
    assert angles[0] == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize("form", ["vector", "euler"])
@pytest.mark.parametrize("until", [100.0, pytest.param(1e4, marks=pytest.mark.slow)])
def test_rolling_keeps_its_integrals(form: str, until: float) -> None:
    """lambda, D and E drift by rounding alone: 2e-16 times the root of the number of steps, times a
    few.
    """
    made = examples.run(
        "rolling-tippe-top",
        examples.CANONICAL,
        {"theta": 1.0, "phi_dot": 20.0, "omega3": 60.0},
        until,
        form=form,
        events=(),
    )
    bound = 5 * 2.2e-16 * math.sqrt(made.report["steps"])
    assert made.status is Status.FINISHED
    assert max(made.report["drift"].values()) < bound


@pytest.mark.parametrize("theta", [0.0, math.pi])
@pytest.mark.parametrize(
    "system", ["tippe-top", "rolling-tippe-top", "gliding-heavy-top", "heavy-top"]
)
def test_exact_start_at_a_pole_stays_there(system: str, theta: float) -> None:
    """The spinning states are solutions; nothing divides by sin(theta), no digit of theta moves."""
    parameters = examples.HEAVY if "heavy" in system else examples.CANONICAL
    friction = VISCOUS if SYSTEMS[system].frictional else ("none", {})
    made = examples.run(system, parameters, {"theta": theta, "omega3": 100.0}, 1.0, friction)
    rows = examples.columns(made)
    assert made.status is Status.FINISHED
    assert np.all(rows["theta"] == (math.pi if theta else 0.0))
    assert np.all(np.isnan(rows["phi"]))
    assert made.report["drift"]["axis_norm"] == 0.0


@pytest.mark.parametrize(
    ("law", "numbers"),
    [
        ("coulomb", {"mu": 0.3, "eps": 0.01}),
        ("mixed", {"mu": 0.1, "mu_coulomb": 0.2, "eps": 0.01}),
        ("stribeck", {"mu": 0.2, "mu_static": 0.4, "v_s": 0.1, "eps": 0.01}),
        ("latitude", {"mu": 0.3, "mu_stem": 0.1}),
    ],
)
def test_every_friction_law_balances_the_energy(law: str, numbers: dict[str, float]) -> None:
    made = examples.run(
        "tippe-top", examples.CANONICAL, {"theta": 0.3, "omega3": 60.0}, 2.0, (law, numbers)
    )
    assert made.status is Status.FINISHED
    assert made.report["drift"]["jellett"] < 1e-13
    assert made.report["drift"]["energy_balance"] < 1e-12
    assert np.all(examples.columns(made)["friction_power"] >= 0)

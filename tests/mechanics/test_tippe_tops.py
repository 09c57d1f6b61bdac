"""The rolling and gliding tippe top: what only they have."""

import math

import examples
import numpy as np
import pytest

from tippetop.engine.status import Status
from tippetop.mechanics.systems import SYSTEMS


VISCOUS = ("viscous", {"mu": 0.3})


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

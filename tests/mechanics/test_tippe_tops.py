"""The rolling and gliding tippe top: what only they have."""

import math

import examples
import numpy as np
import pytest

from tippetop.engine.status import Status
from tippetop.mechanics.systems import SYSTEMS


VISCOUS = ("viscous", {"mu": 0.3})


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

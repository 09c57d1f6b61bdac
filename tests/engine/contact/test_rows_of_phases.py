"""What a row says of the forces, in each phase of the contact: against what they do to energy and
momentum.
"""

import numpy as np
import pytest
from limits import assert_near
from scipy.interpolate import CubicSpline
from test_both import STEM, Z
from test_phases_of_runs import run
from touching import LEINE_GLOCKER


VISCOUS = {"law": "viscous", "mu": 2.0}
COULOMB = {"law": "coulomb", "mu": 0.3}
DRILLING = {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 1e-4}
BOTH = {"theta": float(np.arccos(Z)), "phi_dot": -20.0, "omega3": 60.0, "centre_at_rest": True}
SLIDING = {"theta": 1.0, "omega3": 100.0, "phi_dot": 5.0, "nu_x": 0.3, "nu_y": -0.2}


@pytest.mark.parametrize(
    ("friction", "start", "phase"),
    [
        (VISCOUS, SLIDING, 0),
        (COULOMB, SLIDING, 0),
        (DRILLING, SLIDING, 0),
        (VISCOUS, BOTH, 3),
        (DRILLING, BOTH, 3),
    ],
)
def test_the_power_of_friction_is_what_energy_falls_by(
    friction: dict, start: dict, phase: int
) -> None:
    done = run(LEINE_GLOCKER, friction=friction, initial=start, stem=STEM, contact={}, until=0.01)
    columns = done.columns()
    assert (columns["phase"].values == phase).all()
    t, power = columns["time"].values, columns["friction_power"].values
    falls = -CubicSpline(t, columns["energy"].values)(t, 1)
    assert power.min() > 0
    assert_near(falls[5:-5], power[5:-5], 1e-6, relative=True)

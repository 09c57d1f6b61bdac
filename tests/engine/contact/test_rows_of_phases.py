"""What a row says of the forces, in each phase of the contact: against what they do to energy and momentum."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from test_both import STEM, Z
from test_phases_of_runs import LEINE_GLOCKER, run
from tippetop.mechanics.contact.phases.both import BOTH_KINDS, stem
from tippetop.mechanics.contact.phases.drilling import (
    LEAST_PATCH,
    RESTS_BELOW,
    Scalars,
    patch_speed2,
    speed_beyond_rest,
)

from tippetop.engine.status import Status
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import Viscous
from tippetop.mechanics.operand import Vector


VISCOUS = {"law": "viscous", "mu": 2.0}
COULOMB = {"law": "coulomb", "mu": 0.3}
DRILLING = {"law": "contensou", "mu": 0.3, "patch": 5e-4, "mu_r": 1e-4}
BOTH = {"theta": float(np.arccos(Z)), "phi_dot": -20.0, "omega3": 60.0, "centre_at_rest": True}
SLIDING = {"theta": 1.0, "omega3": 100.0, "phi_dot": 5.0, "nu_x": 0.3, "nu_y": -0.2}


@pytest.mark.parametrize(
    ("friction", "start", "phase"),
    [(VISCOUS, SLIDING, 0), (COULOMB, SLIDING, 0), (DRILLING, SLIDING, 0), (VISCOUS, BOTH, 3), (DRILLING, BOTH, 3)],
)
def test_the_power_of_friction_is_what_energy_falls_by(friction: dict, start: dict, phase: int) -> None:
    done = run(LEINE_GLOCKER, friction=friction, initial=start, stem=STEM, contact={}, until=0.01)
    columns = done.columns()
    assert (columns["phase"].values == phase).all()
    t, power = columns["time"].values, columns["friction_power"].values
    falls = -CubicSpline(t, columns["energy"].values)(t, 1)
    assert power.min() > 0
    np.testing.assert_allclose(falls[5:-5], power[5:-5], rtol=0, atol=1e-6 * power.max())


def test_what_rolls_keeps_its_energy() -> None:
    """Of which the vertical velocity of the centre of mass is a part."""
    start = {"theta": 1.0, "omega3": 100.0, "phi_dot": 5.0, "theta_dot": 3.0}
    columns = run(LEINE_GLOCKER, friction={"law": "coulomb", "mu": 1.0}, initial=start, until=0.01).columns()
    assert (columns["phase"].values == 1).all()
    energy, theta = columns["energy"].values, columns["theta"].values
    assert np.ptp(energy) < 1e-13 * energy[0]
    assert np.ptp(theta) > 0.005
    assert np.abs(columns["friction_power"].values).max() < 1e-16
    assert np.abs(columns["nu_z"].values).max() < 1e-15


def test_the_mass_answers_to_the_sum_of_the_forces(rng: np.random.Generator) -> None:
    """Of bodies of any mass; in runs the mass is the unit."""
    kind = BOTH_KINDS["both"]
    for _ in range(20):
        m, R, c, I1, I3, g, clearance, lever = rng.uniform(0.5, 2.0, 8)
        body = Touch(m, R, c, I1, I3, g, Viscous(0.3), clearance, -lever)
        q = kind.form.units._make(rng.uniform(-1, 1, len(kind.form.units)))
        force, rates = kind.says(q, body).force, kind.form.rates(q, body)
        assert (rates.rx_dot * m, rates.ry_dot * m) == pytest.approx((force.x, force.y), rel=1e-12)


def test_the_other_ball_of_the_stem_is_the_sphere(rng: np.random.Generator) -> None:
    body = Touch(*rng.uniform(0.5, 2.0, 6), Viscous(0.3), *rng.uniform(0.5, 2.0, 2))
    again = stem(stem(body))
    assert again.friction == body.friction
    assert again._replace(friction=0.0) == pytest.approx(body._replace(friction=0.0), rel=1e-15)


def test_a_disc_that_neither_slides_nor_turns_ends_its_run() -> None:
    start = {"theta": np.pi - 0.3, "omega3": 0.3, "nu_x": 0.02}
    done = run(LEINE_GLOCKER, friction=DRILLING, initial=start, until=1.0)
    assert done.status is Status.ENDED
    assert "disc comes to rest" in done.reason


@pytest.mark.parametrize("patch", [LEAST_PATCH, 1e-3])
@pytest.mark.parametrize("turns", [False, True])
def test_a_disc_rests_below_a_speed_of_its_size(patch: float, turns: bool) -> None:
    """Of its sliding, or of its edge; also where that is the speed below which its friction is smooth."""
    b = SimpleNamespace(friction=SimpleNamespace(patch=patch))
    for share in (0.999, 1.001):
        slides, turning = (0.0, share * RESTS_BELOW) if turns else (share * RESTS_BELOW * patch, 0.0)
        s = Scalars(0.0, 0.0, 1.0, slides**2, patch_speed2(Vector(0.0, 0.0, turning), b))
        assert np.sign(speed_beyond_rest(s, b)) == np.sign(share - 1)

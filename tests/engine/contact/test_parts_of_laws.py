"""Rolling resistance and a drilling torque beside any friction law: closed forms, and Newton and
Euler in space.
"""

import numpy as np
import pytest
import tilted
from examples import columns
from limits import assert_below
from refusals import refusal
from touching import LEINE_GLOCKER

import tippetop as tt
from tippetop.runs import forecast
from tippetop.runs.run import solve
from tippetop.scenario.build import problem


MU_R, MU_D = 2e-4, 1e-4
TOP = tt.TippeTop(**LEINE_GLOCKER)
LAWS = {
    "viscous": {"law": "viscous", "mu": 0.3},
    "coulomb": {"law": "coulomb", "mu": 0.3},
    "stribeck": {"law": "stribeck", "mu": 0.2, "mu_static": 0.3, "v_s": 0.1, "eps": 0.01},
    "none": {"law": "none"},
    "contensou": {"law": "contensou", "mu": 0.3, "patch": 2e-3},
}
SLIDING = {"theta": 1.0, "omega3": 50.0, "phi_dot": 3.0, "nu_x": 0.3, "nu_y": -0.1}


def scenario(friction, until=0.2, parameters=LEINE_GLOCKER, parts=True, **tables):
    """A run under a law, with both parts unless it has others."""
    more = {"mu_r": MU_R, "mu_d": MU_D} if parts is True else parts or {}
    run = {"until": until} | tables.pop("run", {})
    return problem(
        {"system": "tippe-top", "parameters": parameters, "friction": friction | more, "run": run}
        | tables
    )


@pytest.mark.parametrize("law", ["viscous", "coulomb", "none"])
def test_an_upright_spin_falls_linearly(law):
    """I3 omega3' = -mu_d m g."""
    done = solve(scenario(LAWS[law], initial={"omega3": 50.0}))
    c = columns(done)
    expected = 50.0 - MU_D * TOP.m * TOP.g / TOP.I3 * c["time"]
    np.testing.assert_allclose(c["omega3"], expected, rtol=1e-13)


def torque(omega):
    """Return rolling resistance and drilling torque, per normal force."""
    still = 1e-6 * np.sqrt(TOP.g / TOP.R)
    rolls = -MU_R / np.sqrt(omega[0] ** 2 + omega[1] ** 2 + still**2)
    return omega * [rolls, rolls, -MU_D / np.hypot(omega[2], still)]


ROLLING = {"theta": 1.0, "omega3": 20.0, "phi_dot": 3.0, "nu_x": 0.0}
RESTING = {"theta": 0.5, "theta_dot": 8.0, "omega3": 4.0}  # Omega_z = 0
RESTING["phi_dot"] = -4.0 * np.cos(0.5) / np.sin(0.5) ** 2


@pytest.mark.parametrize(
    ("law", "start", "phase", "force"),
    [
        ("viscous", SLIDING, 0, tilted.sliding(lambda v: 0.3, torque)),
        ("coulomb", SLIDING | {"nu_x": 1.0}, 0, tilted.sliding(lambda v: 0.3 / v, torque)),
        ("coulomb", ROLLING, 1, tilted.resting(torque)),
        ("contensou", RESTING, 4, tilted.resting(torque, turns=False)),
    ],
)
def test_a_phase_is_the_motion_of_newton_and_euler(law, start, phase, force):
    run = tt.run(scenario(LAWS[law], until=0.05, initial=start))
    assert (run.trajectory.phase == phase).all()
    tilted.assert_moves(run.trajectory, tilted.body_of(TOP), force, 1e-10)


def test_a_drilling_torque_holds_a_disc_that_friction_cannot_hold_alone():
    law = LAWS["contensou"] | {"patch": 2e-4}
    for mu_d, phase in ((0.0, "slip"), (5e-3, "rest")):
        done = solve(scenario(law, 2e-4, initial=RESTING, parts={"mu_d": mu_d}))
        assert done.report["contact_phases"]["counts"] == {phase: 1}
        assert_below(1e-13, done.report["drift"])


@pytest.mark.parametrize(
    ("law", "parts", "tables", "message"),
    [
        ("coulomb", {"mu_r": 0.1}, {}, r"`friction.mu_r` must be less than 0.04"),
        (
            "viscous",
            True,
            {"run": {"precision": "quad"}},
            r'must be "double" or "longdouble" with `friction.mu_r`',
        ),
        (
            "viscous",
            True,
            {"system": "gliding-cylinder", "parameters": {}},
            r"`friction.mu_r` must be of a tippe-top or spheroid or disc, but the system is",
        ),
    ],
)
def test_parts_that_cannot_act_are_refused(law, parts, tables, message):
    with refusal(message):
        scenario(LAWS[law], parts=parts, initial={}, **tables)


def test_records_take_parts_by_name():
    law = tt.friction.Viscous(0.3, mu_r="0.2 mm", mu_d=MU_D)
    run = tt.run(TOP, law, start=SLIDING, until=0.01)
    table = solve(scenario(LAWS["viscous"], 0.01, initial=SLIDING))
    assert run.trajectory.theta.values[-1] == columns(table)["theta"][-1]
    assert run.summary.friction.to_dict() == {
        "law": "viscous",
        "mu": 0.3,
        "mu_r": MU_R,
        "mu_d": MU_D,
    }
    assert tt.friction.Contensou(0.3, 5e-4, 1e-5, mu_d=1e-5)._fields == (
        "mu",
        "patch",
        "mu_r",
        "mu_d",
    )
    with refusal("mu_r"):
        tt.friction.Coulomb(0.3, mu_r=-1e-5)


def test_no_statement_about_lasting_spins_is_made():
    """Thresholds, fates and stable states are those of tops that lose nothing but by sliding."""
    made = scenario(LAWS["viscous"], until=0.05, initial={"theta": 0.01, "omega3": 150.0})
    found = forecast.assessment(made)
    assert "thresholds" not in found
    assert "no state is known to attract" in found["regime"]
    assert solve(made, keep=False).report["outcome"] == "under-way"
    with refusal("no spin lasts"):
        tt.theory.linear_modes(TOP, omega3=100.0, law=tt.friction.Viscous(0.3, mu_r=1e-5))
    run = tt.run("inverting", tt.friction.Viscous(0.3, mu_r=1e-5), until=0.01)
    with refusal(r"none does under `friction.mu_r`"):
        run.plot("states")

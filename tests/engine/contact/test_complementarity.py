"""Random runs through all phases: balances, and on dense output the normal force, the friction cone
and the direction of friction.
"""

import numpy as np
import pytest
from limits import assert_below
from nightly import at_night
from touching import LEINE_GLOCKER, STEM

from tippetop.engine.status import Status
from tippetop.mechanics.contact.rows import PHASES, Row, row_scalars
from tippetop.runs.run import Solution, solve
from tippetop.scenario.build import problem


LAWS = (
    {"law": "coulomb", "mu": 0.3},
    {"law": "viscous", "mu": 0.5},
    {"law": "contensou", "mu": 0.3, "patch": 2e-3},
    {"law": "stribeck", "mu": 0.2, "mu_static": 0.3, "v_s": 0.1, "eps": 0.01},
)


def random_run(seed: int) -> Solution:
    """Every second run has torques of the contact, every third begins in the air, and half of those
    that may have a stem.
    """
    rng = np.random.default_rng(seed)
    law, size = LAWS[seed % 4], 10 ** rng.uniform(-1.3, 0)
    if seed // 4 % 2:
        law = law | {"mu_r": 10 ** rng.uniform(-5, -3.7), "mu_d": 10 ** rng.uniform(-5, -3.7)}
    speeds = {"omega3": 60.0, "theta_dot": 20.0, "phi_dot": 5.0, "nu_x": 0.3, "nu_y": 0.3}
    start = {name: size * most * rng.normal() for name, most in speeds.items()} | {
        "theta": rng.uniform(0.05, 3.0)
    }
    tables = {"contact": {"e_n": rng.uniform(0.0, 0.6)}}
    if seed % 3 == 0:
        start |= {"gap": 10 ** rng.uniform(-6, -2)}
    if law["law"] != "coulomb" and rng.uniform() < 0.5:
        start["theta"] = min(start["theta"], 2.3)
        tables["stem"] = STEM
    tables |= {"friction": law, "initial": start, "run": {"until": 0.4, "output_step": 1e-4}}
    return solve(problem({"system": "tippe-top", "parameters": LEINE_GLOCKER} | tables))


def violations(done: Solution) -> dict[str, float]:
    """The largest violation of each law of the contact in the rows of a run, of weights and of
    order one.
    """
    b = done.problem.internal_body
    q = Row(*done.rows[:, : len(Row._fields)].T)
    s = row_scalars(q, b)
    label, weight = np.array(PHASES)[q.phase.astype(int)], b.m * b.g
    F, v2 = np.hypot(q.Fx, q.Fy), s.v2
    power = q.drilled - s.power  # F_h.v_A
    one, slips, flies = label != "both", label == "slip", label == "flight"
    cone = b.friction.mu * q.force
    found = {
        "pull": -q.force,
        "force in flight": np.where(flies, np.abs(q.force) + F, 0),
        "depth": -s.gap,
        "power": np.where(one, power, 0) / weight,
        "direction": np.where(slips, power + F * np.sqrt(v2), 0),
        "sliding at rest": np.where((label == "roll") | (label == "rest"), np.sqrt(v2), 0),
    }
    if done.problem.law.set_valued:
        found["sliding"] = np.where(slips, np.abs(F - cone), 0)
    if done.problem.law.set_valued or done.problem.law.regions:
        found["cone"] = np.where(one, F - cone, 0)
    return {name: float(np.max(values)) for name, values in found.items()}


@pytest.mark.parametrize("seed", [*range(6), at_night(6), 7, 51])
def test_a_random_run_keeps_the_laws_of_contact(seed: int) -> None:
    done = random_run(seed)
    assert done.status is Status.FINISHED
    assert_below(1e-13, done.report["drift"])
    assert_below(1e-12, violations(done), "violation of a law of contact")

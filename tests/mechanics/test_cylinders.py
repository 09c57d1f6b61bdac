"""The eccentric cylinder: where it lifts off, and the modified reaction."""

import examples
import numpy as np
import pytest

from tippetop.engine.status import Status


BODY = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 4e-6, "g": 9.82}  # I = m R^2/2


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_liftoff_where_theta_dot_squared_cos_theta_is_minus_g_over_R_alpha(mu: float) -> None:
    made = examples.run(
        "gliding-cylinder", BODY, {"theta": 1.0, "theta_dot": 60.0}, 2.0, ("viscous", {"mu": mu})
    )
    assert made.status is Status.LIFTOFF
    last = made.problem.variables.names
    state = dict(
        zip(last, made.final * np.array([float(w) for w in made.problem.weights()]), strict=True)
    )
    assert state["theta_dot"] ** 2 * state["z"] == pytest.approx(-9.82 / (0.02 * 0.3), rel=1e-12)


def test_modified_reaction_may_feed_energy_in() -> None:
    """E' = F.v_A of either sign [T 6.23]: it is logged, and the balance with it is exact."""
    start = {"theta": 0.5, "theta_dot": 10.0, "nu_x": 0.2}
    law = ("modified", {"mu": 0.01, "v_k": 0.1})
    made = examples.run("gliding-cylinder", BODY, start, 1.0, law)
    power = examples.columns(made)["friction_power"]
    assert power.min() < 0 < power.max()
    assert made.report["drift"]["energy_balance"] < 1e-13

"""The eccentric cylinder: gliding, rolling, and with the modified reaction."""

import examples
import numpy as np
import pytest

from tippetop.engine.status import Status


BODY = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I": 4e-6, "g": 9.82}  # I = m R^2/2
ROUND = {**BODY, "alpha": 0.0}
VISCOUS = ("viscous", {"mu": 0.3})


def test_round_cylinder_follows_the_closed_form() -> None:
    """[T 6.8], and the published numbers at 0.2 s."""
    start = {"nu_x": 0.5, "theta_dot": 3.0, "theta": 0.2}
    made = examples.run("gliding-cylinder", ROUND, start, 0.5, VISCOUS)
    rows, t = examples.columns(made), made.times
    m, R, inertia = 0.02, 0.02, 4e-6
    decay = np.exp(-(inertia + m * R**2) / inertia * 0.3 * 9.82 * t)
    np.testing.assert_allclose(rows["nu_x"], 0.5 * decay, rtol=1e-13)
    final = (m * R * 0.5 + (inertia + m * R**2) * 3.0) / (inertia + m * R**2)
    np.testing.assert_allclose(
        rows["theta_dot"], final - m * R / (inertia + m * R**2) * 0.5 * decay, rtol=1e-13
    )
    made = examples.run("gliding-cylinder", ROUND, {"nu_x": 0.5}, 0.2, VISCOUS)
    rows = examples.columns(made)
    assert rows["nu_x"][-1] == pytest.approx(0.08537113947514, rel=1e-12)
    assert rows["theta_dot"][-1] == pytest.approx(13.820962017495, rel=1e-12)


def test_cylinder_is_the_planar_tippe_top() -> None:
    """phi' = omega_3 = nu_y = 0 is an invariant subset of the tippe top, I1 -> I."""
    start = {"theta": 0.5, "theta_dot": 8.0, "nu_x": 0.1}
    top = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": 4e-6, "I3": 3e-6, "g": 9.82}
    flat = examples.columns(examples.run("gliding-cylinder", BODY, start, 0.4, VISCOUS))
    solid = examples.columns(examples.run("tippe-top", top, start, 0.4, VISCOUS))
    side = np.sign(
        flat["theta"]
    )  # the top's axis leans to the other side where the cylinder's angle is negative
    assert set(side) == {-1, 1}
    for name in ("theta", "theta_dot", "nu_x"):
        np.testing.assert_allclose(
            side * flat[name], solid[name], rtol=1e-12, atol=1e-12, err_msg=name
        )
    for name in ("energy", "normal_force", "x", "modified_energy", "friction_power"):
        np.testing.assert_allclose(flat[name], solid[name], rtol=1e-12, atol=1e-13, err_msg=name)


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


def test_gliding_tends_to_rolling_as_one_over_mu() -> None:
    """The source calls v_A -> 0 inconsistent with a vertical reaction. Really the friction force
    mu g_n v_A tends to the horizontal reaction of rolling, while v_A tends to zero as 1/mu.
    """
    start, until, columns = {"theta": 0.5, "theta_dot": 2.0}, 0.5, examples.columns
    rolling, errors = columns(examples.run("rolling-cylinder", BODY, start, until)), []
    for mu in (100.0, 200.0, 400.0):
        law = ("viscous", {"mu": mu})
        rows = columns(examples.run("gliding-cylinder", BODY, start, until, law))
        push = np.abs(mu * rows["normal_force"] * rows["nu_x"])
        off = rows["theta"] - rolling["theta"], rows["nu_x"], push - rolling["horizontal_force"]
        errors.append(np.abs(off)[:, 10:].max(axis=1))
    assert np.all(np.abs(np.diff(np.log2(errors), axis=0) + 1) < 0.1)


# --- the modified reaction ----------------------------------------------------------------------


def modified(
    parameters: dict, start: dict, until: float, mu: float = 0.05, v_k: float = 0.1, **options
):
    return examples.run(
        "gliding-cylinder",
        parameters,
        start,
        until,
        ("modified", {"mu": mu, "v_k": v_k}),
        **options,
    )


def test_modified_reaction_may_feed_energy_in() -> None:
    """E' = F.v_A of either sign [T 6.23]: it is logged, and the balance with it is exact."""
    made = modified(BODY, {"theta": 0.5, "theta_dot": 10.0, "nu_x": 0.2}, 1.0, mu=0.01)
    power = examples.columns(made)["friction_power"]
    assert power.min() < 0 < power.max()
    assert made.report["drift"]["energy_balance"] < 1e-13


def test_modified_reaction_tends_to_rolling() -> None:
    """For v_A = 0 it is the reaction of rolling exactly (kappa = 1): the rolling motion is a
    solution.
    """
    start = {"theta": 0.5, "theta_dot": 2.0}
    rolling = examples.columns(examples.run("rolling-cylinder", BODY, start, 1.0))
    rows = examples.columns(modified(BODY, start, 1.0))
    np.testing.assert_allclose(rows["theta"], rolling["theta"], atol=1e-13)
    np.testing.assert_allclose(rows["nu_x"], 0, atol=1e-13)
    np.testing.assert_allclose(rows["normal_force"], rolling["normal_force"], rtol=1e-12)

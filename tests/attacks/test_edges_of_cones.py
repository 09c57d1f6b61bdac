"""Slides that begin and end near the edge of the friction cone, under exact Coulomb friction.

Starts are judged by an integration that shares nothing with the package; runs that are longer only
by their end: nothing stalls.
"""

from typing import Any

import numpy as np
import pytest
from coulomb import Ball, axes, held
from examples import CANONICAL as BODY
from limits import assert_near
from nightly import TONIGHT, at_night

import tippetop as tt
from tippetop.columns import flagged


pytestmark = pytest.mark.filterwarnings("ignore")


def followed(system: str, body: dict, friction: dict, initial: dict, **run: Any) -> Any:
    tables = {"parameters": body, "initial": initial}
    numbers = {name: {k: float(v) for k, v in table.items()} for name, table in tables.items()}
    friction = {"law": "coulomb"} | {name: float(value) for name, value in friction.items()}
    return tt.run(
        {"system": system, "friction": friction, "contact": {"e_n": 0.0}} | numbers, **run
    )


def body_of(rng: np.random.Generator, kind: str) -> dict[str, float]:
    m, R = 10 ** rng.uniform(-2, 0), 10 ** rng.uniform(-2.3, -1)
    alpha = rng.uniform(0.02, 0.9) * (-1 if kind == "peg" else 1)
    I1 = m * R**2 * rng.uniform(0.2, 0.6)
    body = {"m": m, "R": R, "alpha": alpha, "g": rng.uniform(3, 20)}
    return body | (
        {"I": I1} if kind == "cylinder" else {"I1": I1, "I3": I1 * rng.uniform(0.5, 1.6)}
    )


def at_the_edge(rng: np.random.Generator, kind: str) -> tuple | None:
    """A body, its start without sliding, its ball with a coefficient near that which rolling needs,
    its axis and angular momentum, and a time in which it turns by less than a radian; None if the
    contact needs more friction than usual.
    """
    body = body_of(rng, kind)
    I1, I3 = (body.get(name, body.get("I")) for name in ("I1", "I3"))
    swing = np.sqrt(body["g"] / body["R"])
    theta, nutation = rng.uniform(0.2, 2.9), swing * rng.normal() * rng.choice([0, 0.3, 1])
    start = {"theta": theta, "theta_dot": nutation}
    phi_dot, omega3 = (0.0, 0.0) if kind == "cylinder" else swing * rng.normal(0, 1, 2) * [1, 4]
    if kind != "cylinder":
        start |= {"phi_dot": phi_dot, "omega3": omega3}
    s, z = np.sin(theta), np.cos(theta)
    u = np.array([s, 0, z])
    L = I1 * np.array([-phi_dot * s * z, nutation, phi_dot * s * s]) + I3 * omega3 * u
    b = Ball(body["m"], body["R"], body["alpha"] * body["R"], I1, I3, body["g"])
    F = held(u, L, b)
    mu = np.hypot(F[0], F[1]) / F[2]
    if not (F[2] > 0.05 * b.m * b.g and 0.01 < mu < 0.6):
        return None
    distance = 10 ** rng.uniform(-12, -1) * rng.choice([1, 1, 1, -1])
    b = b._replace(mu=float(mu * (1 - distance)))
    return body, start, b, u, L, 0.6 / max(swing, np.linalg.norm(L) / I1)


@pytest.mark.parametrize("count", [3, at_night(150)])
def test_a_slide_from_rest_is_that_of_an_own_integration(count: int) -> None:
    judged = repeated = 0
    for seed in range(10 * count):
        kind = ("top", "cylinder", "peg")[judged % 3]
        edge = at_the_edge(np.random.default_rng([seed, TONIGHT]), kind)
        if edge is None:
            continue
        body, start, b, u, L, until = edge
        times = [0.0, 1e-9, 1e-6, *until * np.array([1e-3, 0.1, 0.5, 1])]
        system = "gliding-cylinder" if kind == "cylinder" else "tippe-top"
        try:
            run = followed(system, body, {"mu": b.mu}, start, until=until, output_times=times)
        except tt.InputError as error:
            if "mu` must be less than" not in str(error):  # the contact would jam
                raise
            continue
        assert run.summary.status == "finished", seed
        theta = run.trajectory.theta.values
        assert theta[0] == pytest.approx(start["theta"], rel=0, abs=3e-16)
        assert abs(run.trajectory.nu_x[0]) < 1e-15
        for slow in (1e-13, 1e-14, 1e-12):  # the other integration may stumble where slides begin
            axis = axes(b, u, L, times, slow)
            found = np.array([np.abs(np.sin(theta)), np.cos(theta)])[:, : len(axis)]
            error = np.max(np.abs(found - [np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]]))
            if error < 1e-10:
                break
            repeated += 1
        assert error < 1e-10, seed
        judged += 1
        if judged == count:
            break
    assert judged == count
    assert repeated <= count / 50


@pytest.mark.parametrize("precision", ["double", at_night("longdouble")])
@pytest.mark.parametrize("share", [1 - 1e-3, 1 - 1e-8, 1, 1 + 1e-12])
def test_the_balance_of_energy_holds_where_rolling_needs_all_friction(
    share: float, precision: str
) -> None:
    start = {"theta": 1.0, "phi_dot": 12.0, "omega3": 80.0}
    rolling = tt.run(
        {"system": "rolling-tippe-top", "parameters": BODY, "initial": start}, until=1e-3
    )
    mu = {"mu": share * float(rolling.trajectory.friction_needed[0])}
    run = followed("tippe-top", BODY, mu, start, until=0.05, precision=precision)
    assert run.summary.status == "finished"
    assert run.summary.drift["energy_balance"] < 1e-14
    assert run.trajectory.theta[0] == 1.0


def test_an_event_within_the_series_of_a_start_is_logged() -> None:
    """theta = pi/2 follows 2e-5 s after a start whose first series lasts 1e-3 s."""
    start = {"theta": np.pi / 2 + 1e-4, "theta_dot": -5.0}
    cylinder = {"m": 0.02, "R": 0.02, "alpha": 0.4, "I": 2.99e-6, "g": 9.82}
    run = followed("gliding-cylinder", cylinder, {"mu": 0.1}, start, until=0.02)
    (time,) = run.events.time.values[flagged(run.events.kind, "equator")]
    assert time == pytest.approx(2e-5, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "count"),
    [("cylinder", 1), ("top", 1), at_night("cylinder", 300), at_night("top", 75)],
)
def test_long_runs_end_at_their_end(kind: str, count: int) -> None:
    for seed in range(count):
        rng = np.random.default_rng([seed, count, TONIGHT])
        body = body_of(rng, "peg" if kind == "top" and seed % 2 else kind)
        swing = np.sqrt(body["g"] / body["R"])
        fast = np.sqrt(body["g"] * body["R"])
        start = {
            "theta": rng.uniform(0.1, 2.9),
            "theta_dot": swing * rng.normal(0, 0.7),
            "nu_x": fast * rng.normal(0, 0.5),
        }
        friction, system = {"mu": rng.uniform(0.05, 0.4)}, "gliding-cylinder"
        if kind == "top":
            system = "tippe-top"
            start |= {"phi_dot": swing * rng.normal(0, 0.5), "omega3": 8 * swing * rng.normal()}
            friction |= {"mu_r": 1e-3 * body["R"] * (seed % 3 > 0), "mu_d": 1e-3 * body["R"]}
        try:
            run = followed(system, body, friction, start, until=50 / swing, output="events")
        except tt.InputError as error:
            if "mu` must be less than" not in str(error):
                raise
            continue
        assert run.summary.status == "finished", (seed, run.summary.reason)


def test_a_cylinder_slides_on_where_only_a_pull_would_hold_it() -> None:
    """After a slide has come to rest, g_n of rolling is negative, but not that of a slide back; of
    the mirror image too.
    """
    body = {"m": 0.048, "R": 0.03126, "alpha": 0.8275, "g": 17.65, "I": 2.639e-5}
    start = {"theta": 2.7783, "theta_dot": 24.096, "nu_x": 0.7334}
    mirrored = {name: -value for name, value in start.items()}
    runs = [
        followed("gliding-cylinder", body, {"mu": 0.069}, each, until=2.0)
        for each in (start, mirrored)
    ]
    for run in runs:
        assert run.summary.status == "finished", run.summary.reason
        assert max(run.summary.drift.values()) < 1e-13
    assert_near(runs[1].trajectory.theta, -runs[0].trajectory.theta, 1e-9)


def test_the_extremes_of_the_force_include_the_first_instants_of_a_slide() -> None:
    start = {"theta": 1.0, "phi_dot": 12.0, "omega3": 80.0}
    run = followed("tippe-top", BODY, {"mu": 0.02}, start, until=0.003, output_step=1e-6)
    forces = run.trajectory.normal_force.values
    assert run.summary.normal_force.t_min == 0
    assert run.summary.normal_force.min == pytest.approx(forces.min(), rel=1e-15)

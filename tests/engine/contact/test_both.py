"""Sphere and stem on the plane at once, against the equations in Euler angles."""

import numpy as np
import pytest
from examples import CANONICAL
from limits import assert_below
from scipy.integrate import solve_ivp
from test_phases_of_runs import run
from touching import LEINE_GLOCKER, STEM, table_of

import tippetop as tt
from tippetop.engine.status import Status


Z = -10 / 13  # cos(theta) where both touch
MU = 2.0  # s/m
VISCOUS = {"law": "viscous", "mu": MU}
PEG = {**CANONICAL, "alpha": -0.6}


def finished(until, drift=1e-12, parameters=LEINE_GLOCKER, stem=STEM, **tables):
    """Return the columns and phases of a run.

    Check that it finishes, conserves its invariants and that neither ball sinks into the plane.
    """
    done = run(parameters, stem=stem, until=until, **tables)
    assert done.status is Status.FINISHED, done.reason
    assert_below(drift, done.report["drift"])
    columns = done.columns()
    z, theta = columns["z"].values, columns["theta"].values
    sphere = z - parameters["R"] * (1 - parameters["alpha"] * np.cos(theta))
    for gap in (sphere, columns["gap"].values, columns["gap_stem"].values):
        assert gap.min() > -1e-12
    return columns, table_of(done, "phases")


def in_euler_angles(start, t):
    """phi', omega_3, velocity of the centre of mass along e and 2hat at times t, and when a ball
    leaves.
    """
    m, R, I1, I3, g = (LEINE_GLOCKER[name] for name in ("m", "R", "I1", "I3", "g"))
    c, s = Z, np.sqrt(1 - Z**2)
    offsets, radii = np.array([0.2 * R, 0.2 * R + STEM["h"]]), np.array([R, STEM["r"]])
    H = radii[0] - offsets[0] * c

    def forces(y):
        phi_dot, omega3, along, across = y
        nu_2 = across + s * (radii * omega3 + phi_dot * (offsets - radii * c))
        push = np.array([[MU * along] * 2, MU * nu_2])  # -F/N along e and 2hat, of sphere and stem
        # s (I1 phi'^2 c - I3 omega_3 phi') - s sum(offset N) + H sum(N push_e) = 0, N_b + N_s = m g
        loads = np.array([[1, 1], -s * offsets + H * push[0]])
        N = np.linalg.solve(loads, [m * g, -s * (I1 * phi_dot**2 * c - I3 * omega3 * phi_dot)])
        return N, -push * N

    def rates(_, y):
        phi_dot, _, along, across = y
        _, F = forces(y)
        turn = ((offsets - radii * c) * F[1]).sum() / (I1 * s)
        return [
            turn,
            s * (radii * F[1]).sum() / I3,
            F[0].sum() / m + phi_dot * across,
            F[1].sum() / m - phi_dot * along,
        ]

    def least(_, y):
        return forces(y)[0].min()

    least.terminal = True
    y = solve_ivp(rates, (0, t[-1]), start, "DOP853", t, events=least, rtol=1e-12, atol=1e-14)
    return y.y, (y.t_events[0][0] if len(y.t_events[0]) else np.inf)


@pytest.mark.parametrize(("phi_dot", "omega3"), [(-20.0, 60.0), (16.0, -30.0), (-40.0, 60.0)])
def test_standing_on_both_is_that_of_the_euler_angles(phi_dot, omega3):
    start = {
        "theta": float(np.arccos(Z)),
        "phi_dot": phi_dot,
        "omega3": omega3,
        "centre_at_rest": True,
    }
    columns, phases = finished(0.4, 1e-13, friction=VISCOUS, initial=start)
    assert phases["phase"][0] == 3
    t = columns["time"].values
    ours = t <= phases["end"][0]
    theirs, leaves = in_euler_angles([phi_dot, omega3, 0.0, 0.0], t)
    count = min(ours.sum(), theirs.shape[1])
    for name, value in zip(("phi_dot", "omega3"), theirs, strict=False):
        assert columns[name].values[:count] == pytest.approx(value[:count], abs=1e-9), name
    assert (
        (phases["end"][0] == pytest.approx(leaves, abs=1e-10))
        if np.isfinite(leaves)
        else len(phases["end"]) == 1
    )
    assert np.ptp(columns["theta"].values[ours]) < 1e-12


def test_a_ball_that_leaves_is_followed_by_the_other():
    """The gap of the ball whose force vanishes opens as t^3: it does not touch again by
    rounding.
    """
    ended = set()
    for seed in range(6):
        rng = np.random.default_rng(seed)
        start = {
            "theta": float(np.arccos(Z)),
            "phi_dot": rng.uniform(-40, -10),
            "omega3": rng.uniform(40, 80),
        }
        _, phases = finished(0.3, friction=VISCOUS, initial=start)
        ended |= set(phases["reason"].tolist())
    assert 7 in ended  # a ball left


def test_coulombs_law_itself_ends_there():
    start = {"theta": float(np.arccos(Z)), "phi_dot": -20.0, "omega3": 60.0}
    done = run(LEINE_GLOCKER, initial=start, stem=STEM, until=0.1)
    assert done.status is Status.ENDED
    assert "on its sphere and its stem" in done.reason


def test_a_frictionless_landing_on_both_goes_on_where_one_ball_presses():
    """Gyroscopic torque lifts the sphere and presses the stem: the body stays on the stem alone."""
    finished(
        0.3,
        parameters={**CANONICAL, "alpha": -0.543},
        friction={"law": "none"},
        initial={"theta": 2 * np.pi / 3, "gap": 0.01, "phi_dot": -20.0, "omega3": 100.0},
        stem={"r": 0.002, "h": 0.036},
    )


@pytest.mark.parametrize("mu_r", [0.0, 1e-6])
def test_discs_that_stop_together_roll_on_both_as_a_cone_does(mu_r):
    """A cone rolls evenly; rolling resistance takes mu_r N |omega| of its energy, so that omega
    falls evenly.
    """
    m, R = (PEG[name] for name in ("m", "R"))
    friction = {"law": "contensou", "mu": 0.3, "patch": 1.5e-5, "mu_r": mu_r}
    start = {"theta": float(np.arccos(-0.0185 / 0.027)), "omega3": 20.0, "phi_dot": 10.0}
    stem = {"r": 0.0015, "h": 0.027}
    columns, phases = finished(0.6, parameters=PEG, stem=stem, friction=friction, initial=start)
    assert phases["phase"][-1] == 3
    assert phases["reason"][-1] == 8  # rests
    last = columns["time"].values > phases["start"][-1]
    t, z = columns["time"].values[last], columns["theta"].values[last]
    assert np.ptp(z) < 1e-12
    c, s = np.cos(z[0]), np.sin(z[0])
    phi_dot, omega3 = (columns[name].values[last] for name in ("phi_dot", "omega3"))
    for name in ("nu_x", "nu_y"):
        assert np.abs(columns[name].values[last]).max() < 1e-12
    # omega = -phi' s 1hat + omega_3 3hat is horizontal
    assert phi_dot * s**2 + omega3 * c == pytest.approx(0 * t, abs=1e-10)
    omega = np.abs(omega3) / s
    energy = columns["energy"].values[last] - m * PEG["g"] * R * (1 - PEG["alpha"] * c)
    slowing = mu_r * m * PEG["g"] / (2 * energy[0] / omega[0] ** 2)
    assert omega == pytest.approx(omega[0] - slowing * (t - t[0]), rel=1e-8)


@pytest.mark.parametrize("e_n", [0.0, 0.3])
def test_balls_that_throw_each_other_down_come_to_stand_on_both(e_n):
    """Each impact throws the other ball down, with a speed that falls geometrically."""
    _, phases = finished(
        0.1,
        1e-13,
        parameters={**PEG, "I1": 2.994e-6},
        friction={"law": "contensou", "mu": 0.37544, "patch": 4.66535e-4},
        initial={"theta": 2.1573007041694843, "omega3": -45.757, "phi_dot": 10.135},
        stem={"r": 0.0045708347893419436, "h": 0.03917465632193509},
        contact={"e_n": e_n},
    )
    assert 3 in phases["phase"]


@pytest.mark.parametrize(
    ("start", "phase"),
    [
        ({"theta_dot": 2e-5, "phi_dot": 10.0, "omega3": -124.0, "nu_y": -1.4748128}, 3),
        ({"theta_dot": -1e-5, "phi_dot": 100.0, "omega3": 0.0, "nu_y": 0.0}, 2),
    ],
)
def test_what_follows_an_impulse_onto_both_is_that_of_the_state_after_it(start, phase):
    """The stem's disc then slides slower than it turns, as not before; or neither ball presses."""
    start |= {"theta": float(np.arccos(-25 / 49)), "nu_x": 0.0}
    run = tt.run("wooden-toy", {"mu": 0.2}, start=start, until=1e-4)
    assert run.phases.phase.values.tolist() == [phase]

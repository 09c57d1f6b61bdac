"""Sphere and stem on the plane at once, against the equations in Euler angles. [contact 4.3]"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from test_phases_of_runs import run
from touching import LEINE_GLOCKER, table_of

from tippetop.engine.status import Status


STEM = {"r": 0.005, "h": 0.013}
Z = -10 / 13  # cos(theta) where both touch
MU = 2.0  # s/m


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
    done = run(
        LEINE_GLOCKER, friction={"law": "viscous", "mu": MU}, initial=start, stem=STEM, until=0.4
    )
    columns, phases = done.columns(), table_of(done, "phases")
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
    sphere = columns["z"].values - LEINE_GLOCKER["R"] * (1 - 0.2 * np.cos(columns["theta"].values))
    assert min(sphere.min(), columns["gap_stem"].values.min()) > -1e-12
    assert max(done.report["drift"].values()) < 1e-13


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
        done = run(
            LEINE_GLOCKER,
            friction={"law": "viscous", "mu": MU},
            initial=start,
            stem=STEM,
            until=0.3,
        )
        assert done.status is Status.FINISHED, (seed, done.reason)
        assert max(done.report["drift"].values()) < 1e-12, seed
        columns = done.columns()
        sphere = columns["z"].values - LEINE_GLOCKER["R"] * (
            1 - 0.2 * np.cos(columns["theta"].values)
        )
        assert min(sphere.min(), columns["gap_stem"].values.min()) > -1e-12, seed
        ended |= set(table_of(done, "phases")["reason"].tolist())
    assert 7 in ended  # a ball left


def test_coulombs_law_itself_ends_there():
    start = {"theta": float(np.arccos(Z)), "phi_dot": -20.0, "omega3": 60.0}
    done = run(LEINE_GLOCKER, initial=start, stem=STEM, until=0.1)
    assert done.status is Status.ENDED
    assert "sphere and its stem at once" in done.reason

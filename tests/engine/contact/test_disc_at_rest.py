"""A contact disc that comes to rest rolls without turning, until friction can no longer hold it."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from touching import ROCKING

from tippetop.engine.status import Status
from tippetop.runs.run import solve
from tippetop.scenario.build import problem


BODY = {"m": 0.006, "R": 0.015, "alpha": 0.2, "I1": 8e-7, "I3": 7e-7, "g": 9.81}
LAW = {"law": "contensou", "mu": 0.3, "patch": 2e-3}
REST = 4  # the number of the phase


def rocking(**run):
    """A disc that rests, gives way, and rests again."""
    return problem(ROCKING | {"run": ROCKING["run"] | run})


def scenario(until=1.0, friction=LAW, parameters=BODY, run=None, **tables):
    """Leine and Glocker's top on a soft plane: its disc is large, so that it soon rests."""
    run = {"until": until} | (run or {})
    return problem(
        {"system": "tippe-top", "parameters": parameters, "friction": friction, "run": run} | tables
    )


def columns_of(done):
    """Its columns, and Omega_z."""
    c = SimpleNamespace(**{name: column.values for name, column in done.columns().items()})
    c.turn = c.omega3 * np.cos(c.theta) + c.phi_dot * np.sin(c.theta) ** 2
    return c


@pytest.mark.parametrize("mu_r", [0.0, 1e-5])
def test_a_disc_at_rest_rolls_without_turning(mu_r):
    """Only rolling resistance takes energy; the balances count the impulse that brings
    it to rest.
    """
    done = solve(
        scenario(
            friction=LAW | {"mu_r": mu_r}, initial={"theta": 1.0, "omega3": 5.0, "phi_dot": 1.0}
        )
    )
    assert done.status is Status.FINISHED
    assert max(done.report["drift"].values()) < 1e-13
    assert done.report["contact_phases"]["counts"] == {"slip": 1, "rest": 1}
    c = columns_of(done)
    rests = c.phase == REST
    assert np.abs(c.turn[rests]).max() < 1e-13
    assert np.hypot(c.nu_x, c.nu_y)[rests].max() < 1e-15
    falls = -np.diff(c.energy[rests]) / c.energy[0]
    assert falls.min() > (1e-7 if mu_r else -1e-15)
    assert falls.max() < (1e-3 if mu_r else 1e-15)


def test_a_disc_gives_way_where_friction_can_no_longer_hold_it():
    """It slides on, stops, and rests again."""
    done = solve(rocking(output="steps"))
    assert max(done.report["drift"].values()) < 1e-13
    counts = done.report["contact_phases"]["counts"]
    assert counts["rest"] > 1
    assert counts["slip"] > 1
    phases = done.report["contact_phases"]["first"]
    assert [p["reason"] for p in phases[1:3]] == ["rests", "gives"]
    left = held(done, columns_of(done))
    assert left.min() > -1e-12
    assert left.min() < 1e-3 < left.max()


def test_rest_is_the_motion_of_newton_and_euler():
    """Eleven linear equations for v_A' = 0, Omega_z' = 0 with rolling resistance, integrated by
    DOP853.
    """
    mu_r = 2e-4
    s, z0 = np.sin(0.5), np.cos(0.5)
    start = {
        "theta": 0.5,
        "theta_dot": 8.0,
        "omega3": 4.0,
        "phi_dot": -4.0 * z0 / s**2,
    }  # Omega_z = 0
    done = solve(scenario(until=0.3, friction=LAW | {"mu_r": mu_r}, initial=start))
    c = columns_of(done)
    assert (c.phase == REST).all()
    m, R, I1, I3, g = (BODY[name] for name in ("m", "R", "I1", "I3", "g"))
    z = np.array([0.0, 0.0, 1.0])

    def rates(t, y):
        u, omega = y[:3], y[3:]
        inertia = I1 * np.eye(3) + (I3 - I1) * np.outer(u, u)
        a = BODY["alpha"] * R * u - R * z
        k = -mu_r / np.sqrt(omega[0] ** 2 + omega[1] ** 2 + (1e-6 * np.sqrt(g / R)) ** 2)
        rolling = k * np.array([omega[0], omega[1], 0.0])

        def motion(x):
            torque = (
                np.cross(a, x[:3]) + x[3] * z + x[2] * rolling - np.cross(omega, inertia @ omega)
            )
            turn = np.linalg.solve(inertia, torque)
            arm_rate = BODY["alpha"] * R * np.cross(omega, u)
            return np.append(
                x[:3] / m - g * z + np.cross(turn, a) + np.cross(omega, arm_rate), turn[2]
            ), turn

        free = motion(np.zeros(4))[0]
        matrix = np.array([motion(x)[0] - free for x in np.eye(4)]).T
        return [*np.cross(omega, u), *motion(np.linalg.solve(matrix, -free))[1]]

    phi_dot = start["phi_dot"]
    omega = [s * (4.0 - phi_dot * z0), 8.0, 4.0 * z0 + phi_dot * s**2]
    path = solve_ivp(
        rates,
        (0.0, 0.3),
        [s, 0.0, z0, *omega],
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        t_eval=c.time,
    )
    np.testing.assert_allclose(np.cos(c.theta), path.y[2], rtol=0, atol=1e-11)


def test_a_disc_whose_turning_is_reversed_passes_its_rest():
    """theta' and the spin about 3hat turn it the other way, more than friction can hold: w and U
    vanish at once, and grow again.
    """
    start = {"theta": 1.2, "theta_dot": 20.0, "phi_dot": -9.0, "omega3": 21.0}
    disc = LAW | {"patch": 1e-3}
    done = solve(
        scenario(until=0.02, friction=disc, parameters=BODY | {"I3": 12e-7}, initial=start)
    )
    assert done.report["contact_phases"]["counts"] == {"slip": 1}
    assert max(done.report["drift"].values()) < 1e-13
    c = columns_of(done)
    assert np.all(np.diff(c.turn) > 0)
    assert c.turn[0] < 0 < c.turn[-1]


@pytest.mark.parametrize("seed", range(8))
def test_random_runs_keep_their_balances(seed):
    rng = np.random.default_rng(seed)
    law = LAW | {
        "mu": 10 ** rng.uniform(-1.5, -0.4),
        "patch": 0.015 * 10 ** rng.uniform(-1.8, -0.8),
    }
    law |= {"mu_r": (0.0, 1e-5, 3e-4)[seed % 3]}
    start = {
        "theta": rng.uniform(0.05, 3.1),
        "omega3": 3 * rng.normal(),
        "theta_dot": 8 * rng.normal(),
    }
    done = solve(scenario(until=0.5, friction=law, initial=start))
    assert done.status is Status.FINISHED
    assert max(done.report["drift"].values()) < 1e-13
    c = columns_of(done)
    rests = c.phase == REST
    assert np.abs(c.turn[rests]).max(initial=0.0) < 1e-13
    both = rests[1:] & rests[:-1]
    assert (np.diff(c.energy)[both] < 1e-15 * c.energy[0]).all()


def test_wider_numbers_give_the_same_motion():
    ends = [solve(rocking(precision=precision)) for precision in ("double", "longdouble")]
    assert ends[0].report["contact_phases"]["counts"] == ends[1].report["contact_phases"]["counts"]
    np.testing.assert_allclose(ends[1].final[:10].astype(float), ends[0].final[:10], atol=1e-8)

"""The egg and the rattleback of the how-tos, against the Lagrangian of their height and what is
published of them.
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tippetop as tt
from tippetop.mechanics.systems import SYSTEMS


HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"


def names_of(page: str) -> dict[str, Any]:
    """What the Python of a how-to defines."""
    names: dict[str, Any] = {}
    for block in re.findall(
        r"```python\n(.*?)```", (HOW_TO / page).read_text(encoding="utf-8"), flags=re.S
    ):
        exec(compile(block, page, "exec"), names)
    return names


@pytest.fixture(scope="module", autouse=True)
def _forgotten() -> Iterator[None]:
    yield
    for name in ("spinning-egg", "rattleback"):
        SYSTEMS.pop(name, None)


@pytest.fixture(scope="module")
def egg() -> dict[str, Any]:
    return names_of("a-spinning-egg.md")


@pytest.fixture(scope="module")
def rattleback() -> dict[str, Any]:
    return names_of("a-rattleback.md")


def frictionless(
    height: Callable, inertia: np.ndarray, m: float, start: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """gamma and omega in body axes, by Euler and Poincaré's equations of w.Iw/2 + m h'^2/2 - m g h;
    h = height(gamma).

    Of the body the height of its centre alone is known; derivatives are central differences.
    """
    steps = 1e-4 * np.eye(3)

    def slope(f: Callable, x: np.ndarray) -> np.ndarray:
        return np.array([(f(x + d) - f(x - d)) / 2e-4 for d in steps])

    def potential(g: np.ndarray) -> float:
        return m * 9.81 * height(g)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        g, w = y[:3], y[3:]
        along = slope(height, g)
        lever = np.cross(along, g)  # h' = lever . w
        g_dot = np.cross(g, w)
        curve = (slope(height, g + 1e-4 * g_dot) - slope(height, g - 1e-4 * g_dot)) / 2e-4
        lever_dot = np.cross(curve, g) + np.cross(along, g_dot)
        momentum = inertia @ w + m * lever * (lever @ w)
        force = slope(lambda x: m * (slope(height, x) @ np.cross(x, w)) ** 2 / 2 - potential(x), g)
        torque = (
            np.cross(momentum, w)
            + np.cross(force, g)
            - m * (lever_dot * (lever @ w) + lever * (lever_dot @ w))
        )
        return np.concatenate(
            [g_dot, np.linalg.solve(inertia + m * np.outer(lever, lever), torque)]
        )

    return solve_ivp(rates, (0, times[-1]), start, t_eval=times, rtol=1e-8, atol=1e-10).y


def test_the_egg_moves_by_its_lagrangian_without_friction(egg: dict[str, Any]) -> None:
    run = tt.run(
        egg["EGG"],
        tt.friction.Viscous(mu=0),
        parameters={"m": 0.06, "a": 0.03, "b": 0.02, "g": 9.81},
        start={"theta": 1.0, "theta_dot": 1.0, "phi_dot": 40.0, "omega3": 20.0},
        until=0.25,
        output_step=0.025,
    )
    s, z = np.sin(1.0), np.cos(1.0)
    start = np.array(
        [-s, 0, z, -40 * s, 1.0, 20.0]
    )  # body axis 1 in the vertical plane of the axis
    inertia = 0.06 * np.diag([0.0013, 0.0013, 0.0008]) / 5
    gamma = frictionless(lambda g: np.sqrt(0.0004 * (g[0]**2 + g[1]**2) + 0.0009 * g[2]**2), inertia, 0.06, start, run.trajectory.time.values)[:3]  # fmt: skip # noqa: E501
    np.testing.assert_allclose(np.arccos(gamma[2]), run.trajectory.theta.values, atol=1e-5)
    assert np.ptp(run.trajectory.theta.values) > 0.1
    assert np.ptp(run.trajectory.Lz.values) < 1e-12 * run.trajectory.Lz.values[0]


def test_a_fast_egg_rises_and_keeps_its_balance(egg: dict[str, Any]) -> None:
    """Moffatt and Shimomura 2002; L .

    a of the contact point is nearly constant, for friction acts at the end of a.
    """
    run = egg["run"]
    assert run.trajectory.theta.values[-1] > 3.1
    assert run.drift.energy_balance < 1e-13
    L, u = run.trajectory.L.values, run.trajectory.axis.values
    h = np.sqrt(0.0009 * u[:, 2] ** 2 + 0.0004 * (1 - u[:, 2] ** 2))
    jellett = (0.0005 * u[:, 2] * (L * u).sum(axis=1) + 0.0004 * L[:, 2]) / h
    assert np.ptp(jellett) < 0.05 * jellett[0]


def toy(page: dict[str, Any], mu: float, spin: float, until: float, **changed: float) -> Any:
    """A run of the rattleback of the page."""
    start = {"theta": 0.01, "roll": 0.005, "spin": spin}
    return tt.run(
        page["RATTLEBACK"],
        tt.friction.Viscous(mu=mu),
        parameters={**page["TOY"], **changed},
        start=start,
        until=until,
        output_step=until / 20,
    )


def test_the_rattleback_moves_by_its_lagrangian_without_friction(
    rattleback: dict[str, Any],
) -> None:
    run, toy_body = toy(rattleback, 0.0, -5.0, 0.15), rattleback["TOY"]
    axes = np.array([toy_body[name] for name in "abc"])
    c, s = np.cos(0.15), np.sin(0.15)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    inertia = turn @ np.diag([toy_body[name] for name in ("I1", "I2", "I3")]) @ turn.T
    g = np.array([-np.sin(0.005) * np.cos(0.01), np.sin(0.01), np.cos(0.005) * np.cos(0.01)])
    start, times = np.concatenate([g, -5 * g]), run.trajectory.time.values
    gamma = frictionless(
        lambda g: np.linalg.norm(axes * g) - 0.003 * g[2], inertia, 0.1, start, times
    )[:3]
    np.testing.assert_allclose(np.arcsin(gamma[1]), run.trajectory.theta.values, atol=1e-6)
    assert np.ptp(run.trajectory.theta.values) > 0.01
    assert np.ptp(run.trajectory.Lz.values) < 1e-12 * abs(run.trajectory.Lz.values[0])


def test_the_rattleback_reverses_one_spin_sooner_and_has_a_mirror_image(
    rattleback: dict[str, Any],
) -> None:
    """Walker 1896: of the two spins one turns into the other; the other one stays for long."""
    back, on = (toy(rattleback, 30.0, spin, 2.0) for spin in (-5.0, 5.0))
    assert back.trajectory.spin.values[-1] > 3
    assert on.trajectory.spin.values.min() > 4.5
    start = {"theta": 0.01, "roll": -0.005, "spin": 5.0}
    body = {**rattleback["TOY"], "delta": -0.15}
    mirrored = tt.run(
        rattleback["RATTLEBACK"],
        tt.friction.Viscous(mu=30.0),
        parameters=body,
        start=start,
        until=2.0,
        output_step=0.1,
    )
    np.testing.assert_allclose(
        mirrored.trajectory.spin.values, -back.trajectory.spin.values, rtol=1e-8
    )
    assert max(back.drift.energy_balance, on.drift.energy_balance) < 1e-13

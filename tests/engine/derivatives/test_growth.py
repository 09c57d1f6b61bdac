"""How errors grow: exactly as the linear motion about an equilibrium does, and as runs that start
beside each other.
"""

import math

import numpy as np
import pytest

import tippetop as tt
from tippetop.runs.growth import Growth


def test_about_an_unstable_equilibrium_errors_grow_as_the_linear_motion_says() -> None:
    """A cylinder with its centre of mass above: theta'' = s^2 (theta - pi), and the matrix of it is
    known.
    """
    m, R, alpha, I, g = 0.1, 0.04, 0.3, 5e-5, 9.82
    c = alpha * R
    rate = math.sqrt(m * g * c / (I + m * (R + c) ** 2))
    cylinder = tt.Cylinder(m=m, R=R, alpha=alpha, I=I, g=g)
    table = tt.derivatives.lyapunov(cylinder, start={"theta": math.pi}, until=1.0, rows=6)
    second = 2.0 ** round(math.log2(math.sqrt(R / g)))
    for t, factor in zip(table.time.values, table.factor.values, strict=True):
        x, k = rate * t, rate * second
        matrix = [[math.cosh(x), math.sinh(x) / k], [k * math.sinh(x), math.cosh(x)]]
        assert factor == pytest.approx(np.linalg.norm(matrix, 2), rel=1e-6)


def state_at(nudge: dict[str, float], t: float) -> np.ndarray:
    """3hat, L and r' of a tippe top that begins a little off, in units of m, R and 2^-4 s."""
    run = tt.run(
        "inverting", start={**START, **{k: START[k] + v for k, v in nudge.items()}}, until=t
    )
    end = run.trajectory.isel(time=-1)
    u, L = end.axis.values, end.L.values
    p = run.attributes["parameters"]
    m, R, c = p["m"], p["R"], p["alpha"] * p["R"]
    omega = L / p["I1"] + (1 / p["I3"] - 1 / p["I1"]) * (L @ u) * u
    e = np.array([u[0], u[1], 0.0]) / np.hypot(u[0], u[1])
    v = end.nu_x.item() * e + end.nu_y.item() * np.array([-e[1], e[0], 0.0])
    place = (v - np.cross(omega, c * u - [0.0, 0.0, R]))[:2]
    return np.concatenate([u, L * SECOND / (m * R**2), place * SECOND / R])


SECOND = 2.0**-4
START = {
    "theta": 0.3,
    "phi": 0.1,
    "theta_dot": 2.0,
    "phi_dot": 5.0,
    "omega3": 100.0,
    "nu_x": 0.05,
    "nu_y": -0.1,
}


def test_the_factor_is_that_of_nearby_runs() -> None:
    """Differences of runs, in the norm of 3hat, L and r'."""
    growth, t = (
        tt.derivatives.lyapunov("inverting", start=START, until=0.25, rows=2).factor.values[-1],
        0.25,
    )
    h = dict.fromkeys(START, 1e-6) | {"theta_dot": 1e-4, "phi_dot": 1e-4, "omega3": 1e-3}
    first, last = (
        np.array([(state_at({k: d}, t) - state_at({k: -d}, t)) / (2 * d) for k, d in h.items()]).T
        for t in (1e-9, t)
    )
    assert growth == pytest.approx(np.linalg.norm(last @ np.linalg.pinv(first), 2), rel=1e-5)


def test_the_horizon_is_where_the_error_is_a_thousandth() -> None:
    t = np.linspace(0, 10, 11)
    growth = Growth(t, np.exp(4.0 * t))
    assert growth.horizon == pytest.approx(math.log(1e13) / 4)
    np.testing.assert_allclose(growth.exponents[1:], 4.0)
    assert "grows to 1e-3 at t = 7.4834 s: double precision" in growth.sentence()
    assert math.isnan(Growth(t, np.exp(t)).horizon)
    assert "at most 2.2e-12 (Lyapunov exponent 1 1/s" in Growth(t, np.exp(t)).sentence()

"""Friction of a patch: against quadratures of Coulomb's law over the pressure of Hertz, at every
point of the disc.
"""

import math
from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import brentq

from tippetop.mechanics import disc_friction as disc
from tippetop.mechanics.operand import Vector


def quadrature(x: float) -> tuple[mp.mpf, mp.mpf]:
    """f and m of a disc of radius 1 that turns with Omega = 1 while its centre slides with x: over
    rings, by elliptic integrals of one ring (a point of it slides with x e + r t).
    """
    x = mp.mpf(x)

    def ring(r: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        """The mean of the unit vector of slip along e, and of its moment, over a ring."""
        total, root = x + r, abs(x - r) / (x + r)
        inverse = (
            1 / (mp.agm(1, root) * total) if root else mp.mpf(0)
        )  # mean of 1/|..|; x^2 - r^2 vanishes there
        mean = 2 * total * mp.ellipe((1 - root) * (1 + root)) / mp.pi
        along = (mean + (x**2 - r**2) * inverse) / (2 * x)
        return along, (mean + (r**2 - x**2) * inverse) / 2

    cuts = [0, x, 1] if x < 1 else [0, 1]
    force, torque = (
        mp.quad(lambda r, i=i: 3 * r * mp.sqrt(1 - r * r) * ring(r)[i], cuts) for i in (0, 1)
    )
    return force, torque


X = (1e-3, 0.5, 0.999, 1.001, 1.3, 2.49, 2.51, 29.0, 31.0, 1e3)


@pytest.mark.parametrize("x", X)
def test_force_and_torque_are_those_of_the_pressure_of_hertz(x: float) -> None:
    with mp.workdps(20):
        f, m = quadrature(x)
    for U in (1.0, 7.0):
        found = disc.drag((x * U) ** 2, U**2)
        assert found.k * x * U == pytest.approx(float(f), rel=4e-15)
        assert found.twist * U == pytest.approx(float(m), rel=2e-14)


def test_small_slip_is_viscous_and_fast_slip_is_coulomb() -> None:
    assert disc.drag(0.0, 4.0).k == pytest.approx(3 * np.pi / 16, rel=1e-15)
    assert disc.drag(4.0, 0.0).k == 0.5
    assert disc.drag(4.0, 0.0).twist == pytest.approx(0.1, rel=1e-15)
    assert disc.drag(0.0, 0.0) == (np.inf, np.inf)


def test_a_patch_takes_energy() -> None:
    v, Omega_z, patch, mu, N = Vector(0.3, -0.4, 0.0), -120.0, 5e-4, 0.3, 0.2
    made = disc.drag(0.25, (patch * Omega_z) ** 2)
    F = disc.drilling_force(N, v, made, mu)
    torque = -mu * N * patch**2 * made.twist * Omega_z
    _, m = quadrature(0.5 / (patch * 120.0))
    assert torque == pytest.approx(mu * N * patch * float(m), rel=1e-13)
    assert F.x * v.x + F.y * v.y + torque * Omega_z < 0
    assert F.x * v.y == pytest.approx(F.y * v.x, rel=1e-14)  # against the slip
    assert F.z == N


def test_rolling_resistance_is_a_torque_against_the_horizontal_turn() -> None:
    found = disc.rolling(Vector(3.0, -4.0, 9.0), SimpleNamespace(mu_r=1e-3))
    assert found == pytest.approx((-0.6e-3, 0.8e-3, 0), rel=1e-12)


def test_the_direction_of_rolling_is_smooth_where_rolling_stops() -> None:
    """The torque grows to mu_r within some STOPS_ROLLING."""
    sizes = [
        -disc.rolling(Vector(share * disc.STOPS_ROLLING, 0.0, 9.0), SimpleNamespace(mu_r=1.0)).x
        for share in (0.0, 1.0, 1e4)
    ]
    assert sizes == pytest.approx([0, math.sqrt(0.5), 1], rel=1e-7)


@pytest.mark.parametrize("name", disc.REGIONS)
def test_drag_is_continuous_at_the_borders_of_a_region(name: str) -> None:
    """Each border is crossed once as the slip grows."""
    U = 0.1 * disc.SLOW
    for border in disc.REGIONS[name].borders:
        w = brentq(
            lambda w, border=border: border.beyond(SimpleNamespace(v2=w**2, U2=U**2), None),
            0,
            1e3 * U,
            xtol=1e-15 * U,
        )
        here, there = (disc.REGIONS[side].drag(w**2, U**2) for side in (name, border.follows))
        assert [*here] == pytest.approx([*there], rel=1e-11)

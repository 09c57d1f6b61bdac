"""The spinning states of a tippe top and the wells of its potential, against the published V in 60
digits.
"""

from typing import Any

import landscape_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from tippetop.mechanics.operand import leaves, refill
from tippetop.mechanics.systems import tippe_top
from tippetop.mechanics.theory import spinning, thresholds


SMALL = mp.mpf(10) ** -20  # away from the end of the potential, where its terms are 0/0
BODIES = {
    "figure 4.1": oracle.FIGURE,
    "two minima": oracle.parameters(0.3, 3.0, 4.0),
    "slender": oracle.parameters(0.8, 0.6, 0.7),
}
every_body = pytest.mark.parametrize("name", BODIES)
every_end = pytest.mark.parametrize("z", [1, -1])


@every_body
@every_end
def test_a_marked_line_is_where_the_potential_has_an_end(name: str, z: int) -> None:
    """Next to it V grows like 1/(1 - z^2), on it it does not; D is that of a spin about
    the axis.
    """
    b, lam = oracle.body(BODIES[name]), mp.mpf("3e-6")
    D = spinning.momentum(z, lam, b)
    assert spinning.slope(z, b) * lam == D
    on, off = (oracle.potential(z * (1 - SMALL), x, lam, b) for x in (D, D * (1 + mp.mpf("1e-6"))))
    assert abs(on / spinning.energy(z, lam, b) - 1) < 1e-18
    assert off / on > 1e6
    spin = thresholds.spin(z, lam, b)
    assert (
        abs(b.I3 * spin * (b.R * z - b.c) / lam - 1) < 1e-50
    )  # L_3 times the arm: Jellett's integral
    assert abs(b.I3 * spin * mp.sqrt(tippe_top.d(z, b)) / D - 1) < 1e-50


@every_body
def test_critical_function_is_the_slope_of_the_potential(name: str) -> None:
    """V_z = N/(gamma I1 R^2 (1 - z^2)^2), and N(-1) <= 0 <= N(1)."""
    b = oracle.body(BODIES[name])
    for z, D, lam in (("0.3", "1e-4", "2e-6"), ("-0.9", "-3e-4", "5e-6")):
        z, D, lam = mp.mpf(z), mp.mpf(D), mp.mpf(lam)
        slope = mp.diff(lambda z, D=D, lam=lam: oracle.potential(z, D, lam, b), z)
        N = oracle.critical(z, D, lam, b)
        assert abs(N / (b.I1**2 / b.I3 * b.R**2 * (1 - z**2) ** 2) / slope - 1) < 1e-25
        assert oracle.critical(-1, D, lam, b) <= 0 <= oracle.critical(1, D, lam, b)


def bend(gamma: Any, alpha: float, sigma: float) -> Any:
    """d2V/dz2 at the inverted end where V is level there: negative iff V falls away from it, to
    another minimum.
    """
    b = oracle.body(oracle.parameters(0.5, 1.0, 1.0))
    I3 = b.m * b.R**2 / mp.mpf(sigma)
    b = b._replace(I3=I3, I1=gamma * I3, c=mp.mpf(alpha) * b.R)
    lam = spinning.lambda_pi(b)
    D, step = spinning.slope(-1, b) * lam, mp.mpf(10) ** -12
    V = [oracle.potential(-1 + n * step, D, lam, b) for n in (1, 2, 3)]
    return b, (V[0] - 2 * V[1] + V[2]) / step**2


@pytest.mark.parametrize(
    ("alpha", "sigma"), [(0.3, 2.5), (0.3, 4.0), (0.7, 1.1), (0.05, 30.0), (0.95, 0.9)]
)
def test_a_second_minimum_appears_where_the_potential_bends_down_at_its_level_end(
    alpha: float, sigma: float
) -> None:
    """gamma*, found from V alone, is what `two_wells_from` gives."""
    star = mp.findroot(
        lambda gamma: bend(gamma, alpha, sigma)[1], (1 + alpha, 4), solver="anderson", tol=1e-30
    )
    for gamma in star * (1 + np.array([-1e-8, 1e-8, -0.1, 0.1, 3.0])):
        b, bent = bend(gamma, alpha, sigma)
        b = refill(b, map(float, leaves(b)))
        two = tippe_top.LANDSCAPE.two_wells(b)
        assert two == (bent < 0) == (gamma > star)
        assert thresholds.two_wells_from(b) == pytest.approx(float(star), rel=1e-9)

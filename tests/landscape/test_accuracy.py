"""Test F, its minimiser and its gradient against 60 digits, at random and near marked lines."""

import landscape_oracle as oracle
import mpmath as mp
import numba
import numpy as np
import pytest

from tippetop.landscape import formulas, surface
from tippetop.landscape import landscape_body as bodies
from tippetop.mechanics.theory import spinning
from tippetop_kernels.minimise import Status


EXTREME = {
    "alpha=0.001, gamma=1-alpha": (0.001, 0.9990000001, 2.5),
    "alpha=0.001, gamma=1+alpha": (0.001, 1.0009999999, 2.5),
    "alpha=0.999, gamma=0.501": (0.999, 0.501, 2.5),
    "alpha=0.999, gamma=1+alpha": (0.999, 1.9989999999, 2.5),
    "alpha=0.999 inside the ball": (0.999, 1.0, 1000.0),
    "gamma=1-alpha": (0.3, 0.7000000001, 2.5),
    "gamma=1+alpha": (0.3, 1.2999999999, 2.5),
    "heavy sphere": (0.7, 1.0, 45.0),
    "light sphere": (0.3, 0.94, 0.01),
}


def pointwise(t, D, lam):
    """F, q, status at points (D[i], lam[i])."""
    return tuple(
        np.concatenate(a).ravel()
        for a in zip(
            *(surface.minima(t, D[i : i + 1], lam[i : i + 1]) for i in range(D.size)), strict=True
        )
    )


def worst(parameters, points):
    """Return the largest errors of F in ulp and of q relative to its conditioning."""
    t, b = bodies.top(parameters), oracle.body(parameters)
    D, lam = points
    F, q, status = pointwise(t, D, lam)
    assert not np.isin(status, [Status.UNSETTLED, Status.UNDEFINED]).any()
    errors = []
    for i in range(D.size):
        exact, q_exact = oracle.minimum(D[i], lam[i], b, q[i])
        p = formulas.at_momenta(D[i], lam[i], t.coefficients)
        # rounding of the slope, some units of F, over its rate of change
        condition = F[i] / formulas.curvature(q[i], p, t.coefficients)
        in_ulp = oracle.ulps(F[i], exact)
        errors.append((in_ulp, float(abs(q[i] / q_exact - 1)) / (2**-52 * max(condition, 1))))
    return np.max(errors, axis=0)


few_or_many = pytest.mark.parametrize("count", [50, pytest.param(1000, marks=pytest.mark.slow)])


@few_or_many
@pytest.mark.parametrize("points", [oracle.boxed, oracle.scattered, oracle.marked])
def test_surface_at_random_points(points, count):
    in_ulp, in_condition = worst(oracle.FIGURE, points(oracle.FIGURE, count, seed=1))
    assert in_ulp < 1
    assert in_condition < 8


@few_or_many
@pytest.mark.parametrize("numbers", EXTREME.values(), ids=EXTREME)
def test_surface_of_extreme_bodies(numbers, count):
    parameters = oracle.parameters(*numbers)
    for points in (oracle.boxed, oracle.scattered, oracle.marked):
        in_ulp, in_condition = worst(parameters, points(parameters, count // 5, seed=3))
        assert in_ulp < 4
        assert in_condition < 64


def slopes_at(z, D, lam, b):
    """dV/dD and dV/dlambda in 60 digits."""
    by_D = mp.diff(lambda factor: oracle.potential(z, factor * D, lam, b), 1) / D
    return by_D, mp.diff(lambda factor: oracle.potential(z, D, factor * lam, b), 1) / lam


@few_or_many
@pytest.mark.parametrize("points", [oracle.boxed, oracle.scattered, oracle.marked])
def test_gradient_is_that_of_the_exact_surface(points, count):
    """Agree to a few roundings, also where X of the minimum is 1e-12 of its terms."""
    for parameters in (
        oracle.FIGURE,
        *(oracle.parameters(*numbers) for numbers in EXTREME.values()),
    ):
        b = oracle.body(parameters)
        for x, y in zip(*points(parameters, count // 15, seed=4), strict=True):
            found = surface.minimal_surface(bodies.top(parameters), x, y)
            near = (1 - found.z.item()) / (1 + found.z.item())
            if not 1e-8 < near < 1e8:  # z does not tell q
                continue
            z = oracle.z_of(oracle.minimum(x, y, b, near)[1])
            by_D, by_lam = slopes_at(z, mp.mpf(x), mp.mpf(y), b)
            assert oracle.ulps(found.F_D.item(), by_D) < 4
            assert oracle.ulps(found.F_lambda.item(), by_lam) < 4


@numba.njit
def minima_along(D, lam, r):
    """Return the largest number of minima of V on 400 values of q at the points (D, lam)."""
    worst = 0
    for i in range(D.size):
        p, count, before = formulas.at_momenta(D[i], lam[i], r), 0, -1.0
        for j in range(400):
            g = formulas.slopes(np.exp(80 * j / 399 - 40), p, r)[0]
            count += before < 0 < g
            before = g
        worst = max(worst, count)
    return worst


@pytest.mark.slow
def test_no_second_minimum_below_gamma_star():
    """Try 1500 bodies, inverting or not, around the marked lines: `two_wells` rests on it."""
    rng, found = np.random.default_rng(8), 0
    for _ in range(1500):
        alpha, sigma = rng.uniform(0.001, 0.999), 10 ** rng.uniform(-2, 3)
        gamma = rng.choice([rng.uniform(0.5, 1 + alpha), rng.uniform(1 + alpha, 6)])
        parameters = oracle.parameters(alpha, gamma, sigma)
        t, scale = bodies.top(parameters), oracle.scales(parameters)[1]
        slopes = np.array([spinning.slope(z, t.body) for z in (1, -1)])
        lam = scale * 10 ** rng.uniform(-1.5, 1.5, 60)
        D = (
            np.resize(slopes, 60)
            * lam
            * (1 + rng.choice([-1, 1], 60) * 10 ** rng.uniform(-8, 0, 60))
        )
        count = minima_along(D, lam, t.coefficients)
        assert count == 1 or t.two_wells, (
            f"{count} minima for alpha = {alpha}, gamma = {gamma}, sigma = {sigma}"
        )
        found += count > 1
    assert found > 50  # the scan does see second minima where they are allowed

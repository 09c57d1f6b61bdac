"""The landscape's formulas in plain floats, without kernels, against the published ones in 60
digits, at any q.
"""

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import examples
import landscape_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from tippetop.landscape import body as bodies
from tippetop.landscape import formulas
from tippetop.mechanics.doubledouble import DoubleDouble


class At(NamedTuple):
    """A point, a q, the exact potential as a function of q and the two momenta, and its value in 60
    digits.
    """

    q: float
    momenta: tuple[float, float]
    p: Any
    c: Any
    V: Callable
    exact: Any


TWO_MINIMA = oracle.parameters(0.3, 3.0, 4.0)
BODIES = {"tippe-top": oracle.FIGURE, "two minima": TWO_MINIMA, "heavy-top": examples.HEAVY}
POINTS = (oracle.boxed, oracle.scattered, oracle.marked)


def of_tippe_top(parameters: dict) -> Callable:
    b = oracle.body(parameters)
    return lambda q, D, lam: oracle.potential(oracle.z_of(q), D, lam, b)


def of_heavy_top(parameters: dict) -> Callable:
    """L3^2/2 I3 + (Lz - L3 z)^2/(2 I1* (1 - z^2)) + m g l z, with q = cot(theta/2)^2. [T 2.38]"""
    p = {name: mp.mpf(value) for name, value in parameters.items()}
    tip = p["I1"] + p["m"] * p["l"] ** 2

    def V(q: Any, L3: Any, Lz: Any) -> Any:
        z = (q - 1) / (q + 1)
        return (
            L3**2 / 2 / p["I3"]
            + (Lz - L3 * z) ** 2 / (2 * tip * (1 - z**2))
            + p["m"] * p["g"] * p["l"] * z
        )

    return V


def heavy_points(seed: int) -> Iterator[tuple[float, float]]:
    """Momenta where gravity and spin compete, over decades, and next to L3 = +-Lz."""
    rng = np.random.default_rng(seed)
    for sign in (1, -1):
        yield from rng.uniform(-0.02, 0.02, (4, 2)).tolist()
        yield from (rng.choice([-1, 1], (4, 2)) * 10 ** rng.uniform(-8, 2, (4, 2))).tolist()
        yield from (
            (x, sign * x * (1 + 10 ** rng.uniform(-15, -6)))
            for x in rng.uniform(-0.02, 0.02, 4).tolist()
        )


@lru_cache
def cases(name: str) -> tuple[At, ...]:
    """Points of a body; q at the guessed minimum and far from it."""
    heavy = name == "heavy-top"
    parameters, rng = BODIES[name], np.random.default_rng(7)
    t = bodies.top(parameters, "heavy-top" if heavy else "tippe-top")
    V = of_heavy_top(parameters) if heavy else of_tippe_top(parameters)
    points = (
        heavy_points(5)
        if heavy
        else ((x, y) for p in POINTS for x, y in np.array(p(parameters, 6, 5)).T.tolist())
    )
    made = []
    for momenta in points:
        p = formulas.at_momenta(*momenta, t.coefficients)
        near = float(formulas.guess(p, t.coefficients))
        for q in (near, *(near * 10 ** rng.uniform(-6, 6, 2)).tolist()):
            made.append(At(q, momenta, p, t.coefficients, V, V(mp.mpf(q), *map(mp.mpf, momenta))))
    return tuple(made)


every_body = pytest.mark.parametrize("name", BODIES)


@every_body
def test_potential_is_rounded_once(name: str) -> None:
    """Half a unit in the last place, and a little: the double-double has 25 digits next to the
    marked lines.
    """
    for at in cases(name):
        assert abs(mp.mpf(formulas.value(at.q, at.p, at.c)) - at.exact) <= 0.51 * math.ulp(
            float(at.exact)
        ), at
        both = formulas.potential(at.q, at.p, at.c)
        assert (
            abs(mp.mpf(both.head) + mp.mpf(both.tail) - at.exact) <= scale(at) * mp.mpf(10) ** -25
        ), at


def scale(at: At) -> Any:
    """The size of the terms of V, for heavy tops weighed from the plane through the tip."""
    return abs(at.exact) + abs(at.c.height_energy.head) + abs(at.c.height_gain.head)


@every_body
def test_excess_keeps_its_digits_where_level_and_potential_nearly_agree(name: str) -> None:
    for at in cases(name):
        for away in (0.0, 1e-15, 1e-8, 1.0):
            level = float(at.exact) * (1 + away)
            exact = at.exact - mp.mpf(level)
            found = mp.mpf(formulas.excess(at.q, level, at.p, at.c))
            assert abs(found - exact) <= 2.0**-52 * abs(exact) + scale(at) * mp.mpf(10) ** -25, at


def derivatives(at: At) -> list[Any]:
    """The first three derivatives of V by ln(q)."""
    x, y = map(mp.mpf, at.momenta)
    return [mp.diff(lambda s: at.V(at.q * mp.e**s, x, y), 0, n) for n in (1, 2, 3)]


@every_body
def test_slopes_are_the_derivatives(name: str) -> None:
    for at in cases(name):
        exact = derivatives(at)
        size = max(map(abs, exact))
        common = at.q * at.c.gamma.head
        for found, wanted in zip(formulas.slopes(at.q, at.p, at.c), exact, strict=True):
            assert abs(found / common - wanted) <= 4e-15 * size, at
        assert abs(formulas.curvature(at.q, at.p, at.c) - exact[1]) <= 4e-15 * size, at


@every_body
def test_gradient_is_that_by_the_momenta(name: str) -> None:
    for at in cases(name):
        x, y = map(mp.mpf, at.momenta)
        exact = (
            mp.diff(
                lambda x, at=at, y=y: at.V(mp.mpf(at.q), x, y), x, h=abs(x) * mp.mpf(10) ** -20
            ),
            mp.diff(
                lambda y, at=at, x=x: at.V(mp.mpf(at.q), x, y), y, h=abs(y) * mp.mpf(10) ** -20
            ),
        )
        by = formulas.momentum_slopes(at.q, at.p, at.c)
        per = 2 / (at.q * at.c.gamma.head)
        slopes = (per * (by.first.head + by.first.tail), per * (by.second.head + by.second.tail))
        for found, wanted, momentum in zip(slopes, exact, at.momenta, strict=True):
            assert abs(found - wanted) <= 1e-14 * (abs(wanted) + scale(at) / abs(momentum)), at


@pytest.mark.parametrize(("name", "close"), [("tippe-top", 0.01), ("heavy-top", 0.01)])
def test_guess_is_next_to_the_minimum(name: str, close: float) -> None:
    """K is small, or 0: a hundredth in ln(q); the slope changes its sign within."""
    for at in cases(name)[::3]:
        low, high = (formulas.slopes(at.q * math.exp(s), at.p, at.c)[0] for s in (-close, close))
        if formulas.ends(*at.momenta, at.p, at.c) == (False, False):
            assert low < 0 < high, at


@pytest.mark.parametrize("name", ["tippe-top", "two minima"])
@pytest.mark.parametrize("z", [1, -1])
def test_infimum_lies_at_an_end_exactly_on_its_marked_line(name: str, z: int) -> None:
    """Where X(z) = 0; at the inverted end only from lambda_pi on. [5.1]"""
    b, c = oracle.body(BODIES[name]), bodies.top(BODIES[name]).coefficients
    gamma, sigma, alpha = b.I1 / b.I3, b.m * b.R**2 / b.I3, b.c / b.R
    rho = mp.sqrt(gamma + sigma * (alpha - z) ** 2) / (b.R * (z - alpha))
    h = b.R + b.c
    lam_pi = (
        2
        * h
        * mp.sqrt(b.m * b.g * b.c * b.I3 * (gamma + sigma * (1 + alpha) ** 2))
        / (1 + b.m * b.R * h / b.I3)
    )
    for factor in (0.01, 0.999, 1.001, 50.0):
        for sign in (1, -1):
            lam = float(sign * factor * lam_pi)
            on = float(rho * lam)
            expected = (True, False) if z == 1 else (False, factor > 1)
            assert formulas.ends(on, lam, formulas.at_momenta(on, lam, c), c) == expected
            for away in (1e-12, -1e-12):
                off = on * (1 + away)
                assert formulas.ends(off, lam, formulas.at_momenta(off, lam, c), c) == (
                    False,
                    False,
                )


@pytest.mark.parametrize("name", ["tippe-top", "two minima"])
def test_pole_values_are_the_rates_of_X_where_X_vanishes_at_the_other_pole(name: str) -> None:
    """Y = a + b q + k psi: without a it rises as |b'| q from q = 0, without b it tends to |a'| as q
    -> oo.
    """
    none = DoubleDouble(0.0, 0.0)
    for at in cases(name):
        for q, p, which in ((1e-14, at.p._replace(a=none), 1), (1e14, at.p._replace(b=none), 0)):
            psi = formulas.psi(q, p, at.c).head
            Y = p.a.head + q * p.b.head + p.k.head * psi
            exact = abs(Y / q if which else Y)
            size = abs(p.a.head) + abs(p.b.head) + abs(p.k.head * psi / (q if which else 1.0))
            assert abs(formulas.pole_values(p, at.c)[which] - exact) <= 1e-6 * size, at


@pytest.mark.parametrize(("a", "b"), [(1.0, 2.0), (3.0, 0.1), (0.01, 5.0), (0.4, 0.4)])
def test_the_guess_is_sharpened_with_the_cube_of_its_error(a: float, b: float) -> None:
    c = bodies.top(oracle.FIGURE).coefficients
    gain = mp.mpf(c.root_gamma_gain)
    a, b = a * c.root_gamma_gain, b * c.root_gamma_gain
    root = mp.findroot(
        lambda s: mp.log(b**2 + (gain / (1 + mp.e**s)) ** 2) / 2 + s - mp.log(a),
        (-9, 9),
        "anderson",
    )
    for away in (0.1, 0.03, 0.01, 1e-3):
        for sign in (1, -1):
            rough = formulas.Sketch(float(mp.exp(root + sign * away)), a, b)
            sharp = formulas.sharper(rough, c)
            assert abs(mp.log(sharp.q) - root) <= 0.5 * away**3 + 1e-15

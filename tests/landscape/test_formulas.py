"""Test the formulas of the landscape in plain floats against those published, in 60 digits."""

import math
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from typing import Any, NamedTuple

import examples
import landscape_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from tippetop.landscape import formulas
from tippetop.landscape import landscape_body as bodies
from tippetop.mechanics.theory import spinning


class At(NamedTuple):
    """A point, a q, the exact potential over q and the momenta, and its value in 60 digits."""

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
    """Err by half a unit in the last place: next to the marked lines there are 25 digits."""
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
            found = mp.mpf(formulas.excess(at.q, (at.p, level), at.c))
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


def minimum(at: At) -> Any:
    """Return ln(q) of the minimum of V next to the guess."""
    x, y = map(mp.mpf, at.momenta)
    near = mp.log(at.q)
    slope = partial(mp.diff, lambda s: at.V(mp.e**s, x, y))
    return mp.findroot(slope, (near - 1e-3, near + 1e-3))


def gradient(at: At, s: Any) -> tuple[Any, Any]:
    """The derivatives of V by the momenta where ln(q) = s."""
    x, y = map(mp.mpf, at.momenta)
    by_first = mp.diff(lambda share: at.V(mp.e**s, share * x, y), 1) / x
    return by_first, mp.diff(lambda share: at.V(mp.e**s, x, share * y), 1) / y


@every_body
def test_the_gradient_of_the_surface_is_that_of_the_potential_at_its_minimum(name: str) -> None:
    """Also from a q next to the minimum, to second order in the distance."""
    for at in cases(name)[::3]:
        s = minimum(at)
        exact = gradient(at, s)
        for away, allowed in ((0.0, 8e-16), (1e-9, 2e-12), (-1e-9, 2e-12)):
            found = formulas.surface_gradient(float(mp.e ** (s + away)), at.p, at.c)
            for mine, theirs in zip(found, exact, strict=True):
                assert abs(mine - theirs) <= allowed * abs(theirs), at


@pytest.mark.parametrize(("name", "allowed"), [("tippe-top", 0.005), ("heavy-top", 0.0005)])
def test_the_guess_is_near_the_minimum(name: str, allowed: float) -> None:
    for at in cases(name)[::3]:
        assert abs(mp.log(at.q) - minimum(at)) < allowed, at


@pytest.mark.parametrize(("name", "allowed"), [("tippe-top", 0.01), ("two minima", 0.4)])
def test_values_at_the_poles_include_the_part_of_psi(name: str, allowed: float) -> None:
    """k psi is that where a and b q balance, to first order in K, and is split as a : b."""
    for at in cases(name)[::3]:
        a, b = abs(at.p.a.head), abs(at.p.b.head)
        part = at.p.k.head * formulas.psi(a / b, at.p, at.c).head / (a + b)
        found = formulas.pole_values(at.p, at.c)
        for mine, pole, more in zip(found, at.p, (part * a, part * b * b / a), strict=False):
            error = min(abs(sign * mine - pole.head - more) for sign in (1, -1))
            assert error <= allowed * abs(more) + 1e-15 * abs(pole.head), at


@every_body
def test_the_steps_of_the_guess_solve_their_equations(name: str) -> None:
    """A step of Halley leaves a part of the third power of the error."""
    for at in cases(name)[::3]:
        start, g = formulas.rough(at.p, at.c), at.c.root_gamma_gain
        assert start.q * (start.b + g / (1 + start.q)) == pytest.approx(start.a, rel=4e-15)
        root = mp.findroot(partial(balance, start.a, start.b, g), mp.log(at.q))
        for error in (1e-3, -1e-3):
            better = formulas.sharper(start._replace(q=float(mp.e ** (root + error))), at.c)
            assert abs(mp.log(better.q) - root) < 1e-9, at


def balance(a: float, b: float, g: float, s: Any) -> Any:
    """What vanishes at the minimum for K = 0, with q = e^s."""
    q = mp.e**s
    return (b * q) ** 2 + (g * q / (1 + q)) ** 2 - mp.mpf(a) ** 2


@pytest.mark.parametrize("parameters", [oracle.FIGURE, TWO_MINIMA])
def test_a_pole_is_reached_where_the_potential_falls_towards_it(parameters: dict) -> None:
    """On a marked line, within rounding errors; beyond q = 1 only where V falls."""
    b, c = oracle.body(parameters), bodies.top(parameters).coefficients
    V, falls = of_tippe_top(parameters), []
    for lam in (share * spinning.lambda_pi(b) for share in (0.5, 0.98, 1.02, 2.0)):
        for pole in (1, -1):
            D = spinning.slope(pole, b) * lam
            far = mp.mpf(10) ** (-12 * pole)
            falls.append(V(far**2, D, lam) < V(far, D, lam))
            for off, near in ((0, True), (1e-13, False), (-1e-13, False)):
                momenta = float(D * (1 + mp.mpf(off))), float(lam)
                found = formulas.reaches_pole(*momenta, formulas.at_momenta(*momenta, c), c)
                assert found == (near and falls[-1] and pole > 0, near and falls[-1] and pole < 0)
    assert falls == [True, False, True, False, True, True, True, True]

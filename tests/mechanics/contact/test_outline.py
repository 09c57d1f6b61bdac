"""Outlines: the ball by which a body touches is that of its support function."""

import re
from typing import Any

import laws
import numpy as np
import pytest
from scipy.integrate import quad

import tippetop as tt
from tippetop.mechanics.contact.body import Touch, height, touching_ball
from tippetop.mechanics.contact.outline import Rim, Spheroid
from tippetop.mechanics.friction import Frictionless, Viscous
from tippetop.mechanics.systems import outlook
from tippetop.mechanics.theory.modes import is_unstable
from tippetop.scenario import build


STEP = 1e-30
SHAPES = [
    Spheroid(1.5, 1.0, 0.2),
    Spheroid(0.4, 1.0, -0.1),
    Rim(1.0, 0.1, 0.3),
    Rim(0.7, 0.0, 0.0),
]
Z = np.linspace(-0.99, 0.99, 67)


def body(shape: Any, **numbers: float) -> Touch:
    numbers = {"m": 1.0, "I1": 0.3, "I3": 0.4, "g": 1.0} | numbers
    return Touch(R=(), c=(), friction=Frictionless(), outline=shape, **numbers)


def ball(z: Any, shape: Any) -> Touch:
    return touching_ball(z, (1 - z) * (1 + z), body(shape))


def support(n: np.ndarray, u: np.ndarray, shape: Any) -> Any:
    """Return the largest n.p of points p of a body; n has any length."""
    along, n2 = n @ u, n @ n
    if isinstance(shape, Spheroid):
        return np.sqrt(shape.a**2 * along**2 + shape.b**2 * (n2 - along**2)) + shape.c * along
    return shape.ring * np.sqrt(n2 - along**2) + shape.tube * np.sqrt(n2) + shape.c * along


@pytest.mark.parametrize("shape", SHAPES)
def test_the_arm_is_the_gradient_of_the_support_function(shape: Any) -> None:
    """So is that of the laws of `laws.py`, which the equations of motion are held against."""
    up = np.array([0.0, 0.0, 1.0])
    for z in Z:
        u = np.array([np.sqrt(1 - z * z), 0.0, z])
        expected = [np.imag(support(-up + 1j * STEP * e, u, shape)) / STEP for e in np.eye(3)]
        b = ball(z, shape)
        for found in (b.c * u - b.R * up, laws.arm_of(u, up, b)):
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
        assert height(z, b) == pytest.approx(support(-up, u, shape), abs=1e-15)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_ball_changes_by_its_bend(shape: Any) -> None:
    """R' = z c', c' is the bend, c'' the twist; both radii of curvature are positive."""
    b, ahead = ball(Z, shape), ball(Z + 1j * STEP, shape)
    for expected, found in (
        (np.imag(ahead.c) / STEP, b.outline.bend),
        (np.imag(ahead.R) / STEP, Z * b.outline.bend),
        (np.imag(ahead.outline.bend) / STEP, b.outline.twist),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert (b.R > 0).all()
    assert (b.R - b.outline.bend * (1 - Z * Z) > -1e-12).all()


def test_a_rim_of_a_point_and_a_round_spheroid_are_balls() -> None:
    for shape in (Rim(0.0, 2.0, 0.5), Spheroid(2.0, 2.0, 0.5)):
        b = ball(Z, shape)
        np.testing.assert_allclose([b.R, b.c, b.outline.bend], [[2.0] * 67, [0.5] * 67, [0.0] * 67])


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("a", [0.01, 0.02, 0.03])
@pytest.mark.parametrize("c", [-0.004, 0.0, 0.004])
def test_what_check_says_of_spins_is_true(a: float, c: float, inverted: bool) -> None:
    """By the linear modes: of prolate, round and oblate bodies."""
    top = tt.Spheroid(m=0.06, a=a, b=0.02, c=c, I1="m*(a^2 + b^2)/5", I3="2/5*m*b^2", g=9.81)
    b = top.body(Viscous(0.5))
    words = outlook.spheroid(b, {"at_pole": False}).regime.split(", ")[inverted]
    if limit := re.search(r"is stable (above|below) (\S+) rad/s", words):
        above, spin = limit[1] == "above", float(limit[2])
        spins = {0.99 * spin: not above, 1.01 * spin: above}
    else:
        spins = dict.fromkeys((1.0, 30.0, 1000.0), not words.endswith("unstable"))
    for omega3, stable in spins.items():
        assert is_unstable(omega3, b, inverted=inverted) == (not stable), (omega3, words)


# --- the uniform body ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("top", "end", "radius"),
    [
        (tt.Spheroid(0.06, 0.03, 0.02), 0.03, lambda x: 0.02 * np.sqrt(1 - (x / 0.03) ** 2)),
        (tt.Disc("8 g", 0.011, "2 mm"), 0.002, lambda x: 0.011 + np.sqrt(0.002**2 - x**2)),
        (tt.Disc(m=1.0, ring=1e-9, tube=1.0), 1.0, lambda x: np.sqrt(1 - x**2)),
    ],
)
def test_a_body_is_uniform_by_default(top: Any, end: float, radius: Any) -> None:
    """Its moments are sums over slices across the axis."""
    whole, I3, more = (
        quad(lambda x, n=n, k=k: radius(x) ** n * x**k, -end, end, epsabs=0, epsrel=1e-10)[0]
        for n, k in ((2, 0), (4, 0), (2, 2))
    )
    expected = top.m * (I3 / 4 + more) / whole, top.m * I3 / (2 * whole)
    np.testing.assert_allclose([top.I1, top.I3], expected, rtol=1e-8)
    assert top.g == 9.81


def test_the_uniform_body_is_that_of_a_scenario_too() -> None:
    tables: dict[str, Any] = {"system": "rolling-spheroid", "run": {"until": 1.0}}
    given = {"m": "60 g", "a": 0.03, "b": 0.02, "I3": "0.9*2/5*m*b^2"}
    problem = build.problem({**tables, "parameters": given})
    assert problem.parameters == tt.Spheroid(**given)._asdict()
    assert problem.parameters["I1"] == 1.56e-5
    for numbers, match in (({"c": 1e-3}, "I1` must be given where c is not 0"), ({"a": None}, "a")):
        with pytest.raises(tt.InputError, match=match):
            tt.Spheroid(**{**given, **numbers})
        with pytest.raises(tt.InputError, match=match):
            build.problem({**tables, "parameters": {**given, **numbers}})

"""Outlines: the ball by which a body touches is that of its support function."""

import re
from typing import Any

import laws
import numpy as np
import pytest
import tilted
from limits import assert_near
from refusals import refusal
from scipy.integrate import quad

import tippetop as tt
from tippetop.mechanics.contact.body import Touch, height, touching_ball
from tippetop.mechanics.contact.outline import Rim, Spheroid, at, root, shape_by
from tippetop.mechanics.friction import Frictionless, Viscous
from tippetop.mechanics.operand import Vector
from tippetop.mechanics.systems import outlook
from tippetop.mechanics.theory.modes import is_unstable
from tippetop.scenario import build


STEP = 1e-30
OVAL = shape_by(
    lambda z, s2, b: (
        root(z**2 * b.a**2 + b.b**2 * s2) + b.k * z**3 * (2 + z) / (2 - -z) - 1 / (1 / b.c / z)
    ),
    ("a", "b", "k", "c"),
)
SHAPES = [
    OVAL(1.5, 1.0, 0.1, 0.2),
    Spheroid(1.5, 1.0, 0.2),
    Spheroid(0.4, 1.0, -0.1),
    Rim(1.0, 0.1, 0.3),
    Rim(0.7, 0.0, 0.0),
]
Z = np.linspace(-0.99, 0.99, 68)
STILL = {"at_pole": 0.0, "theta": 1.0, "phi_dot": 0.0}


def body(shape: Any, **numbers: float) -> Touch:
    numbers = {"m": 1.0, "I1": 0.3, "I3": 0.4, "g": 1.0} | numbers
    return Touch(R=(), c=(), friction=Frictionless(), outline=shape, **numbers)


def ball(z: Any, shape: Any) -> Touch:
    return touching_ball(z, (1 - z) * (1 + z), body(shape))


def support(n: np.ndarray, u: np.ndarray, shape: Any) -> Any:
    """Return the largest n.p of points p of a body; n has any length."""
    along, n2 = n @ u, n @ n
    if not isinstance(shape, Rim):
        thinner = getattr(shape, "k", 0.0) * along**3 / n2
        whole = np.sqrt(shape.a**2 * along**2 + shape.b**2 * (n2 - along**2))
        return whole - thinner + shape.c * along
    return shape.ring * np.sqrt(n2 - along**2) + shape.tube * np.sqrt(n2) + shape.c * along


@pytest.mark.parametrize("shape", SHAPES)
def test_the_arm_is_the_gradient_of_the_support_function(shape: Any) -> None:
    """So are those of `laws.py` and `tilted.py`, which motions are held against."""
    up = np.array([0.0, 0.0, 1.0])
    rim = isinstance(shape, Rim)
    size = {"ring": shape.ring, "tube": shape.tube} if rim else {}
    half = np.zeros(3) if rim else np.array([shape.b, shape.b, shape.a])
    own = tilted.Body(1.0, (1, 1, 1), [0, 0, shape.c], half, 1.0, **size)
    for z in Z:
        u = np.array([np.sqrt(1 - z * z), 0.0, z])
        expected = [np.imag(support(-up + 1j * STEP * e, u, shape)) / STEP for e in np.eye(3)]
        b = ball(z, shape)
        for found in (b.c * u - b.R * up, laws.arm_of(u, up, b)):
            assert_near(found, expected, 1e-13)
        if not hasattr(shape, "k"):
            axes = np.array([[z, 0, u[0]], [0, 1, 0], [-u[0], 0, z]])  # of the body, columns
            found = axes @ own.reached(axes.T @ up)
            assert_near(found, expected, 1e-13)
        assert height(z, b) == pytest.approx(support(-up, u, shape), abs=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_the_arm_of_an_ellipsoid_is_the_gradient_of_its_support_function(seed: int) -> None:
    """So is that of `tilted.py`."""
    rng = np.random.default_rng(seed)
    half, centre, turn = rng.uniform(0.5, 2, 3), rng.uniform(-0.2, 0.2, 3), rng.uniform(-3, 3)
    names = "m", "a", "b", "c", "delta", "x", "y", "h", "I1", "I2", "I3", "g"
    values = 1.0, *half, turn, *centre, 0.4, 0.5, 0.6, 1.0
    outline = tt.Ellipsoid.body_of(dict(zip(names, values, strict=True)), ()).outline
    own = tilted.Body(1.0, (1, 1, 1), [*centre], half, 1.0, turn=turn)
    cos, sin = np.cos(turn), np.sin(turn)
    axes = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])  # rows: those of the half axes

    def support(n: np.ndarray) -> Any:
        return np.sqrt(((half * (axes @ n)) ** 2).sum()) + centre @ n

    for up in rng.normal(size=(20, 3)):
        n = up / np.linalg.norm(up)
        expected = [np.imag(support(-n + 1j * STEP * e)) / STEP for e in np.eye(3)]
        for found in (outline.arm(Vector(*n)), own.reached(n)):
            assert_near(found, expected, 1e-14)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_ball_changes_by_its_bend(shape: Any) -> None:
    """R' = z c', c' is the bend; both radii of curvature are positive."""
    b, ahead = ball(Z, shape), ball(Z + 1j * STEP, shape)
    for expected, found in (
        (np.imag(ahead.c) / STEP, b.bend),
        (np.imag(ahead.R) / STEP, Z * b.bend),
        (np.imag(ahead.bend) / STEP, -at(Z, (1 - Z) * (1 + Z), shape.height).parts[3]),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert (b.R > 0).all()
    assert (b.R - b.bend * (1 - Z * Z) > -1e-12).all()


def test_a_rim_of_a_point_and_a_round_spheroid_are_balls() -> None:
    for shape in (Rim(0.0, 2.0, 0.5), Spheroid(2.0, 2.0, 0.5)):
        b = ball(Z, shape)
        np.testing.assert_allclose([b.R, b.c, b.bend], [[2.0] * 68, [0.5] * 68, [0.0] * 68])


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("a", [0.01, 0.02, 0.03])
@pytest.mark.parametrize("c", [-0.004, 0.0, 0.004])
def test_what_check_says_of_spins_is_true(a: float, c: float, inverted: bool) -> None:
    """By the linear modes: of prolate, round and oblate bodies."""
    top = tt.Spheroid(m=0.06, a=a, b=0.02, c=c, I1="m*(a^2 + b^2)/5", I3="2/5*m*b^2", g=9.81)
    b = top.body(Viscous(0.5))
    words = outlook.revolution(b, STILL).regime.split(", ")[inverted]
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
        with refusal(match):
            tt.Spheroid(**{**given, **numbers})
        with refusal(match):
            build.problem({**tables, "parameters": {**given, **numbers}})


# --- predictions --------------------------------------------------------------------------------

EGG = tt.Spheroid(m=0.06, a=0.03, b=0.02)
COIN = tt.Disc(m=0.01, ring=0.02, tube=0.002, c=1e-3, I1=1e-6, I3=2e-6)


@pytest.mark.parametrize("inverted", [False, True])
def test_a_rolling_egg_stands_by_the_spin_that_check_names(inverted: bool) -> None:
    """By runs on either side of it, of a body that is heavier at one end."""
    top = EGG._replace(c=0.002)
    name, pole = ("inverted", np.pi) if inverted else ("upright", 0.0)
    known = outlook.revolution(top.body(), STILL, rolls=True).thresholds
    limit = known[f"spin_{name}"].value
    for share, falls in ((0.98, True), (1.02, False)):
        start = {"theta": abs(pole - 1e-5), "omega3": share * limit}
        run = tt.run(top, start=start, until=3.0, output="steps")
        away = np.abs(run.trajectory.theta.values - pole)
        assert (away.max() > 1e-2) == falls


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_gliding_egg_stands_by_the_spin_of_the_uniform_spheroid(share: float) -> None:
    """omega_3^2 = 5 g a^3/b^4, by runs on either side of it."""
    limit = np.sqrt(5 * EGG.g * EGG.a**3 / EGG.b**4)
    law = tt.friction.Viscous(mu=1.0)
    known = outlook.revolution(EGG.body(law), STILL).thresholds["spin_upright"]
    assert known.value == pytest.approx(limit, rel=1e-12)
    run = tt.run(EGG, law, start={"theta": 1e-3, "omega3": share * limit}, until=20.0)
    assert (run.trajectory.theta.values[-1] > 1e-3) == (share < 1)


def test_where_a_body_rests_its_height_is_stationary() -> None:
    top = tt.Spheroid(0.06, 0.03, 0.02, c=0.004, I1=1.56e-5, I3=9.6e-6)
    known = outlook.revolution(top.body(), STILL).thresholds
    theta = np.linspace(0, np.pi, 100_001)
    heights = height(np.cos(theta), touching_ball(np.cos(theta), np.sin(theta) ** 2, top.body()))
    tilted = known["height_tilted"]
    assert tilted.value == pytest.approx(heights.min(), rel=1e-8)
    assert f"{theta[heights.argmin()]:.4f}" in tilted.long_name
    assert "least" in tilted.long_name
    for name, place in (("upright", 0), ("inverted", -1)):
        assert known[f"height_{name}"].value == pytest.approx(heights[place])


@pytest.mark.parametrize("rolls", [False, True])
def test_a_disc_rolls_steadily_as_check_predicts(rolls: bool) -> None:
    start = {"theta": 1.1, "phi_dot": 12.0}
    known = outlook.revolution(COIN.body(), STILL | start, rolls=rolls).thresholds
    start["omega3"] = known["spin_steady"].value
    law = None if rolls else tt.friction.Coulomb(mu=1.01 * known["mu_steady"].value)
    rows = tt.run(
        COIN, law, start={**start, **({} if rolls else {"nu_x": 0.0})}, until=1.0
    ).trajectory
    assert_near(rows.theta, 1.1, 1e-12)
    if rolls:
        np.testing.assert_allclose(rows.friction_needed, known["mu_steady"].value, rtol=1e-12)


@pytest.mark.parametrize("tube", [0.0, 0.002])
def test_the_spin_of_steady_rolling_keeps_its_digits_at_every_rate(tube: float) -> None:
    """Gravity and inertia balance: omega_3 phi' is linear in phi'^2; mu has a limit at phi' = 0."""
    coin = COIN._replace(tube=tube).body()
    rates = np.array([1.0, 2.0, 1e-9, 1e-3, 30.0, 1e4])
    found = [outlook.revolution(coin, STILL | {"phi_dot": rate}).thresholds for rate in rates]
    products = rates * [known["spin_steady"].value for known in found]
    slope = (products[1] - products[0]) / 3
    np.testing.assert_allclose(products, products[0] + slope * (rates**2 - 1), rtol=1e-12)
    slow = [found[k]["mu_steady"].value for k in (2, 3)]
    assert slow[0] == pytest.approx(slow[1], rel=1e-6)


@pytest.mark.parametrize("rolls", [False, True])
@pytest.mark.parametrize("name", ["spinning-egg", "spinning-coin"])
def test_what_is_of_spheres_only_is_refused(name: str, rolls: bool) -> None:
    name = name.replace("spinning", "rolling") if rolls else name
    for call in (
        lambda top: tt.theory.regime(top, 1e-6),
        lambda top: tt.theory.asymptotic_states(top, 1e-6),
        lambda top: tt.landscapes.minimal_surface(top, D=0.0, lam=0.0),
        lambda top: tt.landscapes.potential(top, 0.0, D=0.0, lam=0.0),
    ):
        with pytest.raises(tt.InputError) as raised:
            call(name)
        assert len(raised.value.sentences) == 1

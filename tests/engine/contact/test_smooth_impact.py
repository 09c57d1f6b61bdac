"""Impacts under smooth friction laws, against laws that share no code with them."""

from typing import Any

import heyoka as hy
import numpy as np
import pytest
from nightly import at_night
from scipy.linalg import expm
from scipy.optimize import brentq
from tippetop.engine.contact.balls import Balls

from tippetop.engine.contact import balls
from tippetop.engine.contact.smooth_impact import SmoothImpacts
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.impact import after_impact, arrival
from tippetop.mechanics.contact.response import Mobility, mobility
from tippetop.mechanics.contact.struck import struck
from tippetop.mechanics.friction import Coulomb, Viscous
from tippetop.mechanics.operand import Vector, leaves
from tippetop.scenario import build


def contacts(n: int = 20) -> list[tuple[Mobility, tuple[float, float, float]]]:
    """Mobilities of the canonical body, m = R = 1, and velocities before an impact."""
    rng = np.random.default_rng(5)
    ball = Touch(1.0, 1.0, 0.3, 131 / 350, 0.4, 1.0, None)
    angles = rng.uniform(0.1, 3.0, n)
    velocities = [(rng.normal(), rng.normal(), -rng.uniform(0.01, 1.0)) for _ in range(n)]
    return [(mobility(np.sin(a), np.cos(a), ball), v) for a, v in zip(angles, velocities, strict=True)]


@pytest.mark.parametrize("k", [0.0, 0.1, 2.0])
def test_viscous_friction_follows_its_linear_equation(k: float) -> None:
    """v' = A v + b by the normal impulse: the exponential of a matrix, to where v_n is -e_n of what it was."""
    for K, (v_e, v_2, v_n) in contacts():
        if K.zz - k * abs(K.ez * v_e) < 0.1:  # it jams, or nearly so
            continue
        A = np.zeros((4, 4))
        A[:3] = [[-k * K.ee, 0, 0, K.ez], [0, -k * K.tt, 0, 0], [-k * K.ez, 0, 0, K.zz]]
        start = np.array([v_e, v_2, v_n, 1.0])
        for e_n in (0.0, 0.6):

            def missing(p: float, A=A, start=start, goal=-e_n * v_n) -> float:
                return float((expm(A * p) @ start)[2] - goal)

            p_z = brentq(missing, 0.0, 20 * abs(v_n), xtol=1e-16, rtol=1e-15)
            exact = expm(A * p_z) @ start
            got = SmoothImpacts(Viscous(k), "newton").struck(v_e, v_2, v_n, K, 0.0, e_n)
            assert got.p_z == pytest.approx(p_z, rel=1e-12)
            assert (got.v_e, got.v_2, got.v_n) == pytest.approx(tuple(exact[:3]), abs=1e-12)


@pytest.mark.parametrize("restitution", ["energetic", "poisson", "newton"])
@pytest.mark.parametrize("size", [1.0, at_night(1e-6)])
def test_the_works_are_those_of_the_impulse(restitution: str, size: float) -> None:
    """The sum of the works is p.(v- + v+)/2, whatever the law and the speed; energetic: of the normal ones e_n^2 comes
    back; Poisson: of the normal impulse e_n."""
    impacts = SmoothImpacts(Coulomb(0.3, 0.1 * size), restitution)
    for K, v in contacts():
        v = tuple(size * x for x in v)
        got = impacts.struck(*v, K, 0.0, 0.5)
        p, after = np.array([got.p_e, got.p_2, got.p_z]), np.array([got.v_e, got.v_2, got.v_n])
        assert got.energy == pytest.approx(p @ (np.array(v) + after) / 2, abs=1e-13 * size**2)
        if restitution == "energetic":
            assert got.work_n == pytest.approx((1 - 0.25) * got.compression, rel=1e-12)
        if restitution == "poisson":
            assert got.p_z == pytest.approx(1.5 * impacts.struck(*v, K, 0.0, 0.0).p_z, rel=1e-12)


def test_the_regularised_law_tends_to_coulombs() -> None:
    """Sliding that does not stop differs from that under the law itself by the square of eps."""
    K, mu = contacts()[0][0], 0.2
    v = (3.0, 1.0, -0.5)
    exact = struck(*v, K, mu, 0.4)
    assert exact.mode == "slip"
    errors = []
    for eps in (4e-3, 2e-3, 1e-3):
        got = SmoothImpacts(Coulomb(mu, eps), "energetic").struck(*v, K, 0.0, 0.4)
        errors.append(np.hypot(got.p_e - exact.p_e, got.p_2 - exact.p_2))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize(
    ("number", "digits"), [(np.longdouble, 1e-18), pytest.param(hy.real128, 1e-32, marks=pytest.mark.slow)]
)
def test_an_impact_has_the_digits_of_its_numbers(number: Any, digits: float) -> None:
    """The works, which are integrated, and the impulse, which is not: in doubles they agree to 1e-16."""
    K, v = contacts()[1]
    K, v = Mobility(*(number(float(x)) for x in K)), [number(x) for x in v]
    law = Coulomb(number(0.3), number(0.1))
    got = SmoothImpacts(law, "energetic", number).struck(*v, K, number(0), number(0.5))
    p, after = (got.p_e, got.p_2, got.p_z), (got.v_e, got.v_2, got.v_n)
    energy = sum((a * (b + c) for a, b, c in zip(p, v, after, strict=True)), number(0)) / 2
    assert abs(got.energy - energy) < digits
    assert abs(got.work_n - got.compression * 3 / 4) < digits


def test_a_law_that_cannot_be_followed_is_refused() -> None:
    K, v = contacts()[0]
    with pytest.raises(ArithmeticError, match="no solution"):
        SmoothImpacts(Viscous(np.nan), "energetic").struck(*v, K, 0.0, 0.0)
    with pytest.raises(ArithmeticError, match="no solution"):  # v_e K_ez > 0 and k beyond K_zz/(K_ez v_e)
        SmoothImpacts(Viscous(abs(K.zz / K.ez)), "energetic").struck(3.0 * np.sign(K.ez), 0.0, -1.0, K, 0.0, 0.0)


@pytest.mark.parametrize("e_n", [0.0, 0.6])
def test_a_body_is_struck_in_machine_code_as_its_formulas_say(e_n: float) -> None:
    """The axis vertical, too: then e is the direction of the slip, or any where nothing slips."""
    ball = Touch(0.02, 0.02, 0.006, 3e-6, 3.2e-6, 9.82, None)
    impacts = SmoothImpacts(Viscous(0.3), "energetic")
    tilted, upright = Vector(0.48, 0.36, 0.8), Vector(0.0, 0.0, 1.0)
    starts = [(tilted, Vector(1e-4, 2e-4, 9e-4)), (upright, Vector(0.0, 1e-5, 9e-4)), (upright, Vector(0.0, 0.0, 9e-4))]
    for u, L in starts:
        velocity = Vector(0.02, -0.01, -0.3) if L.y else Vector(0.0, 0.0, -0.3)
        v, impact, after = impacts.body_struck(u, L, velocity, ball, e_n)
        a = arrival(u, L, velocity, ball)
        slow = impacts.struck(a.along, a.sideways, a.v.z, a.K, u.z, e_n)
        expected = after_impact(u, L, velocity, a, slow.p_e, slow.p_2, slow.p_z, 0.0, ball)
        np.testing.assert_allclose(v, a.v, rtol=0, atol=1e-17)
        np.testing.assert_allclose([*after.p, *after.L], [*expected.p, *expected.L], rtol=1e-14, atol=1e-20)
        np.testing.assert_allclose([*after.velocity, *after.v], [*expected.velocity, *expected.v], rtol=0, atol=1e-15)
        assert after.gained == pytest.approx(expected.gained, rel=1e-13)
        assert (impact.work_n, impact.work_t) == (slow.work_n, slow.work_t)
        assert (impact.p_e, impact.p_2) == pytest.approx((slow.p_e, slow.p_2), rel=1e-14, abs=1e-20)


def test_numbers_that_raise_are_kept_from_laws_and_stems_that_divide_by_zero() -> None:
    """A body on one ball under a smooth law has Python's numbers, which formulas take faster; all others numpy's, whose
    divisions by zero end no run."""
    plain = [type(leaf) for leaf in leaves(Balls(build.load("flying"))[0])]
    assert set(plain) == {float}
    for preset in ("plastic-toy", "wooden-toy", "cohen-coulomb", "leine-glocker-stem"):
        assert np.float64 in {type(leaf) for leaf in leaves(Balls(build.load(preset))[0])}, preset
    for law, value in ((Viscous(0.3), True), (Coulomb(0.3, 0.1), True), (Coulomb(0.3, 0.0), False)):
        assert balls._has_a_value_at_rest(law) is value

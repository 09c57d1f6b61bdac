"""Impacts under laws that are smooth in the sliding velocity, or have regions: against laws that
share no code with them, integrations of the whole body, and impacts of a point.
"""

from typing import Any

import heyoka as hy
import numpy as np
import pytest
from touching import gained, mobility, struck

from tippetop.engine import impacts
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.restitution import RESTITUTIONS
from tippetop.mechanics.friction import (
    Contensou,
    Coulomb,
    SetValued,
    Viscous,
)
from tippetop.mechanics.operand import exp, leaves, refill


PATCH = 5e-4
DISC = Touch(0.006, 0.015, 0.003, 8e-7, 7e-7, 9.81, Contensou(0.3, PATCH, 0.0))
TOP = Touch(1.0, 1.0, 0.3, 131 / 350, 0.4, 1.0, Viscous(0.3))
every_law = pytest.mark.parametrize("restitution", RESTITUTIONS)


def hit(v: Any, theta: float, b: Touch, *how: Any, **more: Any) -> Any:
    """The impact of a body that arrives with v = (v_e, v_2, v_n)."""
    return struck(v, np.sin(theta), np.cos(theta), b, *how, **more)


def under(mu: float, patch: float = PATCH) -> Touch:
    """The disc under friction of another size."""
    return DISC._replace(friction=Contensou(mu, patch, 0.0))


# --- laws with a coefficient --------------------------------------------------------------------


@pytest.mark.parametrize("law", [Viscous._make((np.nan,)), Viscous(1e3)])
def test_a_law_that_jams_the_contact_is_refused(law: Any) -> None:
    """v_e K_ez > 0 and k beyond K_zz/(K_ez v_e)."""
    with pytest.raises(ArithmeticError, match="no solution"):
        hit((3.0, 0.0, -1.0), 0.9, TOP._replace(friction=law), 0.0)


def test_a_law_that_is_too_stiff_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(impacts, "MOST_STEPS", 100)
    with pytest.raises(ArithmeticError, match="too stiff"):
        hit((0.02, 0.01, -0.3), 0.9, TOP._replace(friction=Coulomb(0.3, 1e-6)), 0.0)
    with pytest.raises(ArithmeticError, match="a disc that hardly turns"):
        hit((0.02, 0.01, -0.3), 0.9, under(0.3, 1e-5), 0.0)


@pytest.mark.parametrize(
    ("precision", "digits"), [("longdouble", 1e-18), pytest.param("quad", 1e-32)]
)
@pytest.mark.parametrize("law", [Coulomb(0.3, 0.1), SetValued(0.3), DISC.friction, Viscous(0.3)])
def test_an_impact_has_the_digits_of_its_numbers(precision: str, digits: float, law: Any) -> None:
    """Slip across the lean decays exponentially with the normal impulse of a viscous law."""
    number = {"longdouble": np.longdouble, "quad": hy.real128}[precision]
    v, body = tuple(number(x) for x in (0.1, -0.1, -0.3)), DISC._replace(friction=law)
    turn = number(80) if isinstance(law, Contensou) else number(0)
    body = body._replace(clearance=0.0, lever=0.0)
    b = refill(body, map(number, leaves(body)))
    s, z = (1 - number(0.6) ** 2) ** number(0.5), number(0.6)
    made = struck(v, s, z, b, number(0.5), "energetic", turn, precision)
    if isinstance(law, Viscous):
        decay = exp(-b.friction.mu * mobility(s, z, b).tt * made.p_z)
        assert abs(made.v_2 - v[1] * decay) < digits
    size = abs(made.compression)
    off, missed = made.energy - gained(v, made, turn), made.work_n - made.compression * 3 / 4
    assert abs(off) < 100 * digits * size, "the energy must be that of the impulses"
    assert abs(missed) < digits * size, "restitution must return e_n^2 of the compression"


# --- a contact disc that slides and turns -------------------------------------------------------


@every_law
@pytest.mark.parametrize("Omega_z", [0.0, 0.1])
def test_a_disc_that_hardly_turns_comes_to_rest_as_a_point_does(
    Omega_z: float, restitution: str
) -> None:
    v, b, e_n = (0.02, -0.03, -0.3), under(0.3, 2e-5), 0.5
    made = hit(v, 1.0, b, e_n, restitution, Omega_z)
    point = hit(v, 1.0, b._replace(friction=SetValued(b.friction.mu)), e_n, restitution)
    assert (point.v_e, point.v_2) == pytest.approx((0, 0), abs=1e-15)
    assert (made.v_e, made.v_2) == pytest.approx((0, 0), abs=1e-5)
    assert (made.v_n, made.p_z) == pytest.approx((point.v_n, point.p_z), rel=1e-5)
    assert made.energy == pytest.approx(point.energy, rel=1e-4)


@pytest.mark.parametrize("size", [0.01, 0.7])
@pytest.mark.parametrize("e_n", [0.0, 1.0])
def test_sliding_or_turning_of_an_upright_disc_stops(size: float, e_n: float) -> None:
    """In a line: the impulse is what takes it."""
    turns = hit((0.0, 0.0, -1.0), 0.0, DISC, e_n, Omega_z=size)
    slides = hit((0.0, size / 10, -1.0), 0.0, DISC, e_n)
    assert (turns.mode, slides.mode) == ("stick", "stick")
    assert (turns.Omega_z, slides.v_2) == pytest.approx((0, 0), abs=1e-14)
    assert turns.twist.z == pytest.approx(-size * DISC.I3, rel=1e-12)
    assert slides.p_2 == pytest.approx(-size / 10 / mobility(0.0, 1.0, DISC).tt, rel=1e-12)


@every_law
@pytest.mark.parametrize("theta", [0.5, 2.0])
def test_what_does_not_slide_is_pushed_so_that_it_stays_at_rest(
    theta: float, restitution: str
) -> None:
    """Of a slanted body the normal impulse would move the contact, too."""
    ball = under(0.6)
    made, K = (
        hit((0.0, 0.0, -1.0), theta, ball, 0.5, restitution),
        mobility(np.sin(theta), np.cos(theta), ball),
    )
    assert made.mode == "stick"
    assert (made.v_e, made.v_2, made.Omega_z) == pytest.approx((0, 0, 0), abs=1e-12)
    assert abs(K.ez * made.p_z) > 0.1
    assert K.ee * made.p_e + K.ez * made.p_z == pytest.approx(0, abs=1e-12)
    assert K.ez * made.p_e + K.zz * made.p_z == pytest.approx(made.v_n + 1, rel=1e-12)
    assert made.energy == pytest.approx(made.p_z * (made.v_n - 1) / 2, rel=1e-12)


@every_law
@pytest.mark.parametrize("theta", [0.5, 2.6])
@pytest.mark.parametrize("v_e", [0.0, 1e-3, -1e-3])
def test_what_friction_cannot_hold_slips_as_a_point_does(
    v_e: float, theta: float, restitution: str
) -> None:
    """Without drilling, from rest or back out of it: the normal impulse pushes a slanted body to
    one side.
    """
    ball = under(0.02)
    as_point = ball._replace(friction=SetValued(ball.friction.mu))
    point = hit((v_e, 0.0, -1.0), theta, as_point, 0.5, restitution)
    made = hit((v_e, 0.0, -1.0), theta, ball, 0.5, restitution)
    assert made.mode == "slip"
    assert abs(point.v_e) > 0.01
    for name in ("p_e", "p_z", "v_e", "v_n", "work_n", "work_t"):
        assert getattr(made, name) == pytest.approx(getattr(point, name), rel=1e-10), name
    assert (made.v_2, made.Omega_z, made.p_2, made.twist.z) == pytest.approx((0,) * 4, abs=1e-15)

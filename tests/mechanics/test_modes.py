"""The linear modes of the spinning states, against the equations of motion themselves, linearised
by complex steps.
"""

import math
from typing import Any

import numpy as np
import pytest
from examples import GLIDING
from limits import assert_near

from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.friction import Coulomb, Frictionless, Latitude, Viscous
from tippetop.mechanics.operand import refill
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.theory import modes


STEP = 1e-30  # complex step: exact for any step this small
FRICTION = Viscous(0.4), Coulomb(0.1, 0.7), Latitude(0.2, 0.9)
either_end = pytest.mark.parametrize("inverted", [False, True])


def bodies(rng: np.random.Generator, friction: Any, n: int, *, tip: bool = False) -> Touch:
    """n bodies with numbers of order one; with a tip, R = 0 and c < 0."""
    m, R, alpha, I1, I3, g = rng.uniform(0.6, 1.5, (6, n))
    return (
        Touch(m, 0 * R, -R, I1, I3, g, friction)
        if tip
        else Touch(m, R, 0.6 * alpha * R, I1, I3, g, friction)
    )


def each(b: Touch) -> list[Touch]:
    """The bodies one by one."""
    return [Touch(*map(float, numbers), b.friction) for numbers in zip(*b[:6], strict=True)]


def linearised(system: str, omega3: float, b: Touch, up: int) -> np.ndarray:
    """The characteristic polynomial of what moves across the axis next to a spin: axis, angular
    momentum, velocity.
    """
    form = SYSTEMS[system].forms["vector"]
    names = form.units._fields
    along = {"uz": up, "Lz": up * b.I3 * omega3, "L3": b.I3 * omega3}
    across = [name for name in names if name not in along]
    rates = [
        form.rates(
            refill(form.units, iter([along.get(x, 0.0) + 1j * STEP * (x == moved) for x in names])),
            b,
        )
        for moved in across
    ]
    return np.poly([[np.imag(getattr(rate, name)) / STEP for rate in rates] for name in across])


def polynomial(p: np.ndarray) -> np.ndarray:
    """That of the rates of a complex tilt and of its conjugate."""
    return np.real(np.poly([*p, *np.conj(p)]))


@either_end
@pytest.mark.parametrize(
    ("system", "friction"),
    [
        *(("tippe-top", friction) for friction in FRICTION),
        ("gliding-heavy-top", Viscous(0.4)),
        ("rolling-tippe-top", Frictionless()),
        ("heavy-top", Frictionless()),
    ],
)
def test_modes_are_those_of_the_equations_of_motion(
    system: str, friction: Any, inverted: bool, rng: np.random.Generator
) -> None:
    found = modes.linear_modes if SYSTEMS[system].frictional else modes.rolling_modes
    for b in each(bodies(rng, friction, 5, tip="heavy" in system)):
        omega3 = rng.uniform(-2, 2)
        expected = linearised(system, omega3, b, -1 if inverted else 1)
        p = polynomial(found(omega3, b, inverted=inverted))
        assert_near(p, expected, 1e-12, relative=True)


@either_end
@pytest.mark.parametrize("gliding", [False, True])
@pytest.mark.parametrize("tip", [False, True])
def test_unstable_is_what_has_a_mode_that_grows(
    tip: bool, gliding: bool, inverted: bool, rng: np.random.Generator
) -> None:
    """Of many bodies at once as of each; both kinds are among them, but for tips, which hang or
    glide out.
    """
    b, omega3 = bodies(rng, Viscous(0.3), 300, tip=tip), rng.uniform(-6, 6, 300)
    found = modes.is_unstable(omega3, b, inverted=inverted, gliding=gliding)
    of = modes.linear_modes if gliding else modes.rolling_modes
    expected = [
        of(w, one, inverted=inverted)[0].real > 1e-9
        for w, one in zip(omega3.tolist(), each(b), strict=True)
    ]
    assert found.tolist() == expected
    assert len({*expected}) == (
        1 if tip and (gliding or inverted) else 2 if gliding or inverted or tip else 1
    )


@either_end
@pytest.mark.parametrize("mu", [1e-300, 1e-20, 1e-9, 30.0])
def test_however_weak_or_strong_friction_is_the_same_spins_are_unstable(
    mu: float, inverted: bool, rng: np.random.Generator
) -> None:
    b, omega3 = bodies(rng, Viscous(0.3), 300), rng.uniform(-6, 6, 300)
    expected = modes.is_unstable(omega3, b, inverted=inverted)
    found = modes.is_unstable(omega3, b._replace(friction=Viscous(mu)), inverted=inverted)
    assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("faster", [1.0, 1e4])
def test_without_friction_nothing_but_rounding_grows_in_a_fast_top(
    faster: float, rng: np.random.Generator
) -> None:
    """A gliding tip: the sleeping top is stable above 2 sqrt(m g l I1)/I3, about its centre of
    mass, in any units.
    """
    b = bodies(rng, Frictionless(), 100, tip=True)
    b = b._replace(g=b.g * faster**2)
    limit = 2 * np.sqrt(b.m * b.g * -b.c * b.I1) / b.I3
    assert not modes.is_unstable(1.01 * limit, b).any()
    assert modes.is_unstable(-0.99 * limit, b).all()


@either_end
def test_a_motion_leaves_a_pole_that_is_near_and_unstable(inverted: bool) -> None:
    unstable, stable = (5.0, 200.0) if inverted else (200.0, 5.0)

    def leaves(away: float, omega3: float) -> bool:
        return modes.will_leave(math.pi - away if inverted else away, omega3, GLIDING)

    assert leaves(0.009, unstable)
    assert not leaves(0.011, unstable)
    assert not leaves(0.009, stable)

"""Impacts of a patch that drills: against an integration of the whole body, and those of a point."""

from typing import Any

import heyoka as hy
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tippetop.mechanics.contact import patch_impact
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.patch_impact import (
    P_Z,
    Patch,
    bounded,
    excess,
    new_room,
    patch_struck,
)
from tippetop.mechanics.contact.response import mobility, spin_mobility
from tippetop.mechanics.contact.struck import RESTITUTIONS, struck
from tippetop.mechanics.disc_friction import drag
from tippetop.mechanics.friction import Contensou
from tippetop.mechanics.operand import leaves, refill


PATCH = 5e-4
BODY = Touch(0.006, 0.015, 0.003, 8e-7, 7e-7, 9.81, Contensou(0.3, PATCH, 0.0))
STEM = BODY._replace(c=0.016, R=0.005)

every_law = pytest.mark.parametrize("law", RESTITUTIONS)


def under(mu: float, patch: float = PATCH) -> Touch:
    """The body under friction of another size."""
    return BODY._replace(friction=Contensou(mu, patch, 0.0))


def body_struck(v: tuple, omega: np.ndarray, theta: float, ball: Touch, until: float) -> tuple:
    """Contact velocity, omega and gain of L after the normal impulse `until`: the free body, by Newton and Euler."""
    u = np.array([np.sin(theta), 0, np.cos(theta)])
    a = ball.c * u - np.array([0, 0, ball.R])
    inverse = np.eye(3) / ball.I1 + (1 / ball.I3 - 1 / ball.I1) * np.outer(u, u)
    V, L = np.array(v) - np.cross(omega, a), np.linalg.solve(inverse, omega)

    def rate(p: float, y: np.ndarray) -> np.ndarray:
        omega = inverse @ y[3:]
        v = y[:3] + np.cross(omega, a)
        k, twist = drag(v[0] ** 2 + v[1] ** 2, (PATCH * omega[2]) ** 2)
        F = np.array([-ball.friction.mu * k * v[0], -ball.friction.mu * k * v[1], 1])
        torque = np.array([0, 0, -ball.friction.mu * PATCH**2 * twist * omega[2]])
        return np.concatenate([F / ball.m, np.cross(a, F) + torque])

    y = solve_ivp(rate, (0, until), np.concatenate([V, L]), "DOP853", rtol=1e-12, atol=1e-16).y[:, -1]
    omega = inverse @ y[3:]
    return y[:3] + np.cross(omega, a), omega, y[3:] - L


@every_law
@pytest.mark.parametrize("ball", [BODY, STEM])
def test_the_whole_body_moves_so(ball: Touch, law: str, rng: np.random.Generator) -> None:
    for theta in rng.uniform(0.2, 2.9, 3):
        omega, v = rng.normal(0, 100, 3), (*rng.normal(0, 0.2, 2), -0.1)
        made = patch_struck(v, omega[2], np.sin(theta), np.cos(theta), ball, 0.6, law)
        after, turned, gained = body_struck(v, omega, theta, ball, made.p_z)
        np.testing.assert_allclose((made.v_e, made.v_2, made.v_n), after, rtol=0, atol=1e-10)
        assert made.Omega_z == pytest.approx(turned[2], abs=1e-8)
        s, z = np.sin(theta), np.cos(theta)
        a = np.array([ball.c * s, 0, ball.c * z - ball.R])
        p = np.array([made.p_e, made.p_2, made.p_z])
        np.testing.assert_allclose(np.cross(a, p) + np.array([0, 0, made.twist]), gained, rtol=0, atol=1e-14)
        energy = (p @ (np.array(v) + after) + made.twist * (omega[2] + made.Omega_z)) / 2
        assert made.energy == pytest.approx(energy, rel=1e-10)
        assert made.work_t < 0
        ends = {"energetic": made.work_n / made.compression - 0.64, "poisson": 0, "newton": made.v_n - 0.06}
        assert ends[law] == pytest.approx(0, abs=1e-13)


def test_poissons_impulse_is_that_of_compression_and_its_share() -> None:
    v = (0.1, -0.1, -0.3)
    whole, pressed = (patch_struck(v, 80.0, 0.8, 0.6, STEM, e, "poisson") for e in (0.6, 0.0))
    assert whole.p_z == pytest.approx(1.6 * pressed.p_z, rel=1e-13)
    assert pressed.v_n == 0


def test_a_point_is_a_patch_of_no_size() -> None:
    """Where the slip does not stop; the difference is of the order of the patch squared."""
    theta, v = 1.0, (0.4, -0.3, -0.2)
    K = mobility(np.sin(theta), np.cos(theta), BODY)
    point = struck(*v, K, BODY.friction.mu, 0.5)
    errors = []
    for patch in (1e-4, 1e-5, 1e-9):
        made = patch_struck(v, 50.0, np.sin(theta), np.cos(theta), under(0.3, patch), 0.5)
        errors.append(abs(made.v_2 - point.v_2) + abs(made.p_e - point.p_e))
    assert errors[1] < errors[0] / 5
    assert errors[2] < 1e-13


@pytest.mark.parametrize(("number", "digits"), [(np.longdouble, 1e-16), (hy.real128, 1e-29)])
def test_an_impact_has_the_digits_of_its_numbers(number: Any, digits: float) -> None:
    """The works are integrated, the impulses too: p.(v- + v+)/2 joins them."""
    v, ball = [number(x) for x in (0.1, -0.1, -0.3)], refill(BODY, map(number, leaves(BODY)))
    made = patch_struck(tuple(v), number(80), number(0.8), number(0.6), ball, number(0.5))
    p, after = (made.p_e, made.p_2, made.p_z), (made.v_e, made.v_2, made.v_n)
    energy = (
        sum((a * (b + c) for a, b, c in zip(p, v, after, strict=True)), made.twist * (number(80) + made.Omega_z)) / 2
    )
    assert abs(made.energy - energy) < digits * abs(made.compression)
    assert abs(made.work_n - made.compression * 3 / 4) < digits * abs(made.compression)


@pytest.mark.parametrize("theta", [0.8, 1.2])
def test_a_velocity_whose_square_is_no_number_is_none(theta: float) -> None:
    """Where friction can hold the patch, and where it cannot."""
    ball, s, z = under(0.05), np.sin(theta), np.cos(theta)
    least, none = (patch_struck((v, 0.0, -1.0), v, s, z, ball, 0.5) for v in (1e-170, 0.0))
    assert least == none


def test_what_is_no_number_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not 20 000 steps of it."""
    steps, extrapolated = [], patch_impact._extrapolated
    monkeypatch.setattr(patch_impact, "_extrapolated", lambda *given: steps.append(given[-1]) or extrapolated(*given))
    with pytest.raises(ArithmeticError, match="did not end"):
        patch_struck((np.nan, 0.0, -1.0), 0.0, 0.8, 0.6, BODY, 0.5)
    assert len(steps) == 1


def test_steps_may_be_shorter_than_the_rounding_of_what_they_add_to() -> None:
    law = Contensou(0.9346531257483076, 4.1999305207395505e-05, 0.0)
    ball = Touch(1, 1, 0.7425928153483007, 0.3419806519259723, 0.24520041071791776, 1, law)
    s, z = 0.1426718256813278, -0.9897700491309872
    v = (0.0, 1.2958642370572142e-06, -8.767114515652006)
    made = patch_struck(v, -6.56e-11, s, z, ball, 1.0, "newton")
    point = struck(*v, mobility(s, z, ball), ball.friction.mu, 1.0, "newton")
    assert made.mode == point.mode == "stick"
    assert made[:3] == pytest.approx(point[:3], rel=1e-9, abs=1e-12)


def test_slip_and_drilling_that_stop_together_stick() -> None:
    """At a pole, where friction gives no Omega_z."""
    made = patch_struck((0.01, 0.01, -1.0), 0.0, 0.0, 1.0, BODY, 0.5)
    assert made.mode == "stick"
    assert (made.v_e, made.v_2, made.Omega_z) == (0, 0, 0)
    point = struck(0.01, 0.01, -1.0, mobility(0.0, 1.0, BODY), BODY.friction.mu, 0.5)
    assert made[:3] == pytest.approx(point[:3], rel=1e-12)
    assert made.energy == pytest.approx(point.energy, rel=1e-12)


@pytest.mark.parametrize("theta", [0.5, 2.0])
def test_what_does_not_slide_is_pushed_so_that_it_stays_at_rest(theta: float) -> None:
    """Of a slanted body the normal impulse would move the contact, too."""
    s, z, ball = np.sin(theta), np.cos(theta), under(0.6)
    made, K = patch_struck((0.0, 0.0, -1.0), 0.0, s, z, ball, 0.5), mobility(s, z, ball)
    assert made.mode == "stick"
    assert (made.v_e, made.v_2, made.Omega_z) == (0, 0, 0)
    assert abs(K.ez * made.p_z) > 0.1
    assert K.ee * made.p_e + K.ez * made.p_z == pytest.approx(0, abs=1e-12)
    assert K.ez * made.p_e + K.zz * made.p_z == pytest.approx(made.v_n + 1, rel=1e-12)
    assert made.energy == pytest.approx(made.p_z * (made.v_n - 1) / 2, rel=1e-12)


@every_law
@pytest.mark.parametrize("theta", [0.5, 2.6])
@pytest.mark.parametrize("v_e", [0.0, 1e-3, -1e-3])
def test_what_friction_cannot_hold_slips_as_a_point_does(v_e: float, theta: float, law: str) -> None:
    """Without drilling, from rest or back out of it: the normal impulse pushes a slanted body to one side."""
    s, z, ball = np.sin(theta), np.cos(theta), under(0.02)
    made, point = (
        patch_struck((v_e, 0.0, -1.0), 0.0, s, z, ball, 0.5, law),
        struck(v_e, 0.0, -1.0, mobility(s, z, ball), ball.friction.mu, 0.5, law),
    )
    assert made.mode == "slip"
    assert abs(point.v_e) > 0.01
    for name in ("p_e", "p_z", "v_e", "v_n", "work_n", "work_t"):
        assert getattr(made, name) == pytest.approx(getattr(point, name), rel=1e-10), name
    assert (made.v_2, made.Omega_z, made.p_2, made.twist) == (0, 0, 0, 0)


# --- the steps --------------------------------------------------------------------------------------------------------

every_unit = pytest.mark.parametrize(  # of length, time, mass: powers of two, which no rounding sees
    "units",
    [(2.0**20, 1.0, 1.0), (1.0, 2.0**20, 1.0), (1.0, 1.0, 2.0**20), (2.0**-9, 2.0**7, 2.0**13)],
)


def in_units(ball: Touch, L: float, T: float, M: float) -> Touch:
    """A ball of other units."""
    inertia = M * L**2
    law = ball.friction._replace(patch=ball.friction.patch * L)
    return Touch(ball.m * M, ball.R * L, ball.c * L, ball.I1 * inertia, ball.I3 * inertia, ball.g * L / T**2, law)


def units_of_impact(L: float, T: float, M: float) -> dict[str, float]:
    """The units of what an impact gives."""
    p, energy = M * L / T, M * L**2 / T**2
    speeds, impulses = dict.fromkeys(("v_e", "v_2", "v_n"), L / T), dict.fromkeys(("p_e", "p_2", "p_z"), p)
    works = dict.fromkeys(("work_n", "work_t", "compression"), energy)
    return {**speeds, **impulses, **works, "twist": p * L, "Omega_z": 1 / T}


@every_law
@pytest.mark.parametrize(
    ("v", "Omega_z", "mu"),
    [
        ((0.1, -0.2, -0.1), 90.0, 0.3),  # slides
        ((0.0, 0.0, -1.0), 0.0, 0.02),  # from rest
        ((0.001, 0.0, -0.3), 0.0, 0.6),  # comes to rest
        ((-0.01, 0.0, -0.3), 0.0, 0.02),  # slides back
    ],
)
def test_units_do_not_show(v: tuple, Omega_z: float, mu: float, law: str) -> None:
    ball, s, z, units = under(mu), 0.6, 0.8, (2.0**9, 2.0**-7, 2.0**13)
    L, T, _ = units
    expected = patch_struck(v, Omega_z, s, z, ball, 0.5, law)
    w = tuple(x * L / T for x in v)
    made = patch_struck(w, Omega_z / T, s, z, in_units(ball, *units), 0.5, law)
    for name, unit in units_of_impact(*units).items():
        assert getattr(made, name) == getattr(expected, name) * unit, name
    assert made.mode == expected.mode


def test_a_step_ends_no_more_than_half_of_a_motion(rng: np.random.Generator) -> None:
    for step, still, change in zip(
        rng.normal(size=50), rng.exponential(size=50), rng.exponential(3, size=50), strict=True
    ):
        taken = bounded(step, still, change)
        assert taken / step > 0
        assert abs(taken) == pytest.approx(min(abs(step), still / (2 * change)), rel=1e-14)
        assert bounded(step, 0.0, change) == step


def judged(errors: np.ndarray, step: float, eps: float = 2.0**-52, units: tuple = (1.0, 1.0, 1.0)) -> float:
    """The error of a step that begins an impact, or lies in one."""
    u, (L, T, _) = units_of_impact(*units), units
    names = ("v_e", "v_2", "Omega_z", "p_z", "p_e", "p_2", "twist", "work_n", "work_t")
    scale, ball, room = np.array([u[name] for name in names]), in_units(BODY, *units), new_room(np.float64)
    p = Patch(mobility(0.6, 0.8, ball), spin_mobility(0.6, 0.8, ball), ball.friction.mu, PATCH * L)
    room.size[0], room.error[:] = 0.3 * L / T, errors * scale
    room.y[:] = np.array([0.08, -0.05, 1.0, 0.0, 0.0, 0.0, 0.0, -1e-6, -1e-6]) * scale
    return excess(room, p, 0.1 * L / T, step * L / T, eps)


def test_a_step_is_judged_by_its_largest_error(rng: np.random.Generator) -> None:
    errors = rng.uniform(1e-18, 1e-17, 9)
    each = [judged(errors * (np.arange(9) == f), 0.01) for f in range(9)]
    assert judged(errors, 0.01) == max(each)
    assert judged(errors, -0.01) == max(each)
    assert judged(0 * errors, 0.01) == 0
    assert judged(np.where(np.arange(9) == 4, np.nan, errors), 0.01) == np.inf


@every_unit
@pytest.mark.parametrize("f", range(9))
def test_each_error_counts(f: int, units: tuple) -> None:
    """In proportion, more where numbers have more digits, alike in all units."""
    error = 1e-17 * (np.arange(9) == f)
    ratio = judged(error, 0.01)
    assert ratio > 0
    assert judged(2 * error, 0.01) == judged(error, 0.01, 2.0**-53) == 2 * ratio
    assert judged(error, 0.01, units=units) == ratio
    assert (judged(error, 0.02) < ratio) == (f >= P_Z)  # an impulse has grown; velocities have not


@pytest.mark.parametrize("wrong", [{"v": (0.1, 0.1, 0.1)}, {"e_n": -0.1}, {"restitution": "no"}])
def test_what_is_no_impact_is_refused(wrong: dict) -> None:
    right = {"v": (0.1, 0.1, -0.1), "Omega_z": 1.0, "s": 0.6, "z": 0.8, "b": BODY, "e_n": 0.5}
    with pytest.raises(ValueError, match="no impact"):
        patch_struck(**{**right, **wrong})

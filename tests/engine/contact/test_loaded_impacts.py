"""Impacts under every law, with rolling resistance and a drilling torque or without: Newton and
Euler by DOP853, in the normal impulse, and the balances of momentum and energy.
"""

from typing import Any

import numpy as np
import pytest
from limits import assert_near
from scipy.integrate import solve_ivp
from touching import CARRIED, impact_motions, inertia

from tippetop.mechanics.contact.body import (
    Moving,
    Touch,
    Turning,
    angular_velocity,
    arm,
    centre_velocity,
    velocities,
)
from tippetop.mechanics.contact.response import kicked
from tippetop.mechanics.contact.restitution import RESTITUTIONS
from tippetop.mechanics.disc_friction import drag
from tippetop.mechanics.friction import LAWS
from tippetop.mechanics.operand import Vector


MU_R, MU_D, STILL, Z = 0.013, 0.007, 1e-6, np.array([0.0, 0.0, 1.0])
STOPPED = 1e-10  # speed of sliding below which it has stopped
FLAT = np.array([1.0, 1.0, 0.0])
PATCH = 0.2


def disc(v: Any, spin: float) -> tuple[Any, float]:
    """Force and drilling torque of a disc, per normal force."""
    by = drag(v[:2] @ v[:2], (PATCH * spin) ** 2)
    return 0.3 * by.k * v * FLAT, -0.3 * PATCH**2 * by.twist * spin


PUSHES = {
    "viscous": lambda v, spin: (0.3 * v * FLAT, 0.0),
    "mixed": lambda v, spin: ((0.1 + 0.2 / np.sqrt(v[:2] @ v[:2] + 0.01)) * v * FLAT, 0.0),
    "none": lambda v, spin: (0 * v, 0.0),
    "coulomb": lambda v, spin: (0.3 * v * FLAT / np.hypot(v[0], v[1]), 0.0),
    "contensou": disc,
}
NUMBERS = {
    "viscous": {"mu": 0.3},
    "mixed": {"mu": 0.1, "mu_coulomb": 0.2, "eps": 0.1},
    "none": {},
    "coulomb": {"mu": 0.3},
    "contensou": {"mu": 0.3, "patch": PATCH},
}
every_law = pytest.mark.parametrize("law", NUMBERS)


def law_of(law: str, parts: Any = (MU_R, MU_D), **numbers: float) -> Any:
    """The record of a law with both parts."""
    more = dict(zip(("mu_r", "mu_d"), parts, strict=True))
    return LAWS[law].given(NUMBERS[law]).with_parts(**NUMBERS[law] | numbers | more)


def bodies(n: int, slides: float, seed: int = 7) -> list[tuple]:
    """Axes, momenta and velocities before an impact."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(n):
        u = rng.normal(size=3)
        v = [*(slides * rng.normal(size=2)), -rng.uniform(0.1, 1.0)]
        made.append(
            tuple(Vector(*map(float, x)) for x in (u / np.linalg.norm(u), rng.normal(size=3), v))
        )
    return made


BALL = Touch(1.0, 1.0, 0.2, 0.59, 0.52, 1.0, None)
STEM = Touch(1.0, 1 / 3, 16 / 15, 0.6, 0.5, 1.0, None)


def hit(
    u: Any,
    L: Any,
    v: Any,
    friction: Any,
    e_n: float,
    restitution: str = "energetic",
    ball: Touch = BALL,
) -> tuple:
    b = ball._replace(friction=friction)
    x = Moving(u, L, centre_velocity(Turning(u, L), v, b), 0.0, CARRIED)
    made = impact_motions(type(friction), restitution).struck(x, b, e_n)
    return b, x, made, kicked(x, b, made.p, made.twist)


def newton_euler(
    u: Any,
    L: Any,
    v: Any,
    b: Any,
    law: Any,
    e_n: float,
    restitution: str,
    parts: Any = (MU_R, MU_D),
    method: Any = "DOP853",
    rtol: float = 1e-12,
) -> Any:
    """v_A, L, impulses of force and torque, works after an impact; law None: the contact point
    stays at rest. Where a slide stops, Coulomb friction holds the contact point, or it turns back.
    """
    u = np.array(u)
    inverse = np.linalg.inv(inertia(u, b))
    arm_cross = np.cross(b.c * u - b.R * Z, np.eye(3)).T  # times a vector: the arm cross it

    def gains(F: Any, T: Any) -> Any:
        return F / b.m - arm_cross @ (inverse @ (arm_cross @ F + T))

    still = np.linalg.inv(np.array([gains(one, 0 * Z)[:2] for one in np.eye(3)[:2]]).T)
    held = Z - np.array([*(still @ gains(Z, 0 * Z)[:2]), 0.0])

    def rates(p: float, y: Any, law: Any) -> list:
        v, omega = y[:3], inverse @ y[3:6]
        rolls = -parts[0] / np.sqrt(omega[:2] @ omega[:2] + STILL**2)
        T = np.array(
            [rolls * omega[0], rolls * omega[1], -parts[1] * omega[2] / np.hypot(omega[2], STILL)]
        )
        if law is None:
            F = held - np.array([*(still @ gains(0 * Z, T)[:2]), 0.0])
        else:
            push, drills = law(v, omega[2])
            F, T = Z - push, T + drills * Z
        return [*gains(F, T), *(arm_cross @ F + T), *F, *T, v[2], F[:2] @ v[:2] + T @ omega]

    def stops(p: float, y: Any, law: Any) -> float:
        return 1.0 if law is None or method == "Radau" else np.hypot(y[0], y[1]) - STOPPED

    def followed(y: Any, law: Any, function: Any) -> tuple:
        function.terminal, function.direction = True, 1
        stops.terminal, stops.direction = True, -1
        how = {"method": method, "rtol": rtol, "atol": rtol / 100, "events": (function, stops)}
        found = solve_ivp(rates, (0, 100), y, args=(law,), **how)
        y = found.y[:, -1]
        if not len(found.t_events[1]):
            return y, law
        if np.hypot(*rates(0.0, y, None)[6:8]) <= 0.3:
            return followed(y, None, function)
        return followed(np.append(-y[:2], y[2:]), law, function)

    y, law = followed([*v, *L, *(0.0,) * 8], law, lambda p, y, law: y[2])
    ends = {
        "energetic": (12, (1 - e_n**2) * y[12]),
        "poisson": (8, (1 + e_n) * y[8]),
        "newton": (2, -e_n * v[2]),
    }
    at, goal = ends[restitution]
    return followed(y, law, lambda p, y, law: y[at] - goal)[0] if e_n else y


def found(b: Any, impact: Any, after: Any) -> Any:
    v, _ = velocities(after, b)
    return np.array(
        [*v, *after.L, *impact.p, *impact.twist, impact.work_n, impact.gained - impact.work_n]
    )


def assert_impact(b: Any, impact: Any, after: Any, expected: Any, bound: float) -> None:
    """Check what `newton_euler` returns, part by part."""
    names = "velocity of the contact", "angular momentum", "impulse", "impulse of the torque"
    parts = (np.split(x, [3, 6, 9, 12, 13]) for x in (found(b, impact, after), expected))
    names = (*names, "work of the normal force", "work of friction and torques")
    for name, mine, theirs in zip(names, *parts, strict=True):
        assert_near(mine, theirs, bound, name)


@pytest.mark.parametrize("parts", [(MU_R, MU_D), (0.0, 0.0)])
@pytest.mark.parametrize("restitution", RESTITUTIONS)
@pytest.mark.parametrize(
    ("law", "slides"),
    [*((law, 10.0 if law == "coulomb" else 3.0) for law in NUMBERS), ("coulomb", 0.0)],
)
def test_an_impact_is_the_motion_of_newton_and_euler(
    law: str, slides: float, restitution: str, parts: tuple
) -> None:
    """It slides to the end, or the contact point stays at rest from the beginning."""
    friction = law_of(law, parts)
    for body in bodies(2, slides):
        b, _, impact, after = hit(*body, friction, 0.5, restitution)
        assert impact.mode == ("slip" if slides else "stick")
        push = PUSHES[law] if slides else None
        expected = newton_euler(*body, b, push, 0.5, restitution, parts)
        assert_impact(b, impact, after, expected, 1e-11)


@pytest.mark.parametrize("ball", [BALL, STEM], ids=["ball", "stem"])
@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_a_slide_that_stops_during_an_impact_rests_or_turns_back(
    restitution: str, ball: Touch
) -> None:
    """In space, and in a plane, where it may turn back."""
    friction, modes = law_of("coulomb", (0.0, 0.0)), set()
    for u, L, v in bodies(5, 0.3, seed=3):
        flat = Vector(np.hypot(u.x, u.y), 0.0, u.z), Vector(0.0, L.y, 0.0), Vector(v.x, 0.0, v.z)
        for body in ((u, L, v), flat):
            b, _, impact, after = hit(*body, friction, 0.5, restitution, ball)
            expected = newton_euler(*body, b, PUSHES["coulomb"], 0.5, restitution, (0.0, 0.0))
            assert_impact(b, impact, after, expected, 1e-9)
            modes.add(impact.mode)
    assert modes == {"slip", "stick"} | ({"reverse"} if ball is STEM else set())


@every_law
def test_impulses_are_balanced_and_take_energy(law: str) -> None:
    """Angular momentum about the contact point changes by the impulse of the torques alone."""
    for body in [*bodies(10, 0.0), *bodies(10, 0.1), *bodies(10, 1.0)]:
        b, x, impact, after = hit(*body, law_of(law), 0.5)
        u, L, _ = body
        p, twist = np.array(impact.p), np.array(impact.twist)
        assert_near(np.subtract(after.velocity, x.velocity), p, 1e-14)
        turned = np.cross(arm(u, b), p) + twist
        assert_near(np.subtract(after.L, L), turned, 1e-14)
        omega = np.add(angular_velocity(x, b), angular_velocity(after, b)) / 2
        gained = p @ np.add(x.velocity, after.velocity) / 2 + turned @ omega
        assert (-after.carried.work, impact.gained) == pytest.approx((gained,) * 2, abs=1e-13)
        by_friction, returned = impact.gained - impact.work_n, impact.work_n - impact.compression
        assert by_friction < 0, "friction and torques of the contact must take energy"
        assert impact.p.z > 0, "the plane must push"
        assert returned == pytest.approx(-impact.compression / 4, rel=1e-12), "e_n^2 comes back"
        if law == "coulomb":
            assert np.hypot(p[0], p[1]) <= 0.3 * p[2], "the impulse must lie in the cone"


def still_disc(v: Any, spin: float) -> tuple[Any, float]:
    """That of a small disc, smooth at rest as in sliding."""
    by = drag(v[:2] @ v[:2], (0.02 * spin) ** 2 + 1e-18)
    return 0.2 * by.k * v * FLAT, -0.2 * 0.02**2 * by.twist * spin


@pytest.mark.slow
def test_a_disc_that_rests_gives_way_where_the_direction_of_rolling_turns() -> None:
    """Radau's method follows it through its rest."""
    u = Vector(np.sin(1.0), 0.0, np.cos(1.0))
    omega = np.array([0.02, 0.13, 0.0])
    L = Vector(*(0.59 * omega - 0.07 * (omega @ u) * np.array(u)))
    v = Vector(0.0, 0.0, -1.0)
    friction = law_of("contensou", (0.03, 0.0), mu=0.2, patch=0.02)
    b, _, impact, after = hit(u, L, v, friction, 0.0)
    assert impact.mode == "slip"
    expected = newton_euler(u, L, v, b, still_disc, 0.0, "newton", (0.03, 0.0), "Radau", 1e-9)
    assert_impact(b, impact, after, expected, 1e-6)

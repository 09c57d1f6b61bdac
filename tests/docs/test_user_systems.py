"""The body of the how-to, against Newton and Euler."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import tilted
from pages import names_of
from refusals import refusal

import tippetop as tt
from tippetop.mechanics.systems import SYSTEMS


@pytest.fixture(scope="module", autouse=True)
def _forgotten() -> Iterator[None]:
    yield
    for name in ("hen-egg", "rolling-hen-egg"):
        SYSTEMS.pop(name, None)


@pytest.fixture(scope="module")
def egg() -> dict[str, Any]:
    return names_of("a-body-of-your-own.md")


class HenEgg(tilted.Body):
    """A body of which the support function is known alone, by its gradient."""

    def reached(self, n: np.ndarray) -> np.ndarray:
        up, size = np.array([0, 0, 1]), n @ n
        squares = np.array([0.022, 0.022, 0.028]) ** 2
        whole = squares * n / np.sqrt(n @ (squares * n))
        cubic = 3 * n[2] ** 2 / size * up - 2 * n[2] ** 3 / size**2 * n
        return -(whole + 0.002 * cubic - 0.001 * up)


def test_the_egg_moves_as_newton_and_euler_say(egg: dict[str, Any]) -> None:
    start = {"theta": 1.0, "theta_dot": 1.0, "phi_dot": 40.0, "omega3": 20.0}
    options = {"start": start | {"nu_x": 0.1}, "until": 0.25, "output_step": 0.05}
    run = tt.run(egg["egg"], tt.friction.Viscous(mu=0.5), **options)
    b = HenEgg(0.06, (1.4e-5, 1.4e-5, 1.15e-5), None, None, 9.81)
    tilted.assert_moves(run.trajectory, b, tilted.sliding(lambda v: 0.5), 1e-9)
    assert np.ptp(run.trajectory.theta.values) > 0.1
    assert run.drift["energy_balance"] < 1e-14


def test_the_egg_of_the_page_rises_by_jumps(egg: dict[str, Any]) -> None:
    run = egg["run"]
    assert run.trajectory.theta.values[-1] > 2.9
    assert run.summary.event_counts["liftoff"] == 12
    assert run.drift["energy_balance"] < 1e-13
    rolls = tt.run(egg["egg"], start={"theta": 1.4, "omega3": 0.0}, until=0.5)
    assert rolls.drift["energy"] < 1e-14


# --- what is refused ----------------------------------------------------------------------------

LENGTH = tt.extending.number(tt.extending.units.METRE, "length", above=0)
NUMBERS = {"a": LENGTH, "b": LENGTH}


def spheroid(z: Any, s2: Any, b: Any) -> Any:
    return tt.extending.root(b.a**2 * z**2 + b.b**2 * s2)


@pytest.mark.parametrize(
    ("height", "numbers", "match"),
    [
        (lambda z, s2, b: spheroid(z, s2, b) + b.a / 10 * tt.extending.root(z * z) * z, {},
         "smooth.* near z = 0"),
        (lambda z, s2, b: spheroid(z, s2, b) + b.a * z**3, {}, "convex.* at z = 1"),
        (lambda z, s2, b: spheroid(z, s2, b) - 1.5 * b.a * z, {}, "centre of mass.* at z = 1"),
        (lambda z, s2, b: spheroid(z, s2, b) + 1e-3, {}, "same in all units"),
        (lambda z, s2, b: spheroid(z, s2, b), {"I3": 1.0}, "at most 2"),
    ],
)  # fmt: skip
def test_a_body_that_is_none_is_refused(height: Any, numbers: Any, match: str) -> None:
    height.__name__ = "hen_egg"
    given = {"m": 0.06, "a": 0.03, "b": 0.02, "I1": 1.5e-5, "I3": 1e-5} | numbers
    with refusal(match) as raised:
        tt.extending.outline(NUMBERS, height)(**given)
    assert len(raised.value.sentences) == 1
    with refusal(match):
        tt.run({"system": "rolling-hen-egg", "parameters": given, "run": {"until": 1.0}})


@pytest.mark.parametrize(
    ("numbers", "height", "match"),
    [
        ({"a": 1.0}, spheroid, "dict of Number"),
        ({"a b": LENGTH}, spheroid, "by their names"),
        (NUMBERS, lambda z, s2, b: np.floor(z), "must return arithmetic"),
        (NUMBERS, lambda z, s2, b: z * b.a, "letters"),
        (NUMBERS, spheroid, "known"),
    ],
)
def test_a_height_that_is_none_is_refused(numbers: Any, height: Any, match: str) -> None:
    with refusal(match):
        tt.extending.outline(numbers, height)


@pytest.mark.parametrize("ratio", [0.02, 1.0, 50.0])
def test_long_and_flat_bodies_are_smooth(ratio: float) -> None:
    """And the order of plain numbers and series does not matter: 1/(1/h) = h."""

    def hen_egg(z: Any, s2: Any, b: Any) -> Any:
        return 1 / (1 / spheroid(z, s2, b)) + 2 * b.a - (b.a - (-b.a * (2 - z / 2 * 2 + z - 1) - 0))

    body = tt.extending.outline(NUMBERS, hen_egg)
    top = body(m=1.0, a=ratio, b=1.0, I1=1.0, I3=1.0)
    shape = top.body().outline
    assert shape.size == pytest.approx(1.0)

"""Landings, the events of a flight: against its closed form, and the reference; none is missed,
however short.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from nightly import at_night

from tippetop.engine.driver import RUNNING, Driver
from tippetop.engine.hybrid import formulas_of_phase
from tippetop.engine.integrator import compiled_from
from tippetop.engine.status import Status
from tippetop.mechanics.contact.body import Moving, Touch, Turning, axis_rate, height
from tippetop.mechanics.contact.exits import gap_rate, longest_flight
from tippetop.mechanics.contact.opening import opened
from tippetop.mechanics.friction import LAWS, Frictionless
from tippetop.mechanics.operand import Vector, kinds, leaves
from tippetop.mechanics.systems import SYSTEMS


SYSTEM = opened(SYSTEMS["tippe-top"], LAWS["none"], 1)
FLIGHT = SYSTEM.phases["flight"]
PATTERN = Touch(*(1.0,) * 6, Frictionless(), 1.0, 1.0)
FORMULAS = formulas_of_phase(SYSTEM, FLIGHT, PATTERN, kinds(PATTERN))
NAMES = [event.name for event in FORMULAS.events]
LANDINGS = "land", "touch"


class Flights:
    """Flights of one body after another."""

    def __init__(self) -> None:
        code = compiled_from(FORMULAS, "double", 0.0, 1, True)
        code.rows.events["ends"] *= np.isin(NAMES, LANDINGS)
        pars = [1.0] * len(code.integrator.pars)
        self.driver = Driver(code, code.rows, pars, np.zeros(14), np.ones(len(NAMES)), 1e9)

    def landing(self, x: Moving, b: Touch, zeros: int) -> tuple[Any, str]:
        """Return the time of the landing and its event; `zeros` of the gap and its derivatives
        vanish now.
        """
        driver, tally = self.driver, self.driver.tally
        q = FLIGHT.enter(x, b)
        driver.state[:] = 0
        driver.state[: len(q)] = q
        driver.set_parameters(driver.workspace, leaves(b))
        driver.set_state(driver.state, (0.0, 0.0))
        driver.set_end(longest_flight(x, b))
        functions = driver.tallies.functions
        functions["sign"], functions["on_zero"] = 1, 0
        functions["on_zero"][NAMES.index("land")] = -zeros
        tally["status"], tally["upto"], tally["steps"] = Status.RUNNING.code, 1.0, 0
        while driver.status[0] == RUNNING:
            driver.clear_findings()  # which have no room for the events of thousands of turns
            driver.make_steps(10**6)
        return driver.reached()[0], NAMES[int(driver.log.rows["event"][driver.log.filled[0] - 1])]


@pytest.fixture(scope="module")
def flights() -> Flights:
    return Flights()


def body(c: float, **other: float) -> Touch:
    numbers = {
        "m": 1.0,
        "R": 1.0,
        "I1": 0.37,
        "I3": 0.35,
        "g": 1.0,
        "clearance": 1.0,
        "lever": 0.0,
    } | other
    return Touch(c=c, friction=Frictionless(), **numbers)


def state(b: Touch, theta: float, L: Any, rise: float, gap: float = 0.0) -> Moving:
    """A body in the air, or on the plane, whose lowest point rises."""
    u, L = Vector(float(np.sin(theta)), 0.0, float(np.cos(theta))), Vector(*map(float, L))
    velocity = Vector(0.1, 0.2, rise - b.c * axis_rate(Turning(u, L), b).z)
    return Moving(u, L, velocity, height(u.z, b) + gap, Frictionless())


def rate(x: Moving, b: Touch, order: int) -> Any:
    """A derivative of the gap, of a run of this ball alone."""
    world = SimpleNamespace(body=(b,), phases=SYSTEM.phases, rates=lambda *of: ())
    return gap_rate(x, world, 0, order)


def gap_at(x: Moving, b: Touch, gap: float, t: Any) -> tuple[Any, Any]:
    """The gap at times t, and its rate: L stays, the axis turns about it, the centre falls."""
    u, L = (np.array(vector, np.longdouble) for vector in (x.u, x.L))
    size = np.sqrt(L @ L)
    along = L @ u / size**2
    pace = size / b.I1
    sine, cosine = np.sin(pace * t), np.cos(pace * t)
    beside, across = u[2] - along * L[2], (L[0] * u[1] - L[1] * u[0]) / size
    turned, turns = beside * (cosine - 1) + across * sine, across * cosine - beside * sine
    height = gap + x.velocity.z * t - b.g * t * t / 2 + b.c * turned
    return height, x.velocity.z - b.g * t + b.c * pace * turns


def random_flights(
    rng: np.random.Generator, zeros: int, count: int
) -> list[tuple[Moving, Touch, float]]:
    """Of tops that turn slowly or so fast that they come down tens of times before they
    would land.
    """
    found: list[tuple[Moving, Touch, float]] = []
    while len(found) < count:
        b, L = body(rng.uniform(-0.6, 0.6)), rng.normal(size=3) * 10 ** rng.uniform(-1, 1.2)
        theta, gap = rng.uniform(0.05, 3.1), 10 ** rng.uniform(-12, 0.3) if zeros == 0 else 0.0
        rise = rng.normal() * 10 ** rng.uniform(-2, 0.5) if zeros < 2 else 0.0
        x = state(b, theta, L, rise, gap)
        if zeros == 3:  # L sets the second derivative
            pull = rate(x, b, 2) + b.g
            x = state(b, theta, L * abs(b.g / pull) ** 0.5, rise)
            if not abs(rate(x, b, 2)) < 1e-12:
                continue
        if zeros == 0 or rate(x, b, zeros) > 0:
            found.append((x, b, gap))
    return found


@pytest.mark.parametrize("zeros", [0, 1, 2, 3])
@pytest.mark.parametrize("count", [150, at_night(2500)])
def test_no_landing_is_missed(
    zeros: int, count: int, flights: Flights, rng: np.random.Generator
) -> None:
    """The gap vanishes at the landing, falling, and nowhere before it; to the rounding error of the
    height.
    """
    for x, b, gap in random_flights(rng, zeros, count):
        t = np.longdouble(flights.landing(x, b, zeros)[0])
        height, speed = gap_at(x, b, gap, t)
        assert speed < 0
        assert abs(height) <= 5e-16 + 1e-13 * abs(speed) * max(1, t)
        before, _ = gap_at(x, b, gap, np.linspace(0, t, 4002, dtype=np.longdouble)[1:-1])
        assert before.min() > -1e-14


@pytest.mark.parametrize("depth", [1e-4, 1e-8, 1e-12, -1e-12, -1e-8, -1e-4])
def test_a_gap_that_all_but_closes_is_followed(depth: float, flights: Flights) -> None:
    """Weight hardly acts: the gap is that of the turning, whose second minimum lies at -depth."""
    b, Omega = body(0.5, g=1e-9), 1.0
    x = state(
        b, np.pi / 2, (0.0, -b.I1 * Omega, 0.0), 0.0, 0.5 - depth
    )  # gap = 0.5 (1 + sin) - depth, less a fall
    x = x._replace(velocity=Vector(0.0, 0.0, 0.0))
    fallen = 3 * np.pi / 2
    sag = b.g * fallen**2 / 2
    t, _ = flights.landing(x, b, 0)
    if depth + sag > 0:
        assert t == pytest.approx(
            fallen - np.sqrt(2 * (depth + sag) / 0.5), abs=0.03 * np.sqrt(depth + sag) + 1e-7
        )
    else:
        assert t > fallen * 1.5


def test_the_first_of_two_balls_lands(flights: Flights, rng: np.random.Generator) -> None:
    """The other ball's gap exceeds that of this one by clearance + lever cos(theta)."""
    ends = set()
    for x, b, gap in random_flights(rng, 0, 40):
        both = b._replace(clearance=0.5, lever=0.9)
        if both.clearance + both.lever * x.u.z + gap < 0:
            continue
        alone, (t, event) = flights.landing(x, b, 0)[0], flights.landing(x, both, 0)
        ends.add(event)
        other, _ = gap_at(x, b._replace(c=b.c + 0.9), gap + 0.5 + 0.9 * x.u.z, np.longdouble(t))
        if event == "land":
            assert t == alone
            assert other > -1e-12
        else:
            assert t < alone
            assert abs(other) < 1e-12
    assert ends == set(LANDINGS)

"""Flights in closed form against integrations, and landings against dense scans: none is missed, however short."""

import json
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from tippetop.mechanics.contact import landing
from tippetop.mechanics.contact.body import Touch
from tippetop.mechanics.contact.flight import (
    Hop,
    gap_in_flight,
    gap_series,
    hop,
)
from tippetop.mechanics.contact.gliding.chart import axis_and_momentum
from tippetop.mechanics.contact.gliding.euler import Angles
from tippetop.mechanics.contact.landing import fall_below, first_landing, gap_below, landing_time, latest
from tippetop.mechanics.contact.restitution import stem_height
from tippetop.mechanics.friction import Frictionless
from tippetop.mechanics.operand import Vector


CASE = json.loads((Path(__file__).parents[2] / "reference" / "caseC3_liftoff_flight_plastic_landing.json").read_text())
BALL = Touch(0.02, 0.02, 0.006, 131 / 43750000, 1 / 312500, 9.82, Frictionless())
U, L = Vector(0.6, 0.0, 0.8), Vector(1e-4, -3e-4, 2e-4)


def thrown(event: dict, number: type = np.float64) -> tuple[Vector, Vector]:
    """3hat and L of an event of the reference."""
    e = Angles(*(number(event.get(name, "0")) for name in ("theta", "thetadot", "phidot", "omega3")), 0, 0, *[0] * 5)
    e = e._replace(phi=number(event["phi"]))
    I1, I3 = number(131) / 43750000, number(1) / 312500
    return axis_and_momentum(e, np.sin(e.theta), np.cos(e.theta), I1, I3)


def test_a_body_that_does_not_turn_lands_as_a_point_does() -> None:
    still = Vector(0.0, 0.0, 0.0)
    h = hop(U, still, 1.0, 0.0, BALL, 1)
    assert landing_time(h) == pytest.approx(2 / BALL.g, rel=1e-15)


def test_the_gap_is_that_of_the_height_and_the_axis() -> None:
    """With its derivatives, against 40 digits of the height of the ball's centre."""
    with mp.workdps(40):
        size = mp.sqrt(mp.fsum(mp.mpf(x) ** 2 for x in L))
        l = [x / size for x in L]
        along = mp.fsum(x * y for x, y in zip(l, U, strict=True))
        cosine, sine = U.z - along * l[2], l[0] * U.y - l[1] * U.x
        Omega = size / BALL.I1

        def gap(t: Any) -> Any:
            turned = cosine * mp.cos(Omega * t) + sine * mp.sin(Omega * t) - cosine
            return mp.mpf(0.01) + mp.mpf(0.3) * t - BALL.g * t**2 / 2 + BALL.c * turned

        h = hop(U, L, 0.3, 0.01, BALL)
        for t in (0, 1e-9, 1e-3, 0.02, 0.05):
            exact = [float(x) for x in mp.taylor(gap, t, 3)]
            exact = [x * f for x, f in zip(exact, (1, 1, 2, 6), strict=True)]
            np.testing.assert_allclose(gap_in_flight(h, t), exact, rtol=1e-12, atol=1e-13)
        series = [float(c * mp.factorial(i)) for i, c in enumerate(mp.taylor(gap, 0, 5))]
        np.testing.assert_allclose(gap_series(h), series, rtol=1e-12)
        assert float(-h.bend - h.even * h.Omega**2) == pytest.approx(BALL.g, rel=1e-12)


def test_the_reference_lands_where_it_does() -> None:
    """A liftoff: a triple root at the start, which the rounding of the state must not move."""
    liftoff, touch = CASE["events"][:2]
    for number, digits in ((np.float64, 1e-15), (np.longdouble, 2e-18)):
        u, momentum = thrown(liftoff, number)
        I1, I3 = number(131) / 43750000, number(1) / 312500
        ball = Touch(number(1) / 50, number(1) / 50, number(6) / 1000, I1, I3, number(982) / 100, Frictionless())
        h = hop(u, momentum, number(liftoff["sdot"][2]), 0, ball, 3)
        with mp.workdps(25):
            expected = number(mp.nstr(mp.mpf(touch["t"]) - mp.mpf(liftoff["t"]), 22))
        assert landing_time(h) == pytest.approx(expected, abs=digits * 0.3)
        assert gap_in_flight(h, landing_time(h))[1] == pytest.approx(number(touch["nu_z"]), rel=100 * digits)


def made(start: Any, speed: Any, bend: Any, even: Any, odd: Any, Omega: Any) -> Hop:
    """A hop of these Taylor coefficients; the weight and the velocity of the centre of mass are what they leave."""
    return Hop(start, speed, bend, even, odd, Omega, speed - odd * Omega, -(bend + even * Omega**2))


def random_hops(rng: np.random.Generator, zeros: int, count: int) -> list[Hop]:
    """Of tops that turn slowly or so fast that they come down tens of times before they would land."""
    hops = []
    while len(hops) < count:
        even, odd, Omega = 0.006 * rng.uniform(-1, 1), 0.006 * rng.uniform(-1, 1), 10 ** rng.uniform(0.5, 3)
        speed = odd * Omega + rng.uniform(-0.1, 0.5) if zeros < 2 else 0.0
        bend = -9.82 - even * Omega**2
        start = rng.uniform(0, 0.02) if zeros == 0 else 0.0
        series = (start, speed, bend, -odd)
        if zeros == 3:  # g sets the third constant
            even, bend = -9.82 / Omega**2, 0.0
        if series[zeros] > 0:
            hops.append(made(start, speed, bend, even, odd, Omega))
    return hops


def scanned(h: Hop, until: float) -> np.ndarray:
    """The gap at 20000 times before `until`."""
    t = np.linspace(0, until, 20_002)[1:-1]
    x = h.Omega * t
    return h.start + h.speed * t + h.bend * t**2 / 2 + h.even * (np.cos(x) - 1 + x**2 / 2) - h.odd * (x - np.sin(x))


@pytest.mark.parametrize("zeros", [0, 1, 2, 3])
def test_no_landing_is_missed(zeros: int, rng: np.random.Generator) -> None:
    for h in random_hops(rng, zeros, 150):
        t = landing_time(h)
        gap, speed, *_ = gap_in_flight(h, t)
        assert t > 0
        assert speed < 0
        assert abs(gap) < 1e-15 + 1e-15 * abs(speed) * t
        assert scanned(h, float(t)).min() > -1e-15


@pytest.mark.parametrize("zeros", [0, 3])
def test_the_bounds_of_the_search_hold(zeros: int, rng: np.random.Generator) -> None:
    """The polynomials are below the gap and the speed at which it closes, by no more than the fourth order allows."""
    s = np.linspace(0, 1, 41)
    for h in random_hops(rng, zeros, 100):
        h, t = Hop(*map(np.longdouble, h)), np.longdouble(rng.uniform(0, 0.1))
        step = np.longdouble(10 ** rng.uniform(-1, 0.5)) / h.Omega
        now, amplitude = gap_in_flight(h, t), np.hypot(h.even, h.odd)
        later = np.array([gap_in_flight(h, t + step * x)[:2] for x in s])
        gap = later[:, 0] - np.polynomial.polynomial.polyval(s, gap_below(h, *now, step))
        fall = -later[:, 1] - np.polynomial.polynomial.polyval(s, fall_below(h, *now[1:], step))
        most, small = amplitude * (h.Omega * step) ** 4, 1e-16 * amplitude * (1 + h.Omega * t)
        assert (gap >= -small).all()
        assert (gap <= most * s**4 / 12 + small).all()
        assert (fall >= -small * h.Omega).all()
        assert (fall <= most / step * s**3 / 3 + small * h.Omega).all()


@pytest.mark.parametrize("g", [0.3, 9.82])
def test_after_the_latest_landing_there_is_no_gap(g: float, rng: np.random.Generator) -> None:
    """A point lands a millionth of the time before it; a top whose gap is widest where its turn is highest, then."""
    for start, rise in rng.uniform(0, 1, (20, 2)):
        point = Hop(start, rise, -g, 0.0, 0.0, 1.0, rise, g)
        assert 0.5e-6 < latest(point) / landing_time(point) - 1 < 2e-6
    for h in random_hops(rng, 0, 100):
        last = latest(h)
        assert all(gap_in_flight(h, last * (1 + x))[0] < 0 for x in (0, *rng.uniform(0, 0.2, 20)))
        highest, t = 2 * np.hypot(h.even, h.odd), last / (1 + 1e-6)
        assert h.start + highest + h.rise * t - h.g * t**2 / 2 == pytest.approx(0, abs=1e-12)


def test_a_landing_takes_few_evaluations(rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps grow again after a close approach, and Newton ends the search: 34 in the median, else 54 or more."""
    calls, counts = [], []
    monkeypatch.setattr(landing, "gap_in_flight", lambda h, t: calls.append(t) or gap_in_flight(h, t))
    for h in random_hops(rng, 0, 150):
        landing_time(h)
        counts.append(len(calls))
        calls.clear()
    assert np.median(counts) < 45


@pytest.mark.parametrize("share", [1e-2, 1e-6, 1e-10, 1e-14])
def test_grazing_liftoffs_land_at_once(share: float) -> None:
    """Their hop lasts 4 gap'''/|gap''''|, to first order."""
    h = made(0.0, 0.0, 0.0, -0.006, -0.006 * share, 1000.0)
    assert landing_time(h) * 1000 == pytest.approx(4 * share, rel=share)


def near_touch(depth: float) -> Hop:
    """A gap whose second minimum, where x = 3 pi/2 or so, is -depth: (1 + sin x) amplitude, less a slow fall."""
    amplitude, Omega = 0.006, 100.0  # 1 + sin x = 1 + x - (x - sin x)
    return made(amplitude - depth, amplitude * Omega, -1e-7, 0.0, amplitude, Omega)


@pytest.mark.parametrize("depth", [1e-4, 1e-8, 1e-12, -1e-12, -1e-8, -1e-4])
def test_a_gap_that_all_but_closes_is_followed(depth: float) -> None:
    """A minimum just below zero is a landing on its way down; one just above is none."""
    h = near_touch(depth)
    fallen, sag = 3 * np.pi / 2 / h.Omega, 1e-7 * (3 * np.pi / 2 / h.Omega) ** 2 / 2
    before = np.sqrt(2 * (depth + sag) / 0.006) / h.Omega if depth + sag > 0 else None
    t = landing_time(h)
    if before is None:
        assert t > fallen * 1.5
    else:
        assert t == pytest.approx(fallen - before, rel=0.1 * before * h.Omega + 1e-6)


def test_the_first_of_two_balls_lands(rng: np.random.Generator) -> None:
    hops = random_hops(rng, 0, 6)
    which, t = first_landing(hops)
    assert t == min(landing_time(h) for h in hops) == landing_time(hops[which])


def test_what_does_not_open_lands_at_once() -> None:
    assert landing_time(made(0.0, -0.1, -9.8, 0.0, 0.0, 1.0)) == 0
    assert landing_time(made(0.0, 0.0, 0.0, -0.006, 0.006, 1000.0)) == 0


def test_the_height_of_a_stem_is_that_of_its_lowest_point(rng: np.random.Generator) -> None:
    """Of points all over its ball, whose middle is `offset` along the axis from the centre of mass."""
    points = rng.normal(size=(200_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for z in (-1.0, -0.3, 0.7):
        axis = np.array([np.sqrt(1 - z * z), 0.0, z])
        lowest = (0.05 + 0.016 * axis[2] + 0.004 * points[:, 2]).min()
        assert stem_height(0.05, z, 0.016, 0.004) == pytest.approx(lowest, abs=1e-7)

"""Runs of bodies without an axis of symmetry: against multi-precision references, own Newton and
Euler in body axes, closed forms, mirror images, and the tippe top.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nightly import at_night
from scipy.integrate import solve_ivp

import tippetop as tt
from tippetop.exchange.simulators import text_of
from tippetop.runs.certificate import certificate_violations
from tippetop.runs.shape import shape
from tippetop.scenario.build import resolved


REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "ellipsoids.json").read_text())
BOAT = tt.Ellipsoid(**tt.load("rattleback").parameters)
START = {"tilt": 0.01, "roll": 0.02, "heading": 0.3, "spin": -5.0}
STEP = 1e-30
UP = np.array([0.0, 0.0, 1.0])


# --- references ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("rattleback-rolling", 1e-11),  # it reverses: errors grow
        ("rattleback-gliding", 1e-12),
        ("three-inertias-rolling", 1e-12),
        ("off-axis-gliding", 1e-12),
    ],
)
def test_a_motion_is_that_of_the_reference(name: str, tolerance: float) -> None:
    case = REFERENCE[name]
    law = tt.friction.Viscous(mu=case["mu"]) if case["mu"] else None
    times = [row[0] for row in case["rows"]]
    options = {"start": case["initial"], "until": times[-1], "output_times": times}
    rows = tt.run(tt.Ellipsoid(**case["parameters"]), law, **options).trajectory
    for i, (_, *expected) in enumerate(case["rows"]):
        found = [rows[n].values[i] for n in ("axis", "L", "energy", "normal_force", "x")]
        for mine, theirs in zip(found, expected, strict=True):
            size = np.max(np.abs(theirs))
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=tolerance * size)


# --- own Newton and Euler -----------------------------------------------------------------------


def support(n: np.ndarray, top: Any) -> Any:
    """Return the largest n.p of points p of an ellipsoid; body axes, n has any length."""
    c, s = np.cos(top.delta), np.sin(top.delta)
    along = np.array([c * n[0] + s * n[1], c * n[1] - s * n[0], n[2]])
    half = np.array([top.a, top.b, top.c]) * along
    return np.sqrt(half @ half) + n @ np.array([top.x, top.y, top.h])


def arm(up: np.ndarray, top: Any) -> np.ndarray:
    """Return its lowest point, by the gradient of the support function."""
    return np.array([np.imag(support(-up + 1j * STEP * e, top)) / STEP for e in np.eye(3)])


def arm_rate(up: np.ndarray, turn: np.ndarray, top: Any) -> np.ndarray:
    """Return its rate in the body, by a difference of sixth order."""
    h = 2e-3 / max(np.linalg.norm(turn), 1e-3)
    sides = [arm(up + k * h * turn, top) - arm(up - k * h * turn, top) for k in (1, 2, 3)]
    return np.array([45, -9, 1]) @ sides / (60 * h)


FLIES, ROLLS = "flies", "rolls"


class Own:
    """A state in body axes: axes 1, 2, 3 in space, omega, velocity and height of the centre."""

    def __init__(self, y: np.ndarray, top: Any):
        self.E, self.omega, self.V, self.height = y[:9].reshape(3, 3), y[9:12], y[12:15], y[15]
        self.top, self.up = top, self.E[:, 2]
        self.inertia = np.array([top.I1, top.I2, top.I3])
        self.arm = arm(self.up, top)
        self.slip = self.E @ self.V + np.cross(self.omega, self.arm)
        turned = [np.cross(np.cross(self.arm, e) / self.inertia, self.arm) for e in np.eye(3)]
        self.K = np.eye(3) / top.m + turned
        self.gap = self.height + self.arm @ self.up

    def rates(self, how: Any) -> np.ndarray:
        """Return the rates; how: FLIES, ROLLS, or k(|v_A|) of F = N (zhat - k v_A)."""
        top, omega, up = self.top, self.omega, self.up
        free = np.cross(self.inertia * omega, omega) / self.inertia
        moves = arm_rate(up, np.cross(up, omega), top) + np.cross(omega, self.arm)
        bias = np.cross(free, self.arm) + np.cross(omega, moves) - top.g * up
        F = np.zeros(3)
        if how == ROLLS:
            F = np.linalg.solve(self.K, -bias)
        elif how != FLIES:
            push = up - how(np.linalg.norm(self.slip)) * self.slip
            F = -(up @ bias) / (up @ self.K @ push) * push
        spins = free + np.cross(self.arm, F) / self.inertia
        turns = [np.cross(omega @ self.E, e) for e in self.E]
        return np.concatenate([*turns, spins, F @ self.E / top.m - top.g * UP, self.V[2:]])

    def struck(self, e_n: float) -> np.ndarray:
        """Return the state after an impact without friction."""
        p = -(1 + e_n) * (self.up @ self.slip) / (self.up @ self.K @ self.up) * self.up
        omega = self.omega + np.cross(self.arm, p) / self.inertia
        V = self.V + p @ self.E / self.top.m
        return np.concatenate([self.E.ravel(), omega, V, [self.height]])


def followed(
    y: np.ndarray, top: Any, how: Any, until: float, ends: Callable | None = None
) -> tuple:
    """Return time and state where a motion ends: at `until`, or where ends(Own) falls through 0."""
    event = None
    if ends:
        event = lambda t, y: ends(Own(y, top))  # noqa: E731
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 2e-3}
    rates = lambda t, y: Own(y, top).rates(how)  # noqa: E731
    end = solve_ivp(rates, (0, until), y, events=event, **options).t[-1]
    return end, solve_ivp(rates, (0, end), y, **options).y[:, -1]


def at_start(run: Any, top: Any) -> np.ndarray:
    """Return the own state at the start of a run, of its columns."""
    row = run.trajectory.isel(time=0)
    w, x, y, z = row.orientation.values
    E = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    omega = E @ row.L.values / [top.I1, top.I2, top.I3]
    phi = float(row.phi)
    slip = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    v = np.append(slip @ [float(row.get(n, 0.0)) for n in ("nu_x", "nu_y")], row.get("nu_z", 0.0))
    V = v - np.cross(omega, arm(E[:, 2], top)) @ E
    height = float(row.get("gap", 0.0)) - arm(E[:, 2], top) @ E[:, 2]
    return np.concatenate([E.ravel(), omega, V, [height]])


def assert_end(run: Any, top: Any, y: np.ndarray, tolerance: float) -> None:
    """The last row of a run is an own state."""
    end, row = Own(y, top), run.trajectory.isel(time=-1)
    L = (end.inertia * end.omega) @ end.E
    np.testing.assert_allclose(row.axis, end.E[2], rtol=0, atol=tolerance)
    np.testing.assert_allclose(row.L, L, rtol=0, atol=tolerance * np.abs(L).max())


def random_top(rng: np.random.Generator) -> Any:
    """Return an ellipsoid of a few centimetres."""
    m, half = 0.05, dict(zip("abc", rng.uniform(0.01, 0.04, 3), strict=True))
    offsets = {n: 0.1 * half[s] * rng.normal() for n, s in zip("xyh", "abc", strict=True)}
    inertia = m * 0.02**2 * rng.uniform(0.3, 0.5, 3)
    moments = dict(zip(("I1", "I2", "I3"), inertia, strict=True))
    return tt.Ellipsoid(m=m, delta=rng.uniform(-1, 1), g=9.81, **half, **offsets, **moments)


def random_start(rng: np.random.Generator) -> dict[str, float]:
    rates = dict(zip(("theta_dot", "phi_dot", "omega3"), rng.normal(size=3) * 5, strict=True))
    return rates | {"theta": rng.uniform(0.6, 1.4), "phi": 0.5, "psi": rng.uniform(-3, 3)}


@pytest.mark.parametrize("law", [None, tt.friction.Viscous(mu=0.5), tt.friction.Coulomb(mu=0.2)])
@pytest.mark.parametrize("count", [3, at_night(50)])
def test_random_bodies_move_as_newton_and_euler_say(
    law: Any, count: int, rng: np.random.Generator
) -> None:
    """Rolling; sliding under a smooth law; under Coulomb's law itself, as long as they slide."""
    slides = {"viscous": lambda v: law.mu, "coulomb": lambda v: law.mu / v}
    for _ in range(count):
        top, start, until = random_top(rng), random_start(rng), 0.02
        more = {"on_liftoff": "fly"} if law else {"on_liftoff": "continue"}
        if law:
            start |= {"nu_x": 1.0, "nu_y": 1.0}
        run = tt.run(top, law, start=start, until=until, output_step=until, **more)
        if law and law.key == "coulomb" and list(run.phases.phase.values) != [0]:
            continue
        how = slides[law.key] if law else ROLLS
        _, y = followed(at_start(run, top), top, how, until)
        assert_end(run, top, y, 1e-10)


@pytest.mark.parametrize("count", [1, at_night(50)])
def test_random_bodies_come_to_roll_as_newton_and_euler_say(
    count: int, rng: np.random.Generator
) -> None:
    """Under Coulomb's law itself: a slide ends at |v_A| = 0, after a last step of explicit form."""
    law, until, seen = tt.friction.Coulomb(mu=0.5), 0.03, 0
    k = lambda v: law.mu / v  # noqa: E731
    while seen < count:
        top, start = random_top(rng), random_start(rng) | {"nu_x": 0.05}
        top = top._replace(a=0.02 + 0.2 * top.a, b=0.02 + 0.2 * top.b, c=0.02)
        run = tt.run(top, law, start=start, until=until, output_step=until)
        if list(run.phases.phase.values) != [0, 1]:
            continue
        seen += 1
        y = at_start(run, top)
        time, y = followed(y, top, k, until, lambda own: np.linalg.norm(own.slip) - 1e-9)
        ahead = y + 1e-12 * Own(y, top).rates(k)
        speeds = [np.linalg.norm(Own(one, top).slip) for one in (y, ahead)]
        last = 1e-12 / (1 - speeds[1] / speeds[0])
        _, y = followed(y + last * Own(y, top).rates(k), top, ROLLS, until - time - last)
        assert run.phases.end.values[0] == pytest.approx(time + last, abs=1e-14)
        assert_end(run, top, y, 1e-10)


def test_a_dropped_body_bounces_as_newton_and_euler_say(rng: np.random.Generator) -> None:
    """Without friction, e_n = 0.5: flights and impacts."""
    until, top = 0.055, random_top(rng)
    start = random_start(rng) | {"gap": 2e-3}
    options = {"start": start, "until": until, "output_step": until, "contact": {"e_n": 0.5}}
    run = tt.run(top, tt.friction.Frictionless(), **options)
    y, time = at_start(run, top), 0.0
    assert run.impacts.time.size == 3
    for when in run.impacts.time.values:
        after, y = followed(y, top, FLIES, until, lambda own: own.gap)
        time += after
        assert when == pytest.approx(time, abs=1e-15)
        y = Own(y, top).struck(0.5)
    _, y = followed(y, top, FLIES, until - time)
    assert_end(run, top, y, 1e-10)


# --- phases -------------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", ["double", "longdouble"])
@pytest.mark.parametrize("mu", [0.05, 0.3])
def test_every_phase_keeps_its_balance(mu: float, precision: str) -> None:
    """At mu = 0.3 it rolls, and slides for milliseconds in the direction of the force."""
    start = {**START, "gap": 1e-3}
    options = {"start": start, "until": 0.15, "contact": {"e_n": 0.4}, "precision": precision}
    run = tt.run(BOAT, tt.friction.Coulomb(mu=mu), **options)
    assert run.summary.event_counts["impact"] > 0
    assert run.drift["energy_balance"] < 1e-13


@pytest.mark.parametrize("until", [0.2, at_night(2.2)])
def test_short_slides_of_a_rattleback_do_not_end_its_run(until: float) -> None:
    """It rolls near the edge of the cone, for which explicit steps were too stiff at 2.1075 s."""
    start = {"theta": 0.01, "psi": 1.0 - BOAT.delta, "phi_dot": -5.0, "omega3": -5.0}
    law = tt.friction.Coulomb(mu=0.3)
    run = tt.run(BOAT, law, start=start | {"nu_x": 0.0}, until=until)
    assert run.summary.status == "finished"
    assert run.drift["energy_balance"] < 1e-13


# --- closed forms and limits --------------------------------------------------------------------


def test_a_resting_boat_rocks_with_two_frequencies() -> None:
    """Rolling with delta = 0: omega^2 = m g (r - k)/(I + m k^2), k the height, r the radius."""
    boat = BOAT._replace(delta=0.0)
    k = boat.c - boat.h
    peaks = {"tilt": (boat.a, boat.I2), "roll": (boat.b, boat.I1)}
    for name, (half, inertia) in peaks.items():
        run = tt.run(boat, start={name: 1e-6, "spin": 0.0}, until=5.0, events=[f"{name}_peak"])
        r = half**2 / boat.c
        omega = np.sqrt(boat.m * boat.g * (r - k) / (inertia + boat.m * k**2))
        times = run.events.time.values
        np.testing.assert_allclose(np.diff(times), np.pi / omega, rtol=1e-6)


@pytest.mark.parametrize("law", [None, tt.friction.Viscous(mu=0.3), tt.friction.Coulomb(mu=0.3)])
def test_a_round_ellipsoid_is_the_tippe_top(law: Any) -> None:
    """With two equal moments; delta, and so the start of axis 1, does not matter."""
    numbers = {"m": 0.02, "g": 9.82, "I1": 2.994e-6, "I3": 3.2e-6}
    half = dict.fromkeys("abc", 0.02)
    tops = (
        tt.TippeTop(R=0.02, alpha=0.3, **numbers),
        tt.Ellipsoid(**half, **numbers, I2=numbers["I1"], delta=0.4, x=0.0, y=0.0, h=0.006),
    )
    start = {"theta": 0.5, "psi": 0.3, "omega3": 60.0} | ({"nu_x": 0.0} if law else {})
    more = {"until": 0.5}
    if type(law).__name__ == "Coulomb":
        start["gap"], more["contact"] = 1e-3, {"e_n": 0.5}
    one, two = (
        tt.run(top, law, system=None if law else top.resting, start=start, **more).trajectory
        for top in tops
    )
    for name in ("axis", "L", "energy", "normal_force", "x", "orientation"):
        size = np.max(np.abs(one[name].values))
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("law", [None, tt.friction.Viscous(mu=3.0), tt.friction.Coulomb(mu=0.1)])
def test_mirror_images_are_exact(law: Any) -> None:
    """(phi, psi, phi', omega_3, nu_y, delta, y) -> -(...); no bit differs."""
    top = BOAT._replace(x=1e-3, y=2e-3)
    start = {"theta": 0.2, "phi": 0.3, "psi": 1.0, "phi_dot": -5.0, "omega3": -4.0}
    start |= {"nu_y": 0.1} if law else {}
    image = {n: v if n == "theta" else -v for n, v in start.items()}
    other = top._replace(delta=-top.delta, y=-top.y)
    one, two = (
        tt.run(t, law, start=s, until=0.5).trajectory for t, s in ((top, start), (other, image))
    )
    for name, sign in {"theta": 1, "spin": -1, "energy": 1, "tilt": 1, "roll": -1, "y": -1}.items():
        np.testing.assert_array_equal(two[name].values, sign * one[name].values)


def test_both_ways_to_start_are_one() -> None:
    run = tt.run(BOAT, start=START, until=1e-3)
    row = run.trajectory.isel(time=0)
    for name, value in START.items():
        assert float(row[name]) == pytest.approx(value, abs=1e-15)
    names = ("theta", "phi", "psi", "theta_dot", "phi_dot", "omega3")
    again = tt.run(BOAT, start={n: float(row[n]) for n in names}, until=1e-3)
    for name in ("orientation", "L"):
        first, other = (r.trajectory[name].values[0] for r in (run, again))
        np.testing.assert_allclose(other, first, rtol=0, atol=1e-13 * np.abs(first).max())
    with pytest.raises(tt.InputError, match="tilt"):
        tt.run(BOAT, start=START | {"theta": 0.1}, until=1e-3)


# --- what surrounds a run -----------------------------------------------------------------------


def test_a_run_certifies_and_its_end_is_a_start(tmp_path: Path) -> None:
    law, store = tt.friction.Coulomb(mu=0.1), tmp_path / "a.zarr"
    run = tt.run(BOAT, law, start=START, until=0.1, out=store)
    begins = tt.run(BOAT, law, start=store, until=1e-3).trajectory
    np.testing.assert_array_equal(begins.axis[0], run.trajectory.axis[-1])
    np.testing.assert_array_equal(begins.orientation[0], run.trajectory.orientation[-1])
    assert certificate_violations(run.certify()) == []


def test_derivatives_by_delta_are_those_of_differences() -> None:
    options = {"start": START, "until": 0.5}
    found = tt.derivatives.sensitivities(BOAT, ["delta"], **options)
    step = 1e-6
    ends = [
        tt.run(BOAT._replace(delta=BOAT.delta + h), **options).trajectory.spin.values[-1]
        for h in (-step, step)
    ]
    by_delta = float(found.trajectory.spin.sel(parameter="parameters.delta").values[-1])
    assert by_delta == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-5)


def test_the_ensemble_is_that_of_single_runs() -> None:
    spins = [-3.0, -2.0]
    tops = tt.ensemble(BOAT, {"spin": spins}, start=START, until=3.0)
    for k, spin in enumerate(spins):
        alone = tt.run(BOAT, start=START | {"spin": spin}, until=3.0)
        assert alone.summary.kept["spin_reversals"] > 0
        assert float(tops.reversed_at[k]) == pytest.approx(alone.summary.kept["reversed_at"], 1e-9)


def test_what_is_not_known_of_such_bodies_is_refused() -> None:
    law, problem = tt.friction.Viscous(mu=3.0), tt.load("off-axis-top")
    refusals: dict[str, Callable] = {
        "mu_r": lambda: tt.run(
            BOAT, tt.friction.Coulomb(mu=0.3, mu_r=1e-4), start=START, until=1.0
        ),
        "contensou": lambda: tt.run(
            BOAT, tt.friction.Contensou(mu=0.3, patch=1e-3), start=START, until=1.0
        ),
        "stem": lambda: tt.run(BOAT, law, start=START, until=1.0, stem={"r": 1e-3, "h": 0.03}),
        "Painleve": lambda: tt.run(BOAT, tt.friction.Coulomb(mu=9.0), start=START, until=1.0),
        "HeavyTop": lambda: tt.theory.thresholds(BOAT),
        "I1": lambda: BOAT._replace(I1=1.0) and tt.Ellipsoid(**{**BOAT._asdict(), "I1": 1.0}),
        "centre of mass": lambda: tt.Ellipsoid(**{**BOAT._asdict(), "h": 0.03}),
        "outline": lambda: shape(resolved(problem)),
        "must be a top": lambda: text_of(problem, "mjcf"),
    }
    for word, refused in refusals.items():
        with pytest.raises(tt.InputError, match=word):
            refused()

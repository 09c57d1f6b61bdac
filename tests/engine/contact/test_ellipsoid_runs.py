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
from scipy.spatial.transform import Rotation

import tippetop as tt
from tippetop.friction import Coulomb, Frictionless, Viscous
from tippetop.runs.certificate import certificate_violations


REFERENCE = json.loads((Path(__file__).parents[2] / "reference" / "ellipsoids.json").read_text())
BOAT = tt.Ellipsoid(**tt.load("rattleback").parameters)
START = {"tilt": 0.01, "roll": 0.02, "heading": 0.3, "spin": -5.0}
EULER = {"theta": 0.2, "phi": 0.3, "psi": 1.0, "phi_dot": -5.0, "omega3": -4.0}
STEP = 1e-30


@pytest.mark.parametrize("name", [name for name in REFERENCE if name != "source"])
def test_a_motion_is_that_of_the_reference(name: str) -> None:
    """To rounding; errors grow where a rattleback reverses."""
    case = REFERENCE[name]
    law = Viscous(mu=case["mu"]) if case["mu"] else None
    tolerance = 1e-11 if name == "rattleback-rolling" else 1e-12
    times = [row[0] for row in case["rows"]]
    options = {"start": case["initial"], "until": times[-1], "output_times": times}
    rows = tt.run(tt.Ellipsoid(**case["parameters"]), law, **options).trajectory
    for i, (_, *expected) in enumerate(case["rows"]):
        found = [rows[n].values[i] for n in ("axis", "L", "energy", "normal_force", "x")]
        for mine, theirs in zip(found, expected, strict=True):
            atol = tolerance * np.max(np.abs(theirs))
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=atol)


# --- own Newton and Euler -----------------------------------------------------------------------


def support(n: np.ndarray, top: Any) -> Any:
    """Return the largest n.p of points p of an ellipsoid; body axes, n has any length."""
    turned = Rotation.from_euler("z", -top.delta).as_matrix() @ n
    half = np.array([top.a, top.b, top.c]) * turned
    return np.sqrt(half @ half) + n @ np.array([top.x, top.y, top.h])


def arm(up: np.ndarray, top: Any) -> np.ndarray:
    """Return its lowest point, by the gradient of the support function."""
    return np.array([np.imag(support(-up + 1j * STEP * e, top)) / STEP for e in np.eye(3)])


def arm_rate(up: np.ndarray, turn: np.ndarray, top: Any) -> np.ndarray:
    """Return its rate in the body, by a difference of sixth order."""
    h = 2e-3 / max(np.linalg.norm(turn), 1e-3)
    sides = [arm(up + k * h * turn, top) - arm(up - k * h * turn, top) for k in (1, 2, 3)]
    return np.array([45, -9, 1]) @ sides / (60 * h)


class Own:
    """A state: axes 1, 2, 3 in space; in these axes omega; velocity and height of the centre."""

    def __init__(self, y: np.ndarray, top: Any):
        self.E, self.omega, self.V, self.top = y[:9].reshape(3, 3), y[9:12], y[12:15], top
        self.up, self.I = self.E[:, 2], np.array([top.I1, top.I2, top.I3])
        self.arm = arm(self.up, top)
        self.gap = y[15] + self.arm @ self.up
        self.slip = self.E @ self.V + np.cross(self.omega, self.arm)
        self.speed = np.linalg.norm(self.slip)
        turns = [np.cross(np.cross(self.arm, e) / self.I, self.arm) for e in np.eye(3)]
        self.K = np.eye(3) / top.m + turns

    def rates(self, how: Any) -> np.ndarray:
        """Return the rates; how: "flies", "rolls", or k(|v_A|) of F = N (zhat - k v_A)."""
        top, omega, up = self.top, self.omega, self.up
        free = np.cross(self.I * omega, omega) / self.I
        moves = arm_rate(up, np.cross(up, omega), top) + np.cross(omega, self.arm)
        bias = np.cross(free, self.arm) + np.cross(omega, moves) - top.g * up
        F = -np.linalg.solve(self.K, bias) * (how == "rolls")
        if callable(how):
            push = up - how(self.speed) * self.slip
            F = -(up @ bias) / (up @ self.K @ push) * push
        turns = [np.cross(omega @ self.E, e) for e in self.E]
        spins = free + np.cross(self.arm, F) / self.I
        falls = F @ self.E / top.m - [0, 0, top.g]
        return np.concatenate([*turns, spins, falls, self.V[2:]])

    def impact(self, e_n: float) -> np.ndarray:
        """Return the change of the state in an impact without friction."""
        p = -(1 + e_n) * (self.up @ self.slip) / (self.up @ self.K @ self.up) * self.up
        spins = np.cross(self.arm, p) / self.I
        return np.concatenate([np.zeros(9), spins, p @ self.E / self.top.m, [0]])


def followed(
    y: np.ndarray, top: Any, how: Any, until: float, ends: Callable | None = None
) -> tuple:
    """Return time and state where a motion ends: at `until`, or where ends(Own) falls through 0."""
    event = ends and (lambda t, y: ends(Own(y, top)))
    if event:
        event.terminal, event.direction = True, -1
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 2e-3}
    rates = lambda t, y: Own(y, top).rates(how)  # noqa: E731
    end = solve_ivp(rates, (0, until), y, events=event, **options).t[-1]
    return end, solve_ivp(rates, (0, end), y, **options).y[:, -1]


def at_start(run: Any, top: Any) -> np.ndarray:
    """Return the own state at the start of a run, of its columns."""
    row = run.trajectory.isel(time=0)
    E = Rotation.from_quat(np.roll(row.orientation.values, -1)).as_matrix().T
    omega = E @ row.L.values / [top.I1, top.I2, top.I3]
    v = [float(row.get(name, 0.0)) for name in ("nu_x", "nu_y", "nu_z")]
    a = arm(E[:, 2], top)
    V = Rotation.from_euler("z", float(row.phi)).as_matrix() @ v - np.cross(omega, a) @ E
    return np.concatenate([E.ravel(), omega, V, [float(row.get("gap", 0.0)) - a @ E[:, 2]]])


def assert_end(run: Any, top: Any, y: np.ndarray) -> None:
    """The last row of a run is an own state."""
    end, row = Own(y, top), run.trajectory.isel(time=-1)
    L = (end.I * end.omega) @ end.E
    np.testing.assert_allclose(row.axis, end.E[2], rtol=0, atol=1e-10)
    np.testing.assert_allclose(row.L, L, rtol=0, atol=1e-10 * np.abs(L).max())


def random_case(rng: np.random.Generator, until: float, law: Any, **more: Any) -> tuple:
    """Return an ellipsoid of a few centimetres, and its run with one row at the end."""
    start = dict(zip(("theta_dot", "phi_dot", "omega3"), rng.normal(size=3) * 5, strict=True))
    start |= {"theta": rng.uniform(0.6, 1.4), "phi": 0.5, "psi": rng.uniform(-3, 3)}
    half = dict(zip("abc", rng.uniform(0.015, 0.03, 3), strict=True))
    numbers = half | dict(zip("xyh", 0.002 * rng.normal(size=3), strict=True))
    inertia = dict(zip(("I1", "I2", "I3"), 2e-5 * rng.uniform(0.3, 0.5, 3), strict=True))
    top = tt.Ellipsoid(m=0.05, delta=rng.uniform(-1, 1), g=9.81, **numbers, **inertia)
    start |= more.pop("start", {})
    return top, tt.run(top, law, start=start, until=until, output_step=until, **more)


@pytest.mark.parametrize("law", [None, Viscous(mu=0.5), Coulomb(mu=0.2)])
@pytest.mark.parametrize("count", [3, at_night(50)])
def test_random_bodies_move_as_newton_and_euler_say(
    law: Any, count: int, rng: np.random.Generator
) -> None:
    """Rolling; sliding under a smooth law; under Coulomb's law itself, as long as they slide."""
    slides = {"viscous": lambda v: law.mu, "coulomb": lambda v: law.mu / v}
    options = {"start": {"nu_x": 1.0, "nu_y": 1.0} if law else {}, "on_liftoff": "continue"}
    if law and law.key == "coulomb":
        options["on_liftoff"] = "fly"
    for _ in range(count):
        top, run = random_case(rng, 0.02, law, **options)
        if not law or law.key == "viscous" or list(run.phases.phase.values) == [0]:
            how = slides[law.key] if law else "rolls"
            assert_end(run, top, followed(at_start(run, top), top, how, 0.02)[1])


@pytest.mark.parametrize("count", [1, at_night(50)])
def test_random_bodies_come_to_roll_as_newton_and_euler_say(
    count: int, rng: np.random.Generator
) -> None:
    """Under Coulomb's law itself: a slide ends at |v_A| = 0, after a last step of explicit form."""
    until, k = 0.03, lambda v: 0.5 / v
    while count:
        top, run = random_case(rng, until, Coulomb(mu=0.5), start={"nu_x": 0.05})
        if list(run.phases.phase.values) == [0, 1]:
            count -= 1
            y = at_start(run, top)
            time, y = followed(y, top, k, until, lambda own: own.speed - 1e-9)
            rates = Own(y, top).rates(k)
            last = 1e-12 / (1 - Own(y + 1e-12 * rates, top).speed / Own(y, top).speed)
            assert run.phases.end.values[0] == pytest.approx(time + last, abs=1e-12)
            assert_end(run, top, followed(y + last * rates, top, "rolls", until - time - last)[1])


def test_a_dropped_body_bounces_as_newton_and_euler_say(rng: np.random.Generator) -> None:
    """Without friction, e_n = 0.5: flights and impacts."""
    until, time = 0.05, 0.0
    options = {"start": {"gap": 2e-3}, "contact": {"e_n": 0.5}}
    top, run = random_case(rng, until, Frictionless(), **options)
    y = at_start(run, top)
    for when in run.impacts.time.values[:3]:
        after, y = followed(y, top, "flies", until, lambda own: own.gap)
        time += after
        assert when == pytest.approx(time, abs=1e-15)
        y = y + Own(y, top).impact(0.5)
    if run.impacts.time.size == 3:
        assert_end(run, top, followed(y, top, "flies", until - time)[1])


# --- phases, closed forms and limits ------------------------------------------------------------


@pytest.mark.parametrize(
    ("mu", "start", "until"),
    [
        (0.05, START | {"gap": 1e-3}, 0.15),
        (0.3, START | {"gap": 1e-3}, 0.15),  # it rolls, and slides for milliseconds
        # near the edge of the cone, where explicit steps were too stiff
        at_night(0.3, {"theta": 0.01, "psi": 1 - BOAT.delta, "phi_dot": -5.0, "omega3": -5.0}, 2.2),
    ],
)
def test_every_phase_keeps_its_balance(mu: float, start: dict, until: float) -> None:
    start = start if "spin" in start else start | {"nu_x": 0.0}
    run = tt.run(BOAT, Coulomb(mu=mu), start=start, until=until, contact={"e_n": 0.4})
    assert run.summary.status == "finished"
    assert run.drift["energy_balance"] < 1e-13


@pytest.mark.parametrize(("name", "half", "inertia"), [("tilt", "a", "I2"), ("roll", "b", "I1")])
def test_a_resting_boat_rocks_with_two_frequencies(name: str, half: str, inertia: str) -> None:
    """Rolling with delta = 0: omega^2 = m g (r - k)/(I + m k^2), k the height, r the radius."""
    boat, k = BOAT._replace(delta=0.0), BOAT.c - BOAT.h
    start = {name: 1e-6, "spin": 0.0}
    times = tt.run(boat, start=start, until=5.0, events=[f"{name}_peak"]).events.time.values
    r, I = getattr(boat, half) ** 2 / boat.c, getattr(boat, inertia)
    omega = np.sqrt(boat.m * boat.g * (r - k) / (I + boat.m * k**2))
    np.testing.assert_allclose(np.diff(times), np.pi / omega, rtol=1e-6)


@pytest.mark.parametrize("law", [None, Viscous(mu=0.3), Coulomb(mu=0.3)])
def test_a_round_ellipsoid_is_the_tippe_top(law: Any) -> None:
    """With two equal moments: it rolls, glides, or falls, strikes, slides and rolls."""
    numbers = {"m": 0.02, "g": 9.82, "I1": 2.994e-6, "I3": 3.2e-6}
    half = dict.fromkeys("abc", 0.02)
    top = tt.TippeTop(R=0.02, alpha=0.3, **numbers)
    other = tt.Ellipsoid(**half, **numbers, I2=numbers["I1"], delta=0.4, x=0.0, y=0.0, h=0.006)
    start = {"theta": 0.5, "psi": 0.3, "omega3": 60.0}
    more = {"system": top.resting} if law is None else {}
    if law and law.key == "coulomb":
        start["gap"], more["contact"] = 1e-3, {"e_n": 0.5}
    one = tt.run(top, law, start=start, until=0.5, **more).trajectory
    more.pop("system", None)
    two = tt.run(other, law, start=start, until=0.5, **more).trajectory
    for name in ("axis", "L", "energy", "normal_force", "x", "orientation"):
        size = np.max(np.abs(one[name].values))
        np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("law", [None, Viscous(mu=3.0), Coulomb(mu=0.1)])
def test_mirror_images_are_exact(law: Any) -> None:
    """(phi, psi, phi', omega_3, nu_y, delta, y) -> -(...); no bit differs."""
    start = EULER | ({"nu_y": 0.1} if law else {})
    image = {n: v if n == "theta" else -v for n, v in start.items()}
    top, other = BOAT._replace(y=2e-3), BOAT._replace(delta=-BOAT.delta, y=-2e-3)
    one, two = (
        tt.run(t, law, start=s, until=0.5).trajectory for t, s in ((top, start), (other, image))
    )
    for name, sign in {"theta": 1, "spin": -1, "energy": 1, "tilt": 1, "roll": -1, "y": -1}.items():
        np.testing.assert_array_equal(two[name].values, sign * one[name].values)


# --- what surrounds a run -----------------------------------------------------------------------


def test_a_run_certifies_and_its_end_is_a_start(tmp_path: Path) -> None:
    law, store = Coulomb(mu=0.1), tmp_path / "a.zarr"
    run = tt.run(BOAT, law, start=START, until=0.1, out=store)
    begins = tt.run(BOAT, law, start=store, until=1e-3).trajectory.orientation[0]
    np.testing.assert_array_equal(begins, run.trajectory.orientation[-1])
    assert certificate_violations(run.certify()) == []


def test_both_ways_to_start_are_one_and_lanes_are_runs() -> None:
    spins = [-3.0, -2.0]
    ends = tt.ensemble(BOAT, {"spin": spins}, start=START, until=3.0)
    for k, spin in enumerate(spins):
        run = tt.run(BOAT, start=START | {"spin": spin}, until=3.0)
        assert float(ends.reversed_at[k]) == pytest.approx(run.summary.kept["reversed_at"], 1e-9)
        row = run.trajectory.isel(time=0)
        for name, value in (START | {"spin": spin}).items():
            assert float(row[name]) == pytest.approx(value, abs=1e-15)
        start = {name: float(row[name]) for name in (*EULER, "theta_dot")}
        again = tt.run(BOAT, start=start, until=1e-3).trajectory.L.values[0]
        np.testing.assert_allclose(again, row.L, rtol=0, atol=1e-13 * np.abs(again).max())


def test_derivatives_by_delta_are_those_of_differences() -> None:
    found = tt.derivatives.sensitivities(BOAT, ["delta"], start=START, until=0.5).trajectory.spin
    sides = (BOAT._replace(delta=BOAT.delta + h) for h in (1e-6, -1e-6))
    ends = [tt.run(top, start=START, until=0.5).trajectory.spin.values[-1] for top in sides]
    assert float(found[-1, 0]) == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-5)


def test_numbers_of_a_film_are_fitted_and_an_exported_run_is_compared(tmp_path: Path) -> None:
    t = np.linspace(0.05, 1.0, 20)
    scenario = tt.run(BOAT, Viscous(mu=3.0), start=START, until=1.0, output_times=[*t])
    header = "t [s],q_w,q_x,q_y,q_z"
    film = np.column_stack([t, scenario.trajectory.orientation])
    np.savetxt(tmp_path / "film.csv", film, delimiter=",", header=header, comments="")
    guess = BOAT._replace(delta=1.01 * BOAT.delta), Viscous(mu=3.1)
    problem = tt.run(*guess, start=START, until=1e-3).problem
    free = ["friction.mu", "parameters.delta"]
    fit = tt.fit(tmp_path / "film.csv", problem, free, systematic=False)
    assert fit.trustworthy
    assert fit.estimates["friction.mu"].value == pytest.approx(3.0, rel=1e-9)
    assert fit.estimates["friction.mu"].sigma < 1e-6
    scenario.export(tmp_path / "run.csv")
    (found,) = tt.compare(tmp_path / "run.csv", scenario).motions
    assert max(found.curves[name].max() for name in ("attitude", "place")) < 1e-14


def run_boat(law: Any, **more: Any) -> Any:
    return tt.run(BOAT, law, start=START, until=0.1, **more)


@pytest.mark.parametrize(
    ("word", "refused"),
    [
        ("mu_r", lambda: run_boat(Coulomb(mu=0.3, mu_r=1e-4))),
        ("contensou", lambda: run_boat(tt.friction.Contensou(mu=0.3, patch=1e-3))),
        ("stem", lambda: run_boat(Viscous(mu=3.0), stem={"r": 1e-3, "h": 0.03})),
        ("Painleve", lambda: run_boat(Coulomb(mu=9.0))),
        ("TippeTop", lambda: tt.theory.thresholds(BOAT)),
        ("I1", lambda: tt.Ellipsoid(**{**BOAT._asdict(), "I1": 1.0})),
        ("uniform", lambda: tt.Ellipsoid(m=1, a=0.2, b=0.03, c=0.02, h=0.01)),
        ("inside of the body", lambda: tt.Ellipsoid(**{**BOAT._asdict(), "x": 0.2})),
        ("inside of the body", lambda: tt.Spheroid(m=1, a=0.2, b=0.3, c=-0.2, I1=1, I3=1)),
        ("given alone", lambda: tt.run(BOAT, start=START | {"theta": 0.1}, until=0.1)),
    ],
)
def test_what_does_not_fit_such_bodies_is_refused(word: str, refused: Callable) -> None:
    with pytest.raises(tt.InputError, match=word):
        refused()

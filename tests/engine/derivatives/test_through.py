"""Derivatives through contact are those of differences of wide runs, and of closed forms."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from examples import stored_reference
from limits import assert_near
from nightly import at_night
from pages import stick_slip
from refusals import refusal
from test_along_run import LAWS as SMOOTH
from test_along_run import STENCIL

import tippetop as tt
from tippetop.engine.derivatives.through import Pass
from tippetop.library.scenarios import problem_of
from tippetop.mechanics.dual import Dual
from tippetop.mechanics.form import Exit, Next
from tippetop.mechanics.operand import atan2, cos, exp, hypot, log, sin, sqrt
from tippetop.mechanics.systems import SYSTEMS
from tippetop.mechanics.units import SECOND
from tippetop.runs.run import with_phases


pytestmark = pytest.mark.usefixtures("page")
CASES = stored_reference("derivatives_through_contact")["cases"]
SLOW = [
    pytest.param(name, marks=pytest.mark.slow) for name in CASES if "toy" in name or "drill" in name
]


# --- numbers with derivatives -------------------------------------------------------------------


def mixed(x: Any) -> Any:
    """Arithmetic and every function."""
    part = sqrt(x * x + 1) * sin(x) / (2 - cos(x)) + exp(-x) * log(x) + atan2(x, 2.0 + x)
    return part + x**3 + x**0.5 + 2.0 / x + hypot(x, 2 * x) - np.float64(3) * x + abs(x)


def test_the_rules_of_derivatives_are_limits_of_differences() -> None:
    x, h = 1.3, 1e-4
    found = mixed(Dual(x, 1.0, 0.0))
    ahead, here, behind = mixed(x + h), mixed(x), mixed(x - h)
    np.testing.assert_allclose(found.parts[0], here, rtol=1e-15)
    np.testing.assert_allclose(found.parts[1], (ahead - behind) / (2 * h), rtol=1e-8)
    np.testing.assert_allclose(found.parts[2], (ahead - 2 * here + behind) / h**2, rtol=1e-6)


@pytest.mark.parametrize("loses", [float, math.sqrt, lambda x: math.hypot(x, 1.0)])
def test_what_would_lose_a_derivative_raises(loses: Any) -> None:
    with pytest.raises(TypeError):
        loses(Dual(2.0, 1.0))


# --- bodies on a plane --------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["cohen-coulomb", "flying", *SLOW])
def test_states_and_times_are_those_of_differences_of_wide_runs(name: str) -> None:
    case = CASES[name]
    wrt = list(case["derivatives"])
    problem = problem_of(name, until=case["until"])
    _, driver = with_phases(problem)
    second = problem.unit(SECOND)
    made = Pass(problem, wrt, np.array([problem.until / second]), driver, np.eye(len(wrt)))
    assert len(driver.intervals) >= case["phases"]
    units = [*problem.variables.units.values()]
    state = [
        (Dual(*row) * made.scales.of(unit)).first[:, 0]
        for row, unit in zip(made.rows[:9, :, :-1, -1:], units, strict=False)
    ]
    ends = np.array([driver.intervals[k].ended for k in case["legs"]])
    times = made.times_of("", ends).T * second
    for k, (key, expected) in enumerate(case["derivatives"].items()):
        found = [one[k] / made.sizes[k] for one in state]
        for part in (slice(0, 3), slice(3, 6), slice(6, 9)):
            known = np.array(expected["state"][part])
            assert_near(found[part], known, 1e-9, relative=True)
        known = np.array(expected["times"])
        mine = times[:, k] / made.sizes[k]
        assert_near(mine, known, 1e-9, key, relative=True)


LAWS = {**SMOOTH, "coulomb": {"mu": 0.3}, "contensou": {"mu": 0.3, "patch": 2e-4}}


def moved(preset: str, tables: dict[str, Any], key: str, **options: Any) -> Any:
    """Return a run as a function of the change of a number."""
    table, _, name = key.partition(".")

    def run(h: float) -> Any:
        numbers = tables[table] | {name: tables[table][name] + h}
        return tt.run(preset, **tables | {table: numbers}, **options)

    return run


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_random_tops_that_bounce_have_the_derivatives_of_differences_of_wide_runs(
    seed: int,
) -> None:
    rng = np.random.default_rng(seed)
    law = [*LAWS][seed % len(LAWS)]
    names = "theta_dot", "phi_dot", "omega3", "nu_x", "nu_y", "nu_z"
    start = dict(zip(names, rng.normal(0, [20, 20, 100, 0.1, 0.1, 0.1]), strict=True))
    start |= {"theta": rng.uniform(0.1, 3.0), "gap": rng.uniform(4e-4, 4e-3)}
    end = [0.2]
    options: dict[str, Any] = {"until": end[0], "output_times": end, "friction": {"law": law}}
    options["friction"] |= LAWS[law]
    tables = {"start": start, "contact": {"e_n": rng.uniform(0.1, 0.7)}}
    wrt = ["initial.omega3", "contact.e_n"]
    found = tt.derivatives.sensitivities("flying", wrt, **tables, **options)
    assert found.run.impacts.sizes["impact"] > 0
    for k, key in enumerate(("start.omega3", "contact.e_n")):
        mine = found.trajectory.isel(parameter=k, time=-1)
        h = min(1e-4, float(mine.valid_within) / 100) * (abs(start["omega3"]), 1)[k]
        run = moved("flying", tables, key, **options, precision="longdouble")
        runs = {k * s: run(k * s * h).trajectory.isel(time=-1) for k in STENCIL for s in (1, -1)}
        for column in ("axis", "L", "nu_z"):
            whole = {
                k: one[column].values + one[f"{column}_lo"].values.astype(np.longdouble)
                for k, one in runs.items()
            }
            slope = sum(c * (whole[k] - whole[-k]) for k, c in STENCIL.items()) / h
            bound = 1e-9 * np.abs(slope).max() + 1e-16  # nu_z of a ball at rest is a difference
            assert_near(mine[column], slope, bound, column)


def assert_slopes(found: Any, ahead: Any, behind: Any, apart: float, bound: float) -> None:
    """Compare derivatives with differences of values that are `apart` in the number."""
    slope = (np.asarray(ahead) - np.asarray(behind)) / apart
    assert_near(found, slope, bound, relative=True)


def test_columns_along_a_run_are_those_of_differences() -> None:
    h = 1e-5
    law = {"friction": {"law": "coulomb", "mu": 0.3}}
    options = {"until": 1.0, "output_times": np.linspace(0.0, 1.0, 9)[1:].tolist()}
    found = tt.derivatives.sensitivities("cohen-coulomb", ["friction.mu"], **law, **options)
    run = moved("cohen-coulomb", law, "friction.mu", **options)
    ahead, behind = run(h), run(-h)
    assert not found.sentences
    assert (found.trajectory.valid_within > 1e-3).all()
    for name in ("theta", "omega3", "L", "energy", "x", "normal_force", "orientation"):
        mine = found.trajectory[name].isel(parameter=0)
        assert_slopes(mine, ahead.trajectory[name], behind.trajectory[name], 2 * h, 1e-6)
    for table, column in (("events", "time"), ("events", "theta"), ("phases", "start")):
        own = getattr(found, table)["time" if column == "start" else column].values[:, 0]
        both = (getattr(run, table)[column] for run in (ahead, behind))
        assert_slopes(own, *both, 2 * h, 1e-6)


SURROUNDINGS: dict[str, dict[str, dict[str, float]]] = {
    "vibrates": {
        "air": {"c1": 1e-7, "c2": 1e-9},
        "plane": {"tilt": 0.05, "azimuth": 0.4, "amplitude": 1e-4, "frequency": 30.0},
    },
    "turns": {"plane": {"omega": 3.0, "x": 0.1, "y": 0.02}},
}


@pytest.mark.parametrize(
    ("preset", "name"),
    [
        *(("cohen-coulomb", name) for name in SURROUNDINGS),
        at_night("inverting", "vibrates"),
        at_night("rolling", "vibrates"),
        at_night("flying", "vibrates"),
    ],
)
def test_derivatives_by_surroundings_are_those_of_differences(preset: str, name: str) -> None:
    options: dict[str, Any] = {"until": 0.3, "output_times": [0.1, 0.2, 0.3]}
    if preset == "flying":
        options["start"] = {"gap": 1e-4}
    around = SURROUNDINGS[name]
    wrt = [f"{table}.{name}" for table, numbers in around.items() for name in numbers]
    found = tt.derivatives.sensitivities(preset, wrt, **around, **options)
    if preset in ("cohen-coulomb", "flying"):
        assert found.phases.sizes["interval"] > 1
    for key in wrt:
        table, name = key.split(".")
        h = 1e-4 * around[table][name]
        run = moved(preset, around, key, **options)
        ahead, behind = run(h).trajectory, run(-h).trajectory
        mine = found.trajectory.sel(parameter=key)
        for column in ("theta", "omega3", "x", "energy"):
            assert_slopes(mine[column], ahead[column], behind[column], 2 * h, 1e-4)


def test_times_of_the_last_hops_scale_with_the_unit_of_time() -> None:
    """Euler's theorem: the sum of exponent times number times derivative of a time is the time."""
    start = {"theta": 0.1, "phi_dot": 0.0, "omega3": 120.0, "gap": 1e-3, "nu_z": -0.1}
    options: dict[str, Any] = {"start": start, "contact": {"e_n": 0.3}, "until": 0.025}
    exponents = {
        "friction.mu": 1,
        "parameters.g": -2,
        "initial.omega3": -1,
        "initial.nu_z": -1,
    }
    made = tt.derivatives.sensitivities("spinning-egg", [*exponents], **options)
    impacts = made.run.impacts.time.values
    assert len(impacts) > 12
    assert np.diff(impacts)[-1] < 1e-9
    numbers = problem_of("spinning-egg", **options).tables
    scaled = 0.0 * impacts
    for key, power in exponents.items():
        table, name = key.split(".")
        scaled += power * numbers[table][name] * made.impacts.time.sel(parameter=key).values
    np.testing.assert_allclose(scaled, impacts, rtol=1e-12)


def test_a_run_that_begins_with_a_slow_slide_has_derivatives_at_its_start() -> None:
    wrt = ["initial.theta", "friction.mu"]
    made = tt.derivatives.sensitivities("jumping-egg", wrt, until=0.02, output_step=0.002)
    theta = made.trajectory.theta.values
    np.testing.assert_array_equal(theta[0], [1.0, 0.0])
    np.testing.assert_array_equal(made.phases.time.values[0], 0.0)
    growth = tt.derivatives.lyapunov("jumping-egg", until=0.02, rows=3)
    assert np.isfinite(growth.factor).all()
    assert growth.factor[0] == pytest.approx(1.0)


def test_a_disc_that_rests_and_gives_way_has_derivatives() -> None:
    options = {"contact": {"e_n": 0.2}, "until": 0.6, "output_times": [0.2, 0.4, 0.6]}
    options["start"] = {"theta": 1.0, "omega3": 0.0, "phi_dot": 0.0, "theta_dot": 3.0}
    law = {"friction": {"law": "contensou", "mu": 0.15, "patch": 1e-3, "mu_r": 1e-6}}
    h = 1e-6
    made = tt.derivatives.sensitivities("inverting", ["friction.mu"], **law, **options)
    run = moved("inverting", law, "friction.mu", **options)
    ahead, behind = run(h), run(-h)
    assert list(made.run.phases.phase.values) == [0, 4, 0, 4, 0]
    for mine, one, other in (
        (made.trajectory.theta, ahead.trajectory.theta, behind.trajectory.theta),
        (made.phases.time, ahead.phases.start, behind.phases.start),
    ):
        assert_slopes(mine.values[:, 0], one, other, 2 * h, 1e-6)


def test_a_law_that_another_number_changes_has_no_derivative() -> None:
    law = {"law": "coulomb", "mu": 0.0}
    made = tt.derivatives.sensitivities(
        "cohen-coulomb", ["friction.mu", "omega3"], law, until=0.1, output_times=[0.1]
    )
    theta = made.trajectory.theta.values[-1]
    assert np.isnan(theta[0])
    assert np.isfinite(theta[1])
    assert "the law of friction" in made.sentences[0]


# --- systems of several phases ------------------------------------------------------------------


H, G, E = 1.0, 9.81, 0.5
POINT = {"system": "bouncing-point", "parameters": {"g": G, "e": E}, "initial": {"h": H}}
T = math.sqrt(2 * H / G)


def test_a_point_bounces_as_its_closed_form() -> None:
    """Bounce n is at T (1 + 2 e + ... + 2 e^n), T = sqrt(2 h/g)."""
    made = tt.derivatives.sensitivities(POINT, ["g", "e", "h"], until=1.2, output_times=[1.2])
    n = np.arange(made.events.sizes["event"])
    sums = 1 + 2 * np.array([sum(E**k for k in range(1, i + 1)) for i in n])
    slopes = 2 * np.array([sum(k * E ** (k - 1) for k in range(1, i + 1)) for i in n])
    expected = np.transpose([-T * sums / (2 * G), T * slopes, T * sums / (2 * H)])
    assert len(n) == 3
    assert_near(made.events.time.values, expected, 1e-14)
    assert_near(made.phases.time.values[1:], expected, 1e-14)
    since = 1.2 - T * sums[-1]  # h = v t - g t^2/2, v = g T e^3
    v = G * T * E**3
    by = np.array([v / (2 * G), 3 * v / E, v / (2 * H)]) * since - [since**2 / 2, 0, 0]
    assert_near(made.trajectory.h.values[-1], by - (v - G * since) * expected[-1], 1e-13)


def test_a_block_on_a_belt_slips_as_its_closed_form(page: dict) -> None:
    belt = page["belt"]
    wrt = ["mu", "k", "sticks", "belt", "m"]
    start = {"system": "block-on-a-belt", "parameters": belt, "initial": {"x": 0}}
    made = tt.derivatives.sensitivities(start, wrt, until=4.0, output_times=[4.0])

    def times(b: dict) -> np.ndarray:
        return np.sort(np.ravel(stick_slip(b, 3)))[: made.events.sizes["event"]]

    for k, name in enumerate(wrt):
        h = 1e-3 * belt[name]
        at = {i: times({**belt, name: belt[name] + i * h}) for i in (-2, -1, 1, 2)}
        slope = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h)
        assert_near(made.events.time.values[:, k], slope, 1e-9, relative=True)


def changed(name: str, jump: Any, **fields: Any) -> dict:
    """A point that falls until it meets the ground, with another jump."""
    point = SYSTEMS["bouncing-point"]
    fall = dataclasses.replace(
        point.phases["fall"], exits=(Exit("ground", ("fall", "rest"), jump),), **fields
    )
    phases = {"fall": fall, "rest": point.phases["rest"]}
    tt.extending.register(dataclasses.replace(point, name=name, phases=phases))
    return {**POINT, "system": name}


def test_a_jump_that_takes_no_derivatives_is_refused_with_its_name() -> None:
    def bounce(x: Any, world: Any) -> Next:
        return Next("fall", x._replace(v=math.sqrt(x.v * x.v)), zeros={"ground": 1})

    start = changed("plain-point", bounce)
    with refusal("the jump by `ground` from phase `fall` of `plain-point` must take"):
        tt.derivatives.sensitivities(start, ["g"], until=1.0)


def test_a_comparison_that_anything_changes_leaves_no_derivative() -> None:
    """The point stops where it is exactly as fast as the limit."""
    limit = G * T / 4  # the unit of time is 1/4 s

    def bounce(x: Any, world: Any) -> Next:
        v = world.body.e * -x.v
        phase = "fall" if v >= world.body.e * limit * (1 - 1e-12) else "rest"
        return Next(phase, x._replace(v=v, h=0 * v), zeros={"ground": 1})

    start = changed("edge-point", bounce)
    made = tt.derivatives.sensitivities(start, ["g"], until=0.8, output_times=[0.2, 0.8])
    assert made.trajectory.valid_within.values[-1, 0] < 1e-9
    assert np.isfinite(made.trajectory.h.values[0])
    assert np.isnan(made.trajectory.h.values[1])
    assert "no derivatives by parameters.g: what follows `ground`" in made.sentences[0]


def test_errors_grow_as_the_closed_form() -> None:
    """By the product of the matrices of a flight, a bounce and a flight."""
    growth = tt.derivatives.lyapunov(POINT, until=0.8, rows=2)
    second = 2.0 ** round(math.log2(math.sqrt(1 / G)))
    g, t, end = G * second**2, T / second, 0.8 / second
    before = g * t  # the speed
    fall = np.array([[1, t], [0, 1]])
    bounce = np.array([[-E, 0], [g * (1 + E) / before, -E]])
    rise = np.array([[1, end - t], [0, 1]])
    expected = np.linalg.norm(rise @ bounce @ fall, 2)
    np.testing.assert_allclose(growth.factor.values[-1], expected, rtol=1e-12)

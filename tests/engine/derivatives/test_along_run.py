"""Derivatives along a run are those of central differences of whole runs."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from examples import PRESETS
from limits import assert_near

import tippetop as tt
from tippetop.engine.derivatives.sensitivities import differentiate
from tippetop.mechanics.systems import SYSTEMS
from tippetop.problem import Problem
from tippetop.runs.run import solve
from tippetop.scenario import build, reading


STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
"""Central differences of eighth order: f' = sum c (f(+k h) - f(-k h))/h."""
UNTIL = {
    "rolling-tippe-top": 0.1,
    "gliding-cylinder": 0.3,
    "rolling-cylinder": 0.4,
    "rolling-spheroid": 0.3,
    "ellipsoid": 0.095,
}
TURNED = {"ellipsoid": {"initial": {"theta": 0.1, "omega3": 155.0, "theta_dot": 0.3}}}
"""Starts at which no event happens."""
LAWS = {
    "coulomb": {"mu": 0.3, "eps": 0.01},
    "mixed": {"mu": 0.2, "mu_coulomb": 0.1, "eps": 0.01},
    "stribeck": {"mu": 0.2, "mu_static": 0.3, "v_s": 0.05, "eps": 0.01},
    "latitude": {"mu": 0.2, "mu_stem": 0.4},
    "none": {},
}


def changed(problem: Problem, name: str, value: float) -> Problem:
    """The problem with another number."""
    table, _, key = name.partition(".")
    if table == "friction":
        return dataclasses.replace(problem, friction=problem.friction._replace(**{key: value}))
    return dataclasses.replace(problem, **{table: {**getattr(problem, table), key: value}})


def columns(problem: Problem) -> tuple[dict[str, np.ndarray], Any]:
    """The columns of a run, of wider numbers both halves, and its events."""
    made = solve(problem)
    parts = {name: c.values.astype(np.longdouble) for name, c in made.columns().items()}
    whole = {
        name: values + parts.get(f"{name}_lo", 0)
        for name, values in parts.items()
        if not name.endswith("_lo")
    }
    return whole, made.events


def difference(
    problem: Problem, name: str, size: float
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Derivatives of columns, of event times and of theta there."""
    table, _, key = name.partition(".")
    given = {
        "parameters": problem.parameters,
        "friction": problem.friction._asdict(),
        "initial": problem.initial,
    }
    at, by_column, by_time, by_theta = given[table].get(key, 0.0), {}, 0.0, 0.0
    for k, factor in STENCIL.items():
        (ahead, after), (behind, before) = (
            columns(changed(problem, name, at + s * k * size)) for s in (1, -1)
        )
        for column, values in ahead.items():
            step = factor * (values - behind[column]) / size
            by_column[column] = by_column.get(column, 0.0) + step
        by_time = by_time + factor * (after.time - before.time) / size
        by_theta = by_theta + factor * (after.theta - before.theta) / size
    return by_column, np.asarray(by_time), np.asarray(by_theta)


def short(preset: str, until: float, **changes: Any) -> Problem:
    tables = reading.read(preset)
    tables["run"] = {"until": until, "output_times": np.linspace(0, until, 6).tolist()[1:]}
    for name, value in changes.items():
        tables[name] = value
    return build.problem(tables)


NOISE = {"double": 2e-14, "longdouble": 2e-17}
STEP = {"double": 2e-3, "longdouble": 1e-3}
"""Relative to the number."""


def assert_as_differences(problem: Problem, precision: str = "double") -> None:
    """Every derivative by every number, to 1e-8 of the largest of its column and what rounding does
    to differences.
    """
    numbers = {
        **{f"parameters.{name}": value for name, value in problem.parameters.items()},
        **{f"friction.{name}": value for name, value in problem.friction._asdict().items()},
        **{
            f"initial.{name}": value
            for name, value in problem.initial.items()
            if not isinstance(value, bool)
        },
    }
    made = solve(problem)
    derived, _ = differentiate(problem, list(numbers), made.times, made.events)
    runs = dataclasses.replace(problem, precision=precision)
    plain, events = columns(runs)
    for i, (name, value) in enumerate(numbers.items()):
        step = STEP[precision] * (abs(value) or (0.01 if name.startswith("parameters") else 1.0))
        expected, by_time, by_theta = difference(runs, name, step)
        expected |= {"event time": by_time, "event theta": by_theta}
        found = {
            column: c.values[:, i]
            for column, c in derived["trajectory"].items()
            if column != "time"
        }
        of_events = derived["events"]
        found |= {f"event {c}": of_events[c].values[:, i] for c in ("time", "theta")}
        sizes = {
            **{column: np.abs(values).max() for column, values in plain.items()},
            "event time": 1,
            "event theta": 4,
        }
        assert len(events.time) > 0
        for column, values in found.items():
            noise = NOISE[
                "double" if "event" in column else precision
            ]  # events are logged in doubles
            allowed = 1e-8 * np.abs(expected[column]).max() + noise * sizes[column] / step
            off = np.abs(values - expected[column]).max()
            assert off <= allowed, (name, column, off, allowed, np.abs(expected[column]).max())


CASES = [
    (name, form) for name, system in SYSTEMS.items() for form in system.forms if name in PRESETS
]
QUICK = [("tippe-top", "vector")]


@pytest.mark.parametrize(
    ("system", "form"),
    [pytest.param(*c, marks=() if c in QUICK else pytest.mark.slow) for c in CASES],
)
def test_every_system_and_form(system: str, form: str) -> None:
    precision = "double" if (system, form) in QUICK else "longdouble"
    begin = TURNED.get(system, {})
    problem = short(PRESETS[system], UNTIL.get(system, 0.12), form=form, **begin)
    assert_as_differences(problem, precision)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_every_smooth_law(law: str) -> None:
    assert_as_differences(
        short("inverting", 0.12, friction={"law": law, **LAWS[law]}), "longdouble"
    )


# --- what the library says


@pytest.mark.slow
def test_datasets_by_parameter_and_second_derivatives_are_differences_of_first_ones() -> None:
    problem, wrt, h = short("inverting", 0.12), ["friction.mu", "initial.omega3"], 1e-5
    found = tt.derivatives.sensitivities(problem, wrt, order=2)
    assert found.trajectory.theta.dims == ("time", "parameter")
    assert list(found.trajectory.parameter.values) == wrt
    assert list(found.trajectory.unit.values) == ["s m-1", "rad s-1"]
    assert found.events.time.dims == ("event", "parameter")
    assert found.second.L.dims == ("time", "parameter", "parameter_2", "xyz")
    ahead, behind = (
        tt.derivatives.sensitivities(changed(problem, "friction.mu", 0.3 + s * h), wrt).trajectory
        for s in (1, -1)
    )
    for name in ("theta", "L", "orientation", "normal_force"):
        expected = ((ahead[name] - behind[name]) / (2 * h)).values
        second = found.second[name].sel(parameter_2="friction.mu").values
        np.testing.assert_allclose(second, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


@pytest.mark.slow
def test_second_derivatives_do_not_change_the_first_ones_of_times_of_events() -> None:
    """The level of the event depends on the body, of which the second derivative is not zero."""
    level = tt.extending.Event("level", "level", lambda s, b: s.z - 2 * b.I1 / (b.m * b.R**2))
    options: dict[str, Any] = {"start": {"theta": 0.8, "omega3": 1.0}, "until": 0.1}
    first, second = (
        tt.derivatives.sensitivities(
            "inverting", ["parameters.R"], order=order, events=[level], **options
        ).events.time
        for order in (1, 2)
    )
    assert first.size
    np.testing.assert_allclose(second, first, rtol=1e-12)


def test_a_number_alone_has_the_derivatives_that_it_has_among_others() -> None:
    problem = short("inverting", 0.12)
    alone, both = (
        tt.derivatives.sensitivities(problem, wrt).trajectory.theta.sel(parameter="friction.mu")
        for wrt in (["friction.mu"], ["friction.mu", "initial.omega3"])
    )
    assert_near(alone, both, 1e-12, relative=True)


def test_a_flag_and_a_number_that_is_not_given() -> None:
    """centre_at_rest makes the slip depend on omega3; phi_dot, not given, is zero and still has a
    derivative.
    """
    problem = short(
        "inverting", 0.12, initial={"theta": 0.1, "omega3": 155.0, "centre_at_rest": True}
    )
    wrt = ["initial.omega3", "initial.phi_dot"]
    found = tt.derivatives.sensitivities(problem, wrt).trajectory.nu_y.values
    for i, (name, size) in enumerate(zip(wrt, (0.1, 0.01), strict=True)):
        expected, *_ = difference(problem, name, size)
        assert np.abs(found[:, i] - expected["nu_y"]).max() < 1e-8 * np.abs(expected["nu_y"]).max()

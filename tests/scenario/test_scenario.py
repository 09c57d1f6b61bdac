"""The door: bad input gets sentences, never a traceback; good input is understood as written."""

import math
import tomllib

import numpy as np
import pytest
from damage import changed
from hypothesis import HealthCheck, given, settings

from tippetop.errors import InputError
from tippetop.problem import Problem
from tippetop.runs import starting
from tippetop.scenario import build, reading


def sentences(*assignments: str) -> str:
    with pytest.raises(InputError) as caught:
        starting.load("inverting", list(assignments))
    return str(caught.value)


@pytest.mark.parametrize(
    ("assignment", "said"),
    [
        ("parameters.alpha=0.0", "`parameters.alpha` must be other than 0.0, but is 0.0."),
        ("parameters.I3=7e-6", "`parameters.I3` must be at most 2*I1"),
        (
            "parameters.gama=1",
            "unknown key `parameters.gama`. The keys of `parameters` are m, R, alpha, I1, I3, g.",
        ),
        ("friction.mu=-0.1", "`friction.mu` must be at least 0.0, but is -0.1."),
        ("friction.law=mixed", "`friction.eps` must be given, but is missing (numbers of another"),
        ("initial.theta=3.2", "`initial.theta` must be at most 3.14"),
        ("initial.psi_dot=1.0", "`initial.psi_dot` must be given alone"),
        ("initial.mu=0.2", "unknown key `initial.mu`; did you mean `friction.mu`?"),
        (
            "friction.eps=1e-3",
            "unknown key `friction.eps`: it belongs to law = 'coulomb' or 'mixed' or "
            "'stribeck'. The",
        ),
        ("system=tippetop", "but is 'tippetop'. Did you mean `tippe-top`?"),
        ("run.until=0", "`run.until` must be greater than 0"),
        ("run.events=['eclipse']", "`run.events` must be of turning"),
        (
            "run.precision=half",
            "`run.precision` must be 'double', 'longdouble' or 'quad', but is 'half'.",
        ),
        ("form=angle", "`form` must be 'auto', 'vector' or 'euler', but is 'angle'."),
    ],
)
def test_a_fault_gets_its_sentence(assignment: str, said: str) -> None:
    assert said in sentences(assignment)


def test_all_faults_are_reported_at_once() -> None:
    said = sentences("parameters.alpha=2", "friction.mu=-1", "run.until=-1", "colour=red")
    assert all(key in said for key in ("parameters.alpha", "friction.mu", "run.until", "colour"))


def test_euler_form_refuses_a_pole_and_vector_form_takes_it() -> None:
    assert "singular" in sentences("form=euler", "initial.theta=0.0")
    assert starting.load("inverting", ["initial.theta=0.0"]).start()[0] == 0.0


def test_the_grid_ends_with_until() -> None:
    grid = starting.load("inverting", ["run.until=1.05", "run.output_step=0.1"]).times[:]
    np.testing.assert_allclose(grid, [*np.arange(11) / 10, 1.05], rtol=1e-12)


def test_centre_at_rest_means_no_velocity_of_the_centre() -> None:
    problem = starting.load("inverting", ["initial.centre_at_rest=true"])
    names = problem.variables.names
    state = dict(zip(names, problem.start(), strict=True))
    assert abs(state["rx_dot"]) < 1e-15
    assert abs(state["ry_dot"]) < 1e-15
    assert math.hypot(state["ux"], state["uy"]) > 0.09


def test_psi_dot_stands_for_omega3() -> None:
    tables = tomllib.loads(reading.presets()["inverting"])
    tables["initial"] = {"theta": 0.4, "phi_dot": 3.0, "psi_dot": 50.0}
    by_psi = build.problem(tables).start()
    tables["initial"] = {"theta": 0.4, "phi_dot": 3.0, "omega3": 50.0 + 3.0 * math.cos(0.4)}
    np.testing.assert_allclose(by_psi, build.problem(tables).start(), rtol=4e-16, atol=1e-16)


def test_another_law_takes_no_number_of_the_old_one() -> None:
    """Their units differ: mu of viscous friction is in s/m."""
    assert "`friction.mu` must be given, but is missing" in sentences("friction.law=coulomb")
    law = {"law": "coulomb", "mu": 0.2}
    changes = ["friction.mu=0.2", "friction.law=coulomb"]
    assert reading.override(reading.read("inverting"), changes)["friction"] == law


def attempt(tables: dict) -> tuple[Problem | None, list[str]]:
    try:
        return build.problem(tables), []
    except InputError as error:
        return None, error.sentences


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(changed(tomllib.loads(reading.presets()["inverting"])))
def test_random_damage_gives_sentences_or_a_problem(tables: dict) -> None:
    problem, said = attempt(tables)
    assert problem is not None or said
    assert all(s.rstrip().endswith((".", "?")) and "Traceback" not in s for s in said)
    if problem is not None:
        assert np.all(np.isfinite(problem.start()))

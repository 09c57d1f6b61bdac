"""Warnings: what is allowed, but hardly meant; and an eps that has not converged."""

import json
from pathlib import Path

import pytest
from typed import refused

from tippetop.cli import main
from tippetop.runs import forecast, starting
from tippetop.runs.run import solve
from tippetop.scenario import build, reading
from tippetop.scenario.doubts import doubts


def test_presets_are_not_suspicious() -> None:
    for name in reading.presets():
        assert doubts(starting.load(name)) == []


@pytest.mark.parametrize(
    ("sets", "word"),
    [
        (["initial.omega3="], "`initial.omega3` is not given: this top does not spin"),
        (["initial.theta="], "`initial.theta` is not given"),
        (["parameters.m=35.0", "parameters.I1=5.2e-3", "parameters.I3=5.6e-3"], "looks like grams"),
        (
            ["parameters.I1=3e-9", "parameters.I3=3e-9"],
            "`parameters.I3` is 3e-09 kg m2, 0.000375 times m R^2",
        ),
        (["parameters.R=25.0", "parameters.I1=4.7", "parameters.I3=5.0"], "looks like millimetres"),
    ],
)
def test_a_doubt_is_a_warning_and_changes_no_exit_code(sets: list[str], word: str, capsys) -> None:
    tables = reading.override(reading.read("inverting"), sets)
    assert any(word in sentence for sentence in doubts(build.problem(tables)))
    with pytest.raises(SystemExit) as end:
        main(["check", "inverting", *(f"--set={text}" for text in sets), "--json"])
    assert end.value.code in (0, None)
    said = capsys.readouterr()
    assert any(word in sentence for sentence in json.loads(said.out)["warnings"])
    assert "tippetop: warning: " in said.err
    assert word in said.err


def test_check_of_a_plan_takes_no_end(file: Path) -> None:
    assert "`--until` cannot be used with a plan" in refused(f"check {file} --until 1")


def test_a_top_that_begins_below_its_plane_is_doubtful() -> None:
    (sentence,) = doubts(starting.load("gliding-heavy-top", ["initial.theta=3.0"]))
    assert "beyond pi/2: this body has fallen" in sentence


def test_a_start_at_rest_under_exact_coulomb_friction_can_be_confirmed() -> None:
    law = ["friction=", "friction.law=coulomb", "friction.mu=0.3"]
    (sentence,) = doubts(starting.load("inverting", law))
    assert "confirms this start" in sentence
    for confirmed in ("nu_x=0", "centre_at_rest=false"):
        assert doubts(starting.load("inverting", [*law, f"initial.{confirmed}"])) == []


def test_torques_that_bring_a_body_to_rest_are_doubtful() -> None:
    (sentence,) = doubts(starting.load("inverting", ["friction.mu_r=1e-4", "friction.mu_d=1e-4"]))
    assert sentence.startswith("`friction.mu_r` and `friction.mu_d` can bring this body to rest")


def test_check_says_the_limits_of_rolling() -> None:
    found = forecast.assessment(starting.load("rolling"))
    for name in ("lambda_pi", "gamma_star"):
        assert found["thresholds"][name]["value"] > 0
    assert "the inverted spin of this lambda is" in found["fate"]


@pytest.mark.parametrize(
    "sets",
    [
        [],
        ["initial.phi_dot=3"],
        ["initial.nu_x=0.1"],
        ["initial.nu_y=0.1"],
        ["friction.mu=0", "initial.nu_x=0.1"],
        ["initial.theta_dot=0.1"],
    ],
)
def test_only_a_start_that_stays_upright_is_said_to_stay(sets: list[str]) -> None:
    problem = starting.load("inverting", ["initial.theta=", *sets], until=1.0)
    stays = solve(problem, keep=False).report["theta_end"] == 0
    assert any("stays there" in sentence for sentence in doubts(problem)) == stays


@pytest.mark.parametrize(
    "start", [[], ["initial.centre_at_rest=true"], ["initial.nu_x=0.1"], ["initial.nu_x=0"]]
)
@pytest.mark.parametrize("law", ["viscous", "coulomb", "none"])
def test_check_states_how_the_contact_starts_where_that_is_left_out(
    law: str, start: list[str]
) -> None:
    """Under Coulomb's law itself it decides that the top rolls: a doubt."""
    sets = [f"friction.law={law}", *(["friction.mu=0.3"] if law != "none" else []), *start]
    problem = starting.load("inverting", sets, until=0.2)
    left_out = not start and law != "none"
    assert forecast.assessment(problem).get("contact_point", "").startswith("at rest") == left_out
    doubted = any("it may never slide" in sentence for sentence in doubts(problem))
    assert doubted == (left_out and law == "coulomb")
    if doubted:
        assert solve(problem).report["contact_phases"]["counts"] == {"roll": 1}

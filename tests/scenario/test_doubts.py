"""Warnings: what is allowed, but hardly meant; and an eps that has not converged."""

import json
from pathlib import Path

import pytest

from tippetop.cli import main, outcome
from tippetop.runs import forecast, regularisation
from tippetop.scenario import build, reading
from tippetop.scenario.doubts import doubts


def test_presets_are_not_suspicious() -> None:
    for name in reading.presets():
        assert doubts(build.load(name)) == []


def test_a_top_that_begins_below_its_plane_is_suspicious() -> None:
    assert doubts(build.load("gliding-heavy-top", ["initial.theta=1.57"])) == []
    (sentence,) = doubts(build.load("gliding-heavy-top", ["initial.theta=3.0"]))
    assert "beyond pi/2: this body has fallen" in sentence


@pytest.mark.parametrize(
    ("sets", "word"),
    [
        (["initial.omega3="], "`initial.omega3` is not given: this top does not spin"),
        (["initial.theta="], "`initial.theta` is not given"),
        (["parameters.m=35.0", "parameters.I1=5.2e-3", "parameters.I3=5.6e-3"], "looks like grams"),
        (
            ["parameters.I1=9e-5", "parameters.I3=9e-5"],
            "`parameters.I1` is 9e-05 kg m2, 11.2 times m R^2",
        ),
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
    arguments = [part for text in sets for part in ("--set", text)]
    with pytest.raises(SystemExit) as end:
        main(["check", "inverting", *arguments, "--json"])
    assert end.value.code in (0, None)
    said = capsys.readouterr()
    assert any(word in sentence for sentence in json.loads(said.out)["warnings"])
    assert "tippetop: warning: " in said.err
    assert word in said.err


def test_check_of_a_plan_takes_no_end(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(["check", str(file), "--until", "1"]) == 2
    assert "`--until` cannot be used with a plan" in capsys.readouterr().err


def test_a_potential_beyond_the_doubles_is_refused(capsys) -> None:
    with pytest.raises(SystemExit) as end:
        main(["potential", "inverting", "--D", "1e300", "--lambda", "1e300"])
    assert end.value.code == 2
    assert "must leave V within the doubles" in capsys.readouterr().err


def test_lambda_in_another_unit_is_said(capsys) -> None:
    with pytest.raises(SystemExit) as end:
        main(["potential", "inverting", "--D", "1e-4", "--lambda", "4.0"])
    assert end.value.code in (0, None)
    assert "tippetop: warning: lambda = 4" in capsys.readouterr().err


def test_an_eps_that_has_not_converged_is_said() -> None:
    assert regularisation._converged(1.0, 1.001) == ""
    assert "half of it changes that time by 50 %" in regularisation._converged(1.0, 2.0)
    assert "whether it inverts" in regularisation._converged(1.0, None)
    assert regularisation._converged(None, None) == ""


def test_torques_that_bring_a_body_to_rest_are_doubtful() -> None:
    (sentence,) = doubts(build.load("inverting", ["friction.mu_r=1e-4", "friction.mu_d=1e-4"]))
    assert sentence.startswith("`friction.mu_r` and `friction.mu_d` can bring this body to rest")


def test_check_says_the_limits_of_rolling() -> None:
    found = forecast.assessment(build.load("rolling"))
    for name in ("lambda_pi", "gamma_star"):
        assert found["thresholds"][name]["value"] > 0
    assert "the inverted spin of this lambda is" in found["fate"]


def test_gamma_star_is_where_two_wells_begin() -> None:
    """gamma* = 2.1213 for alpha = 0.3, sigma = 2.5 [section 5, item 4]."""
    from tippetop.mechanics.contact.body import Touch
    from tippetop.mechanics.friction import Frictionless
    from tippetop.mechanics.systems import SYSTEMS
    from tippetop.mechanics.theory.thresholds import two_wells_from

    I3 = 8e-6 / 2.5
    parameters = {"m": 0.02, "R": 0.02, "alpha": 0.3, "I1": I3, "I3": I3, "g": 9.82}
    body: Touch = SYSTEMS["rolling-tippe-top"].body_of(parameters, Frictionless())
    assert two_wells_from(body) == pytest.approx(2.1213, abs=5e-5)

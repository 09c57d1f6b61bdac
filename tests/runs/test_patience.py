"""A run that takes long says so once, and why."""

from types import SimpleNamespace

import pytest

from tippetop.cli import outcome
from tippetop.runs import patience
from tippetop.runs.patience import Patience
from tippetop.scenario import build


STIFF = ["initial.omega3=1e-3", "initial.nu_x=0.1", "initial.centre_at_rest="]


def said(preset: str, assignments: list[str], step: float, seconds_per_step: float) -> list[str]:
    """The sentences of a run with steps like these."""
    problem, sentences, now = build.load(preset, assignments), [], [0.0]
    follow = Patience(sentences.append, lambda: now[0])
    for slices in range(20):
        now[0] = slices * 1000 * seconds_per_step
        follow(
            SimpleNamespace(problem=problem, t_end=slices * 1000 * step, monitor=SimpleNamespace(steps=1000 * slices))
        )
    return sentences


def test_a_stiff_run_says_how_long_it_takes_and_why() -> None:
    (sentence,) = said("leine-glocker-drilling", STIFF, 1e-9, 1e-3)
    assert "will take about 6e+06 s (1.7e+03 hours)" in sentence
    assert "on a disc that hardly turns is stiff" in sentence


def test_a_long_run_with_ordinary_steps_is_not_called_stiff() -> None:
    (sentence,) = said("inverting", ["run.until=1e6"], 1e-2, 1e-3)
    assert "1e+05 s" in sentence
    assert "stiff" not in sentence


def test_a_short_run_says_nothing() -> None:
    assert said("inverting", [], 5e-3, 1e-6) == []
    assert said("inverting", [], 5e-3, 0.01) == []


def test_one_slow_slice_says_nothing_of_the_rest() -> None:
    problem, sentences, now = build.load("inverting", []), [], [0.0]
    follow = Patience(sentences.append, lambda: now[0])
    for slices in range(20):
        now[0] += 60.0 if slices == 3 else 1.0  # a compilation, or somebody else's work
        follow(SimpleNamespace(problem=problem, t_end=slices * 0.1, monitor=SimpleNamespace(steps=slices)))
    assert sentences == []


def test_the_command_warns(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(patience, "LONG", 0.0)
    monkeypatch.setattr(patience, "AGAIN_AFTER", 0.0)
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 64)
    assert outcome(["run", "inverting", "--until", "8"]) == 0
    assert capsys.readouterr().err.count("will take about") == 1

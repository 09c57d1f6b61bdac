"""A run that takes long says so once, and why."""

from dataclasses import replace
from pathlib import Path

import pytest

import tippetop as tt
from tippetop.problem import Problem
from tippetop.runs import cost
from tippetop.runs.cost import Patience
from tippetop.runs.integration import Integration
from tippetop.runs.reporting import RunProgress
from tippetop.scenario import build


STIFF = ["initial.omega3=1e-3", "initial.nu_x=0.1", "initial.centre_at_rest="]


def said(
    preset: str, assignments: list[str], step: float, seconds_per_step: float, phases: int = 0
) -> list[str]:
    """The sentences of a run with steps like these, and so many phases of the contact in a thousand
    of them.
    """
    problem, sentences, now = build.load(preset, assignments), [], [0.0]
    follow = Patience(sentences.append, lambda: now[0])
    for slices in range(20):
        now[0] = slices * 1000 * seconds_per_step
        follow(under_way(problem, slices * 1000 * step, 1000 * slices, phases * slices))
    return sentences


def under_way(problem: Problem, t_end: float, steps: int, phases: int = 0) -> RunProgress:
    """The progress of a run that has come this far."""
    start = Integration(problem).progress()
    return replace(start, t_end=t_end, steps=steps, phases={"counts": {"flight": phases}})


def test_a_stiff_run_says_how_long_it_takes_and_why() -> None:
    (sentence,) = said("leine-glocker-drilling", STIFF, 1e-9, 1e-3)
    assert "will take about 6e+06 s (1.7e+03 hours)" in sentence
    assert "on a disc that hardly turns is stiff" in sentence


def test_a_run_of_many_bounces_is_not_called_stiff() -> None:
    """Sphere and stem under Coulomb's law itself, e_n = 1: steps are short because flights are."""
    (sentence,) = said("leine-glocker-stem", ["contact.e_n=1"], 1e-6, 1e-2, phases=990)
    assert "because the contact changes its phase about as often" in sentence
    assert "stiff" not in sentence


def test_a_long_run_with_ordinary_steps_is_not_called_stiff() -> None:
    (sentence,) = said("inverting", ["run.until=1e6"], 1e-2, 1e-3)
    assert "1e+05 s" in sentence
    assert "stiff" not in sentence


def test_a_short_run_says_nothing() -> None:
    assert said("inverting", [], 5e-3, 1e-6) == []
    assert said("inverting", [], 5e-3, 0.01) == []


def test_who_has_waited_half_a_minute_hears_of_as_much_that_is_left() -> None:
    """Not at once: a run of a few minutes is no matter."""
    (sentence,) = said("inverting", ["run.until=100"], 1e-3, 3e-3)
    assert "will take about 2.6e+02 s" in sentence
    assert said("inverting", ["run.until=20"], 1e-3, 3e-3) == []


def test_a_call_from_python_warns(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A run, one that is stored, its continuation and its certificate: each says that it will take
    long.
    """
    monkeypatch.setattr(cost, "LONG", 0.0)
    monkeypatch.setattr(cost, "AGAIN_AFTER", 0.0)
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 64)
    for call in (
        lambda: tt.run("inverting", until=4.0),
        lambda: tt.run("inverting", until=4.0, out=tmp_path / "run.zarr", progress=True),
        lambda: tt.resume(tmp_path / "run.zarr", until=8.0),
        lambda: tt.open(tmp_path / "run.zarr").certify(4.0),
    ):
        with pytest.warns(UserWarning, match="will take about"):
            call()

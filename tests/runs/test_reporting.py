"""The record of how far a run has come: each slice makes another one, and none changes
afterwards.
"""

import copy
from dataclasses import FrozenInstanceError

import pytest

from tippetop.runs import reporting, starting
from tippetop.runs.run import solve


def test_what_a_callback_was_given_stays_what_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 64)
    kept: list[reporting.RunProgress] = []
    reports = []

    def follow(progress: reporting.RunProgress) -> None:
        kept.append(progress)
        reports.append(copy.deepcopy(reporting.report(progress)))

    done = solve(starting.load("inverting"), follow)
    assert [reporting.report(progress) for progress in kept] == reports
    assert sorted({progress.steps for progress in kept}) == [progress.steps for progress in kept]
    assert kept[-1].steps < done.report["steps"]
    with pytest.raises(FrozenInstanceError):
        kept[0].steps = 0  # type: ignore[misc]

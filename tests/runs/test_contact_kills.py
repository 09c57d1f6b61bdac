"""A run that gets SIGKILL right after a checkpoint in each phase of its contact, and is resumed: the same bytes."""

import os
import signal
import warnings
from pathlib import Path

import pytest
from nightly import at_night
from stores import assert_same
from touching import STANDING, THROWN

from tippetop.problem import Problem
from tippetop.runs import recording, resuming
from tippetop.runs.integration import Integration
from tippetop.scenario import build
from tippetop.store import root


RUNS = {"thrown": THROWN, "stands": STANDING}
PLACES = {
    "thrown": [("dry-slip", 0), ("flight", 0), ("roll", 0)],
    "stands": [("slip", 0), ("slip", 1), ("flight", 1), ("both", 0)],
}
"""Kind of phase, and ball (sphere, stem), of each run."""


def problem_of(name: str) -> Problem:
    until = RUNS[name]["run"]["until"]
    return build.problem({**RUNS[name], "run": {"until": until, "output_step": 1e-3}})


def killed(name: str, store: Path, place: tuple[str, int], count: int) -> bool:
    """Records a run in a process of its own, which is killed at its count-th checkpoint in a phase; whether it was."""
    left = [count]

    def kill(integration: Integration) -> None:
        left[0] -= (integration.driver.kind, integration.driver.ball) == place
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12: a fork has none of its other threads
        child = os.fork()
    if child == 0:
        try:
            recording.COMMIT_EVERY = 0.0
            recording.record(problem_of(name), store, progress=kill)
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.parametrize(("name", "steps", "counts"), [at_night("thrown", 3, (1,)), at_night("stands", 3, (1,))])
def test_a_kill_in_any_phase_leaves_no_trace(
    name: str, steps: int, counts: tuple[int, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", steps)
    recording.record(problem_of(name), tmp_path / "whole")
    for place in PLACES[name]:
        for count in counts:
            store = tmp_path / f"{place[0]}-{place[1]}-{count}"
            assert killed(name, store, place, count), place
            assert root.attributes(store)["status"] == "running"
            resuming.resume(store)
            assert_same(store, tmp_path / "whole")

"""A run that gets SIGKILL right after a checkpoint in each phase of its contact, and is resumed:
the same bytes.
"""

import os
import signal
import warnings
from pathlib import Path
from typing import Any

import pytest
from nightly import at_night
from stores import assert_same
from touching import BOUNCE, ROCKING, STANDING, THROWN

from tippetop.problem import Problem
from tippetop.runs import recording, resuming
from tippetop.runs.integration import Integration
from tippetop.runs.reporting import RunProgress
from tippetop.scenario import build
from tippetop.store import root


ON_STEM: dict[str, Any] = {
    "system": "tippe-top",
    "parameters": {
        "m": 7.971e-3,
        "R": 1.55e-2,
        "alpha": 0.1688,
        "I1": 7.259e-7,
        "I3": 7.694e-7,
        "g": 9.81,
    },
    "friction": {"law": "coulomb", "mu": 0.32},
    "stem": {"r": 3e-3, "h": 2.45e-2},
    "contact": {"e_n": 0.5},
    "initial": {"theta": 2.992, "phi_dot": 11.8, "omega3": -79.9, "theta_dot": 4.7},
    "run": {"until": 0.08},
}
"""A top that bounces on its stem, slides on it, rolls on it, and slides again."""

DRILLS: dict[str, Any] = {
    **STANDING,
    "friction": {"law": "contensou", "mu": 0.3, "patch": 2e-3, "mu_r": 0.0},
    "contact": {"e_n": 0.0},
}
"""A top that rocks from its sphere to its stem, and stands on both, through every region of
friction that drills.
"""

LOADED: dict[str, Any] = {
    **BOUNCE,
    "friction": {"law": "coulomb", "mu": 0.3, "mu_r": 1e-4, "mu_d": 1e-4},
}
"""A top that bounces under torques of its contact, and rolls."""

RUNS = {
    "thrown": THROWN,
    "stands": STANDING,
    "bounces": BOUNCE,
    "on-stem": ON_STEM,
    "drills": DRILLS,
    "rocks": ROCKING,
    "loaded": LOADED,
}
PLACES = {
    ("thrown", "double"): [("slip", 1), ("flight", 1), ("roll", 1)],
    ("stands", "double"): [
        ("slip", 1),
        ("stem-slip", 1),
        ("stem-flight", 1),
        ("flight", 2),
        ("both", 1),
    ],
    ("bounces", "double"): [("flight", 5), ("roll", 2)],
    ("on-stem", "double"): [
        ("stem-flight", 2),
        ("stem-slip", 1),
        ("stem-roll", 1),
    ],
    ("drills", "double"): [
        ("slip-between", 1),
        ("stem-slip-outside", 2),
        ("both-between-outside", 1),
    ],
    ("rocks", "double"): [("slip-inside", 3), ("rest", 1)],
    ("rocks", "longdouble"): [("rest", 1)],
    ("loaded", "double"): [("flight", 2), ("roll", 2)],
}
"""Phase, and which of the checkpoints in such phases, of each run and precision."""
STEPS = 3  # a slice: a phase of four is written in two


def problem_of(name: str, precision: str) -> Problem:
    until = RUNS[name]["run"]["until"]
    run = {"until": until, "output_step": 1e-3, "precision": precision}
    return build.problem({**RUNS[name], "run": run})


def killed(problem: Problem, store: Path, place: str, count: int) -> bool:
    """Records a run in a process of its own, which is killed at its count-th checkpoint in a phase;
    whether it was.
    """
    left = [count]
    made: list[Integration] = []

    def integration(*arguments: Any) -> Integration:
        made.append(Integration(*arguments))
        return made[0]

    def kill(_: RunProgress) -> None:
        driver: Any = made[0].driver
        left[0] -= driver.track.name == place
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)

    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # Python 3.12: a fork has none of its other threads
        child = os.fork()
    if child == 0:
        try:
            recording.COMMIT_EVERY = 0.0
            recording.Integration = integration  # type: ignore[misc, assignment]
            recording.record(problem, store, progress=kill)
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.parametrize(("name", "precision"), [at_night(*run) for run in PLACES])
def test_a_kill_in_any_phase_leaves_no_trace(
    name: str, precision: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", STEPS)
    problem = problem_of(name, precision)
    recording.record(problem, tmp_path / "whole")
    for place, count in PLACES[name, precision]:
        store = tmp_path / f"{place}-{count}"
        assert killed(problem, store, place, count), store.name
        assert root.attributes(store)["status"] == "running"
        resuming.resume(store)
        assert_same(store, tmp_path / "whole")

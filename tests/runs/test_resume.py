"""Long runs cannot be lost: whatever interrupts them, the finished store is that of an undisturbed
run.
"""

import contextlib
import dataclasses
import errno
import json
import os
import shutil
import signal
import time
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from forked import Forked
from nightly import at_night
from stores import (
    PRELUDE,
    TURNING,
    acknowledged,
    assert_same,
    ended,
    short_slices,
    turning,
    wait_until,
)
from typed import typed

import tippetop
from tippetop.cli import outcome
from tippetop.problem import Problem
from tippetop.runs import recording
from tippetop.runs.integration import Integration
from tippetop.runs.reporting import report
from tippetop.runs.run import solve
from tippetop.runs.sinks import Memory
from tippetop.store.folder import Folder


UNTIL = 70.0  # [s]: eleven short slices
KEYFRAMES = ["run.output_step=", "run.output=keyframes", "run.keyframe_steps=100"]


def start(*arguments: str, prelude: str = PRELUDE) -> Forked:
    return Forked(list(arguments), prelude)


def running(store: Path, until: float = UNTIL, *sets: str) -> list[str]:
    words = [word for s in (*TURNING, "run.output_step=0.01", *sets) for word in ("--set", s)]
    return ["run", "inverting", *words, "--until", str(until), "--out", str(store)]


def begun(store: Path, until: float = 1e6) -> Forked:
    """A run that has acknowledged rows."""
    process = start(*running(store, until))
    wait_until(lambda: acknowledged(store) > 0, process)
    return process


def here(*arguments: str) -> int:
    """The exit code of a command that nobody stops, in this process, with the same slices and
    chunks.
    """
    with pytest.MonkeyPatch.context() as patch:
        short_slices(patch, commit_every=10.0)
        return outcome(list(arguments))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = tmp_path_factory.mktemp("whole") / "run.zarr"
    assert here(*running(store)) == 0
    return store


@pytest.mark.parametrize(
    ("until", "sets", "kills"),
    [
        (0.0, [], 2),
        (0.0, KEYFRAMES, 2),
        at_night(20.0, [], 2),
        at_night(5.0, KEYFRAMES, 5),
        at_night(0.0, ["run.output_step=0.001"], 50),
        at_night(0.0, ["run.precision=longdouble"], 2),
    ],
)
def test_killed_at_random_moments_and_resumed_it_is_bit_identical(
    until: float, sets: list[str], kills: int, tmp_path: Path, rng: np.random.Generator
) -> None:
    """A finished run until `until` is extended where there is one.

    Each kill falls at a random moment after at least one new commit, and costs no acknowledged row.
    """
    store, whole = tmp_path / "run.zarr", tmp_path / "whole.zarr"
    assert here(*running(whole, UNTIL * (kills - 1), *sets)) == 0
    if until:
        assert here(*running(store, until, *sets)) == 0
        arguments = ["resume", str(store), "--until", str(UNTIL * (kills - 1))]
    else:
        arguments = running(store, UNTIL * (kills - 1), *sets)
    for _ in range(kills):
        before = acknowledged(store)
        process = start(*arguments)
        wait_until(lambda before=before: acknowledged(store) > before, process)
        time.sleep(rng.uniform(0.0, 0.05))
        process.kill()
        assert ended(process)[0] == -signal.SIGKILL
        assert acknowledged(store) >= before
        arguments = ["resume", str(store)]
    assert here(*arguments) == 0
    assert_same(store, whole)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), at_night(signal.SIGTERM, 143)])
def test_asked_to_stop_it_stops_at_a_commit_and_says_how_to_go_on(
    number: int, code: int, undisturbed: Path, tmp_path: Path
) -> None:
    store = tmp_path / "run.zarr"
    process = begun(store, UNTIL)
    process.send_signal(number)
    found, err = ended(process)
    assert found == code
    assert f"tippetop resume {store}" in err
    assert here("resume", str(store)) == 0
    assert_same(store, undisturbed)


def test_a_run_whose_folder_was_replaced_stops_at_its_next_commit(tmp_path: Path) -> None:
    """Before, it went on for the whole run, and then claimed that everything is kept."""
    store = tmp_path / "run.zarr"
    process = begun(store)
    store.rename(tmp_path / "elsewhere")
    store.mkdir()
    (store / "ledger.jsonl").write_text("another's")
    code, err = ended(process)
    assert code == 5
    assert "was moved, removed or replaced" in err
    assert "Nothing acknowledged is lost" not in err


def test_of_two_runs_with_one_place_one_is_refused(tmp_path: Path) -> None:
    store = tmp_path / "run.zarr"
    both = [start(*running(store, 20.0)) for _ in range(2)]
    ends = [ended(process) for process in both]
    assert sorted(code for code, _ in ends) == [0, 5]
    assert any("must have one writer, but" in err for _, err in ends)
    assert [p.name for p in tmp_path.iterdir()] == ["run.zarr"]


def test_slices_of_wide_numbers_have_fewer_steps(tmp_path: Path) -> None:
    """A slice takes less time than the time between two commits."""
    steps: list[int] = []
    wide = turning(8.0, "run.precision=longdouble")
    recording.record(wide, tmp_path / "S.zarr", progress=lambda run: steps.append(run.steps))
    assert steps == [1024]


class HandedOver(Exception):
    """A run was stopped after a slice."""


def handed_over_after_every_slice(made: Problem) -> tuple[Integration, Memory]:
    """A run that a new process takes over, from a checkpoint, before its first slice and after
    each.
    """
    memory, integration = Memory(), Integration(made)

    def stop(_: object) -> None:
        raise HandedOver

    while integration.status is None:
        kept = json.loads(json.dumps(integration.snapshot(), allow_nan=False))
        integration = Integration(made)
        integration.restore(kept)
        with contextlib.suppress(HandedOver):
            integration.run(memory, stop)
    return integration, memory


@pytest.mark.parametrize(
    ("start", "output"),
    [
        ([], "times"),
        (["initial.theta_dot=2.0"], "events"),
        (["initial.theta=2.0", "initial.theta_dot=20.0"], "times"),
        (["form=euler"], "times"),
        at_night(["run.precision=longdouble"], "steps"),
        at_night(["run.precision=quad"], "times"),
    ],
)
def test_a_run_that_changes_hands_after_every_slice_keeps_every_bit(
    output: str, start: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It starts on a zero of theta', whose first step is searched in another way than the later
    ones.
    """
    monkeypatch.setattr("tippetop.runs.integration.STEPS_PER_SLICE", 3)
    made = dataclasses.replace(turning(1.0, *start), output=output)
    (integration, memory), whole = handed_over_after_every_slice(made), solve(made)
    np.testing.assert_array_equal(np.concatenate(memory.times), whole.times)
    np.testing.assert_array_equal(np.concatenate(memory.states), whole.rows)
    for name, column in memory.table().items():
        np.testing.assert_array_equal(column.values, whole.events[name].values, err_msg=name)
    assert len(whole.events.time) > 0
    assert report(integration.progress()) == whole.report, (
        "extremes of the force with their times, too"
    )


@pytest.mark.parametrize("output", ["events", "steps"])
def test_rows_at_events_or_steps(output: str) -> None:
    run = tippetop.run("inverting", until=2.0, output=output)
    times = run.trajectory.time.values
    assert (times[0], times[-1]) == (0.0, 2.0)
    assert np.all(np.diff(times) > 0)
    if output == "events":
        np.testing.assert_array_equal(times[1:-1], run.events.time)
    else:
        assert len(times) == run.summary.steps + 1


@pytest.mark.parametrize(("more", "code"), [("", 5), (f"--until {UNTIL}", 2)])
def test_a_run_killed_after_its_last_word_is_tidied_up(
    more: str, code: int, undisturbed: Path, tmp_path: Path
) -> None:
    """The ledger has its last form, but temporary files are still there: resume removes them."""
    store = tmp_path / "run.zarr"
    shutil.copytree(undisturbed, store)
    for left in ("tail-00000003", "ledger.jsonl.new", "trajectory/theta/c.9"):
        (store / left).write_text("{}")
    assert typed(f"resume {store} {more}") == code
    assert_same(store, undisturbed)


def test_a_disk_that_fails_at_the_end_leaves_a_run_to_be_resumed(
    undisturbed: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    store = tmp_path / "run.zarr"
    error = OSError(errno.EIO, os.strerror(errno.EIO))
    with monkeypatch.context() as patched:
        patched.setattr(Folder, "sync", Mock(side_effect=error))
        assert here(*running(store)) == 5
    assert f"Input/output error. Nothing acknowledged is lost: tippetop resume {store}" in (
        capsys.readouterr().err
    )
    assert here("resume", str(store)) == 0
    assert_same(store, undisturbed)

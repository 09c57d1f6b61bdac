"""A finished run is continued: bit by bit the run that would have been made at once."""

import functools
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from nightly import at_night
from stores import TURNING, assert_same, interrupted, state_of, turning
from typed import typed

import tippetop as tt
from tippetop.errors import StoreError
from tippetop.runs import recording, resuming, starting
from tippetop.store import provenance, root
from tippetop.store.folder import Folder


ROWS = "run.output_step=0.01"
OUTPUT = {
    "rows": [],
    "events": ["run.output_step=", "run.output=events"],
    "keyframes": ["run.output_step=", "run.output=keyframes", "run.keyframe_steps=300"],
    "listed": ["run.output_step=", "run.output_times=[0.0, 0.5, 3.25]"],
}


def made(store: Path, until: float, *sets: str) -> Path:
    recording.record(starting.load("inverting", [*TURNING, *sets], until), store)
    return store


def copied(store: Path, folder: Path) -> Path:
    """One that may be changed."""
    return shutil.copytree(store, folder / "run.zarr")


@pytest.fixture(scope="module")
def at_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The store of a run of that length which nothing has disturbed; not to be changed."""

    @functools.cache
    def run(until: float, *sets: str) -> Path:
        return made(tmp_path_factory.mktemp("whole") / "whole.zarr", until, *sets)

    return run


def said(store: Path) -> dict[str, Any]:
    """The root attributes as they stand there."""
    return root.root_of(store)


@pytest.mark.parametrize(
    "kind", [kind if kind in ("rows", "keyframes") else at_night(kind) for kind in OUTPUT]
)
def test_a_run_that_is_continued_is_that_of_one_go(
    kind: str, at_once: Callable[..., Path], tmp_path: Path
) -> None:
    """From 3.3 s, in the midst of a step, to 47 s, some slices later."""
    sets = [ROWS, *OUTPUT[kind]]
    store = made(tmp_path / "run.zarr", 3.3, *sets)
    assert typed(f"resume {store} --until 47") == 0
    assert_same(store, at_once(47.0, *sets))


def test_a_run_in_memory_that_is_saved_is_continued_too(tmp_path: Path) -> None:
    store = tt.run("inverting", until=2.0, output_step=0.01).save(tmp_path / "run.zarr")
    tt.resume(store, until=8.0)
    whole = tt.run("inverting", until=8.0, output_step=0.01, out=tmp_path / "whole.zarr").path
    assert_same(store, whole)


def test_an_interrupted_run_comes_to_its_end_first(tmp_path: Path) -> None:
    store = interrupted(tmp_path / "run.zarr", turning(100.0))
    with pytest.raises(StoreError, match="must have come to its end to be continued"):
        tt.resume(store, until=110.0)


def test_while_it_is_continued_it_is_an_interrupted_run_whose_chunks_are_marked(
    tmp_path: Path,
) -> None:
    store = made(tmp_path / "run.zarr", 20.0, *OUTPUT["keyframes"])
    assert state_of(store).seal
    with pytest.raises(KeyboardInterrupt):
        resuming.resume(store, Mock(side_effect=KeyboardInterrupt), until=60.0)
    assert said(store)["status"] == "running"
    assert not state_of(store).seal
    tt.resume(store)
    assert state_of(store).seal
    one, other = (store / "keyframes" / name / "c.0" for name in ("time", "step"))
    one.write_bytes(other.read_bytes())
    with pytest.raises(StoreError, match="a file of its chunk"):
        tt.open(store)


@pytest.mark.parametrize("step", ["put", *map(at_night, ("rename", "sync_one"))])
def test_whatever_fails_before_it_begins_leaves_the_finished_run(
    step: str, at_once: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = copied(at_once(10.0, ROWS), tmp_path)

    def fails(*_: object) -> None:
        raise OSError("the disk")

    with monkeypatch.context() as patch:
        patch.setattr(Folder, step, fails)
        with pytest.raises((StoreError, OSError)):
            tt.resume(store, until=20.0)
    assert tt.open(store).summary.status == "finished"
    tt.resume(store, until=20.0)
    assert_same(store, at_once(20.0, ROWS))


def test_a_run_that_an_event_has_ended_is_not_continued(tmp_path: Path) -> None:
    lifts = ["initial.omega3=300.0", "initial.theta=0.1", "initial.phi_dot=0.0", "friction.mu=0.3"]
    store = made(tmp_path / "run.zarr", 10.0, *lifts)
    with pytest.raises(
        StoreError, match=r"must have come to its end to be continued, but: the body lifted off"
    ):
        tt.resume(store, until=16.0)


def test_a_store_of_other_versions_is_refused(
    at_once: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = copied(at_once(3.0, ROWS), tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(provenance, "cpu", lambda: "another")
        with pytest.raises(StoreError, match="must be continued by the versions and processor"):
            tt.resume(store, until=4.0)
        run = tt.resume(store, until=4.0, accept_other_version=True)
    assert [before["cpu"] for before in run.attributes["begun_with"]] == [provenance.cpu()]
    assert run.attributes["cpu"] == "another"


def test_a_replay_is_not_continued(at_once: Callable[..., Path], tmp_path: Path) -> None:
    store = copied(at_once(3.0), tmp_path)
    words = f"--from 1 --until 2 --step 0.1 --out {tmp_path}/rows.zarr"
    assert typed(f"replay {store} {words}") == 0
    assert state_of(tmp_path / "rows.zarr").end is None
    with pytest.raises(StoreError, match="is a replay"):
        tt.resume(tmp_path / "rows.zarr", until=6.0)

"""The folder of single runs in a sweep is looked at before the sweep is continued."""

import shutil
from pathlib import Path

import pytest
from stores import assert_same

import tippetop
from tippetop.errors import StoreError
from tippetop.sweeps.plan import Plan
from tippetop.sweeps.store import RUNS, _there


def test_a_sweep_whose_runs_are_no_group_is_not_continued(file: Path, whole: Path, tmp_path: Path) -> None:
    store = tmp_path / "S.zarr"
    shutil.copytree(whole, store)
    plan = Plan.from_toml(file)
    (store / RUNS).mkdir(exist_ok=True)
    (store / RUNS / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    assert _there(store, plan) == store
    (store / RUNS / "zarr.json").write_bytes(b"\x02\x01\x33\x08 no metadata")
    with pytest.raises(StoreError, match=RUNS):
        _there(store, plan)


def test_a_run_of_another_top_is_not_taken_for_one_of_the_plan(file: Path, whole: Path, tmp_path: Path) -> None:
    """Exchanged, or continued to another end: each is sound, and not what the plan makes. A folder that is gone is
    made again."""
    store = Path(shutil.copytree(whole, tmp_path / "S.zarr"))
    with pytest.raises(StoreError, match="must lie outside of every store"):
        tippetop.resume(store / RUNS / "5", until=1.0)
    shutil.rmtree(store / RUNS / "5")
    tippetop.run("inverting", until=0.5, out=tmp_path / "other.zarr")
    shutil.copytree(tmp_path / "other.zarr", store / RUNS / "5")
    with pytest.raises(StoreError, match="must be the run that the plan makes, but has another"):
        tippetop.sweep(file, store, workers=1)
    shutil.rmtree(store / RUNS)
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)


def test_what_a_kill_leaves_in_a_finished_run_goes(file: Path, whole: Path, tmp_path: Path) -> None:
    """Between its seal and the end of its writer."""
    store = Path(shutil.copytree(whole, tmp_path / "S.zarr"))
    for left in ("checkpoint.json", "run.lock"):
        (store / RUNS / "5" / left).write_text("{}")
    tippetop.sweep(file, store, workers=1)
    assert_same(store, whole)
